"""Encoded shards as records."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import store
from model.body import GENDERS
from stages.spec import DataError, Progress, Task
from stages.train.records import Record, WornGarment


def read_records(task: Task, frames: int, vertex_count: int, progress: Progress) -> list[Record]:
    """Every item of the task, sequences with at most `frames` frames each, in the order of their names.

    Raises:
        DataError: If an item has no split, or was encoded on another layer.
    """
    items = task.params["items"]
    records = []
    for index, (item, entry) in enumerate(sorted(task.inputs["encode"].items())):
        progress(index, len(items), "reading encoded garments")
        if item not in items:
            raise DataError(f"train: item {item!r} is encoded but has no kind and split; plan the recipe again")
        # Opened, not read: a long sequence is decoded only in the frames that are wanted.
        with store.open_shard(Path(entry["path"]), "encode", entry["key"]) as shard:
            records.append(_record(item, items[item], shard, frames, vertex_count))
    return records


def wearers(task: Task) -> dict[str, dict[str, Any]]:
    """What the shards say of the body model of each gender; the free body's gender alone where there is nobody."""
    found: dict[str, dict[str, Any]] = {}
    for _, entry in sorted(task.inputs["encode"].items()):
        attrs = store.read_header(Path(entry["path"]), "encode", entry["key"]).attrs
        found.setdefault(attrs["gender"], attrs)
        if len(found) == len(GENDERS):
            break
    return {gender: found.get(gender, {"gender": gender}) for gender in GENDERS}


def _record(item: str, about: dict[str, str], shard: store.Shard, most: int, vertex_count: int) -> Record:
    pose = shard["pose"]
    sequence = about["kind"] == "sequence"
    frames = _evenly(len(pose), most) if sequence else np.zeros(0, np.int64)
    garments = []
    for name in shard.groups("garments"):
        attrs: dict[str, Any] = shard.attrs["garments"][name]
        mask = shard[f"garments/{name}/mask"]
        if len(mask) != vertex_count:
            raise DataError(
                f"{shard.path}: garment {name!r} has {len(mask)} layer vertices, the layer has {vertex_count}; "
                "encode it again"
            )
        if not mask.any():
            raise DataError(f"{shard.path}: garment {name!r} covers no layer vertex; register it again")
        moving = [shard.frame(f"garments/{name}/offsets", int(frame)) for frame in frames]
        garments.append(
            WornGarment(
                name=name,
                kind=attrs["type"],
                topology=attrs["topology"],
                mask=mask,
                at_rest=shard[f"garments/{name}/static_offsets"],
                moving=np.stack(moving) if moving else np.zeros((0, vertex_count, 3), np.float32),
            )
        )
    return Record(
        item=item,
        sequence=sequence,
        train=about["split"] == "train",
        gender=shard.attrs["gender"],
        betas=shard["betas"],
        tightness=np.asarray(shard.attrs["tightness"], np.float32),
        pose=pose,
        frames=frames,
        garments=tuple(garments),
    )


def _evenly(count: int, most: int) -> NDArray[np.int64]:
    """At most `most` frames of `count`, evenly spread, the first and the last among them."""
    return np.unique(np.rint(np.linspace(0, count - 1, min(count, most))).astype(np.int64))
