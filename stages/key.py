"""Content keys: what a task's result depends on, as a document, and the document's hash."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

from stages.spec import StageSpec, Task
from store.schema import SCHEMAS

canonical = json.JSONEncoder(sort_keys=True, separators=(",", ":"), allow_nan=False).encode
"""A value as canonical JSON: equal values give equal text."""


def key_document(
    spec: StageSpec,
    *,
    config: Mapping[str, Any],
    params: Mapping[str, Any],
    inputs: Mapping[str, Mapping[str, str]],
    item: str,
    seed: int,
) -> dict[str, Any]:
    """All that the result of one task depends on, as plain JSON.

    Args:
        spec: The stage.
        config: The stage's own section of the recipe.
        params: The item's parameters that the stage reads. One with a companion `<name>_sha256` names a file, or files
            by name: their names and contents count, not the folders they lie in.
        inputs: stage -> item -> key.
        item: Item's id.
        seed: Seed of the item's generator.
    """
    named = {name: _file_names(value) if params.get(f"{name}_sha256") else value for name, value in params.items()}
    return {
        "stage": spec.name,
        "code_version": spec.code_version,
        "schema": f"{spec.schema} v{SCHEMAS[spec.schema].version}",
        "config": config,
        "params": named,
        "inputs": inputs,
        "item": item,
        "seed": seed,
    }


def _file_names(paths: Any) -> Any:
    """The file's name of a path, or of each path in a table."""
    if isinstance(paths, Mapping):
        return {name: _file_names(path) for name, path in paths.items()}
    return PurePath(str(paths)).name


def document_of(spec: StageSpec, task: Task) -> dict[str, Any]:
    """The key document of `task` under the stage's present code."""
    inputs = {stage: {item: entry["key"] for item, entry in items.items()} for stage, items in task.inputs.items()}
    return key_document(spec, config=task.config, params=task.params, inputs=inputs, item=task.item, seed=task.seed)


def key_of(document: Mapping[str, Any], config: str = "") -> str:
    """sha256 [hex] of the document's canonical JSON: that of its "config", a line break, that of the rest.

    Args:
        document: See `key_document`.
        config: The canonical JSON of `document["config"]` if it is known: a plan has one for many tasks.
    """
    rest = {name: value for name, value in document.items() if name != "config"}
    text = f"{config or canonical(document['config'])}\n{canonical(rest)}"
    return hashlib.sha256(text.encode()).hexdigest()
