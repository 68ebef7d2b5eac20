"""What the report shows, taken out of the shards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

import store
from stages.report.palette import fabric_colour
from stages.report.scene import Surface
from stages.spec import Task

Array = NDArray[np.float32]
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Garment:
    """One garment: what it is, its rest vertices [N, 3] and, in a sequence, its vertices rel. to the root [T, N, 3]."""

    name: str
    about: Mapping[str, Any]
    rest: Array
    faces: NDArray[np.int32]
    vertices: Array

    @property
    def fabric(self) -> str:
        """Name of the fabric."""
        return str(self.about.get("fabric", {}).get("name", "unnamed"))


@dataclass(frozen=True, kw_only=True)
class Person:
    """One item: a body and its garments, over time or at rest; positions are relative to `trans` [m]."""

    item: str
    body: Mapping[str, Any]
    outfit: Mapping[str, Any]
    simulation: Mapping[str, Any]
    betas: Array
    pose: Array
    trans: Array
    vertices: Array
    faces: NDArray[np.int32]
    garments: list[Garment]

    def surfaces(self) -> list[Surface]:
        """The body and the garments in the world."""
        shift = self.trans[:, None, :].astype(np.float64)
        worn = [
            Surface(
                vertices=garment.vertices + shift,
                faces=garment.faces,
                cloth=fabric_colour(garment.fabric, self.item, layer),
            )
            for layer, garment in enumerate(self.garments)
        ]
        return [Surface(vertices=self.vertices + shift, faces=self.faces), *worn]


def spread(items: Sequence[T], count: int) -> list[T]:
    """`count` of the items at even steps from the first to the last, or all of them if there are fewer."""
    places = np.rint(np.linspace(0, len(items) - 1, min(count, len(items)))).astype(int)
    return [items[place] for place in places]


def read_person(task: Task, item: str) -> Person:
    """Reads one item's shards: `body`, `outfit` and, if the item is a sequence, `simulate`."""
    body, outfit = _read(task, "body", item), _read(task, "outfit", item)
    moving = item in task.inputs["simulate"]
    simulated = _read(task, "simulate", item) if moving else None
    garments = []
    for name in outfit.attrs["layers"]:
        rest = outfit[f"garments/{name}/vertices"]
        vertices = rest[None] if simulated is None else simulated[f"garments/{name}/vertices"]
        faces = outfit[f"garments/{name}/faces"]
        about = outfit.attrs["garments"][name]
        garments.append(Garment(name=name, about=about, rest=rest, faces=faces, vertices=vertices))
    return Person(
        item=item,
        body=body.attrs,
        outfit=outfit.attrs,
        simulation={} if simulated is None else simulated.attrs,
        betas=body["betas"],
        pose=body["pose"],
        trans=body["trans"],
        vertices=body["vertices"] if moving else body["rest_vertices"][None],
        faces=body["faces"],
        garments=garments,
    )


@dataclass(frozen=True, kw_only=True)
class Generated:
    """One garment that the trained model made, on a body; z up, metres."""

    name: str
    about: Mapping[str, Any]
    surfaces: list[Surface]


def read_training(task: Task) -> tuple[Mapping[str, Any], list[Generated]]:
    """The trained model's figures, and the garments that it made."""
    shard = _read(task, "train", "all")
    made = []
    for name in shard.groups("generated"):
        about = shard.attrs.get("generated", {}).get(name, {})
        prefix = f"generated/{name}"
        body = Surface(vertices=shard[f"{prefix}/body_vertices"][None], faces=shard[f"{prefix}/body_faces"])
        colour = fabric_colour(str(about.get("fabric", "")), name)
        worn = Surface(vertices=shard[f"{prefix}/vertices"][None], faces=shard[f"{prefix}/faces"], cloth=colour)
        made.append(Generated(name=name, about=about, surfaces=[body, worn]))
    return shard.attrs, made


def _read(task: Task, stage: str, item: str) -> store.Shard:
    entry = task.inputs[stage][item]
    return store.read(Path(entry["path"]), stage, entry["key"])
