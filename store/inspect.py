"""A shard as a table for people: its header, datasets with units and ranges, and attributes."""

from __future__ import annotations

import json
from pathlib import Path

from store import read
from store.schema import SCHEMAS

_ATTR_WIDTH = 96  # [characters] of an attribute's value before it is cut


def describe(path: Path | str) -> list[str]:
    """Lines that describe the shard at `path`, which is verified in full first.

    Raises:
        ShardError: The shard must not be used; one line.
    """
    shard = read(path)
    header = shard.header
    lines = [
        f"{shard.path}  {shard.path.stat().st_size / 1e6:.2f} MB",
        f"schema {header.schema} v{header.schema_version}  key {header.key[:16]}  checksum {header.checksum[:16]} ok",
        "",
        f"{'dataset':<36} {'shape':<18} {'axes':<8} {'units':<6} {'quantum':<8} range",
    ]
    for name in shard:
        pattern = SCHEMAS[header.schema].match(name)
        values = shard[name]
        dataset = SCHEMAS[header.schema].datasets[pattern] if pattern else None
        axes, units = (dataset.axes, dataset.units) if dataset else ("?", "?")
        quantum = f"{dataset.quantum:g}" if dataset and dataset.quantum else "exact"
        span = f"{values.min():g} .. {values.max():g}" if values.size else "empty"
        origin = f" relative to {dataset.origin}" if dataset and dataset.origin else ""
        lines.append(f"{name:<36} {values.shape!s:<18} {axes:<8} {units:<6} {quantum:<8} {span}{origin}")
    lines.append("")
    for name, value in sorted(shard.attrs.items()):
        text = json.dumps(value)
        lines.append(f"{name}: {text if len(text) <= _ATTR_WIDTH else text[: _ATTR_WIDTH - 3] + '...'}")
    return lines
