"""Garments of one's own for the tests, as a person's program would have written them."""

from pathlib import Path

import numpy as np

from stages.outfit.coordinates import Axes
from stages.outfit.own.placement import from_rest, wearer
from stages.outfit.own.settings import OwnGarment

Array = np.ndarray


def tube(radius_x: float, radius_y: float, low: float, high: float, edge: float, flare: float = 0.0) -> tuple:
    """A vertical elliptic tube around the root joint that looks outwards, `flare` wider at the bottom."""
    around = round(np.pi * (radius_x + radius_y) / edge)
    rows = round((high - low) / (edge * 0.866))
    points, faces = [], []
    for i in range(rows + 1):
        angle = 2 * np.pi * (np.arange(around) + 0.5 * (i % 2)) / around
        share = 1.0 + flare * (1 - i / rows)
        z = np.full(around, low + (high - low) * i / rows)
        points.append(np.stack([share * radius_x * np.cos(angle), share * radius_y * np.sin(angle) - 0.02, z], axis=1))
    for i in range(rows):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = a + around, b + around
            faces += [[a, b, c], [b, d, c]] if i % 2 == 0 else [[a, b, d], [a, d, c]]
    return np.concatenate(points), np.array(faces)


def kilt(edge: float = 0.03) -> tuple[Array, Array]:
    """A skirt from above the hips to the knees, on the mean woman [m], [N, 3] and [F, 3]."""
    axes = Axes.of(wearer("female", ()).joints)
    return tube(0.215, 0.185, axes.hip[2] - 0.42, axes.hip[2] + 0.14, edge, flare=0.35)


def kilt_settings(**changes: object) -> OwnGarment:
    """What a recipe would say of it."""
    return OwnGarment(**{"name": "kilt", "file": "kilt.obj", "type": "skirt", "gender": "female"} | changes)  # type: ignore[arg-type]


def as_obj(vertices: Array, faces: Array, **frame: str) -> str:
    """An OBJ file's text, in another unit, up axis or origin if asked for."""
    told = {"unit": "m", "up": "z", "origin": "root"} | frame
    points = from_rest(vertices, **told, floor=wearer("female", ()).floor)
    lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in points]
    return "\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in faces + 1), ""])


def write_kilt(folder: Path, **frame: str) -> Path:
    """A file of the kilt."""
    path = folder / "kilt.obj"
    path.write_text(as_obj(*kilt(), **frame))
    return path
