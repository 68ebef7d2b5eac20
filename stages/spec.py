"""The whole vocabulary between the pipeline and the stages: `StageSpec` and `Task`."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

STAGE_NAMES = ("body", "outfit", "simulate", "register", "encode", "train", "report")


class Progress(Protocol):
    """Where a stage says how far it is: `done` of `total` steps, with a short label."""

    def __call__(self, done: float, total: float, label: str = "") -> None: ...


class DataError(Exception):
    """The input of a task is at fault (exit code 65): quarantined and never retried.

    The message is one line: what, where, the value, the limit, the remedy.
    """


@dataclass(frozen=True, kw_only=True)
class StageSpec:
    """What the pipeline must know of a stage, without importing its science.

    Attributes:
        name: Folder under `stages` and section of the recipe.
        needs: Stages whose shards this one reads: of the same item, or of every item if `scope` is "dataset".
        kinds: Kinds of item that the stage runs on, of "sequence" and "static".
        scope: "item" runs once per item; "dataset" runs once, over every item, under the item name "all".
        params: Names of the item's own parameters (from the recipe's dataset section) that the stage reads.
        config: Frozen dataclass of the recipe's section `[name]`.
        code_version: Raised by hand whenever the stage's result changes for equal inputs.
        schema: Name of the schema in `store.schema` that the shard follows.
        suffix: Ending of what is published; "" means a folder.
    """

    name: str
    needs: tuple[str, ...]
    kinds: tuple[str, ...] = ("sequence", "static")
    scope: str = "item"
    params: tuple[str, ...] = ()
    config: type
    code_version: int
    schema: str
    suffix: str = ".h5"


@dataclass(frozen=True, kw_only=True)
class Task:
    """One run of one stage on one item; a JSON file of it is all that a worker needs.

    Attributes:
        stage: Name of the stage.
        item: Item's id, or "all" for a stage with scope "dataset".
        kind: "sequence", "static" or "dataset".
        key: Expected key of the shard to publish, sha256 in hex.
        seed: Seed of the item's random generator; see `seed_of`.
        config: The stage's section of the recipe, as plain JSON.
        params: The item's parameters named in `StageSpec.params`.
        inputs: stage -> item -> {"path": shard, "key": its key}.
        output: Path to publish.
    """

    stage: str
    item: str
    kind: str
    key: str
    seed: int
    config: Mapping[str, Any]
    params: Mapping[str, Any]
    inputs: Mapping[str, Mapping[str, Mapping[str, str]]] = field(default_factory=dict)
    output: str = ""

    def input(self, stage: str) -> tuple[Path, str]:
        """Path and key of the shard of `stage` for this task's own item."""
        entry = self.inputs[stage][self.item]
        return Path(entry["path"]), entry["key"]

    def to_json(self) -> str:
        """This task as JSON text."""
        return json.dumps(dataclasses.asdict(self), indent=1, sort_keys=True)

    @classmethod
    def from_json(cls, text: str) -> Task:
        """The task written by `to_json`."""
        return cls(**json.loads(text))


def seed_of(recipe_seed: int, stage: str, item: str) -> int:
    """Seed of one stage's generator for one item, from 0 to 2^64 - 1.

    It depends on the recipe's seed, the stage and the item alone, so that changing one setting leaves every other
    random choice as it was: two recipes that differ in one factor are counterfactual pairs.
    """
    digest = hashlib.sha256(f"{recipe_seed}/{stage}/{item}".encode()).digest()
    return int.from_bytes(digest[:8], "little")


def load_spec(name: str) -> StageSpec:
    """The `SPEC` of stage `name`; imports the stage's `__init__` only, never its science."""
    spec: StageSpec = importlib.import_module(f"stages.{name}").SPEC
    return spec


def load_run(name: str) -> Callable[[Task, Progress], dict[str, Any]]:
    """The function `run(task, progress)` of `stages.<name>.stage`; it publishes and returns figures for the receipt."""
    run: Callable[[Task, Progress], dict[str, Any]] = importlib.import_module(f"stages.{name}.stage").run
    return run
