"""Why a task must run again: the first thing that its result depends on and that isn't as it was."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

# Causes before their effects: a changed setting is named rather than the input that it changed.
_ORDER = ("stage", "code_version", "schema", "config", "params", "item", "seed", "inputs")
_WIDTH = 40  # [characters] of a value before it is cut


def first_difference(old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    """The first difference between two key documents, as `config.dt 0.01667 -> 0.01`; empty if there is none."""
    for name in (*_ORDER, *sorted(set(old) - set(_ORDER))):
        found = _difference(name, old.get(name), new.get(name))
        if found:
            return found
    return ""


def _difference(path: str, old: Any, new: Any) -> str:
    if _text(old) == _text(new):
        return ""
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        # New names last: an added setting says less than a changed one.
        for name in (*old, *(name for name in new if name not in old)):
            found = _difference(f"{path}.{name}", old.get(name), new.get(name))
            if found:
                return found
    if path.startswith("inputs."):
        stage, _, item = path.removeprefix("inputs.").partition(".")
        change = "was made anew" if old and new else "is new" if new else "is gone"
        return f"input {stage}/{item} {change}" if item else f"input {stage} {change}"
    return f"{path} {_short(old)} -> {_short(new)}"


def _text(value: Any) -> str:
    """As in the key: 1 and 1.0 differ there, though they are equal in Python."""
    return json.dumps(value, sort_keys=True)


def _short(value: Any) -> str:
    if value is None:
        return "none"
    text = _text(value)
    return text if len(text) <= _WIDTH else text[: _WIDTH - 3] + "..."
