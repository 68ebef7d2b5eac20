"""A stand-up collar: a band of cloth around the neck, sewn to the neckline."""

from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from stages.outfit.borders import Border
from stages.outfit.panels import Panels
from stages.outfit.surface import Surface

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

LEAN = 0.25
"""How far forward the neck leans as it rises, as a share of the height: that of the mean bodies' neck bones."""

INWARD = 0.35
"""How far a collar leans towards the neck, as a share of its height."""

RING = 0.9
"""Height of a ring of triangles, in edge lengths: a little above that of an equilateral triangle."""


def add_collar(surface: Surface, panels: Panels, neck: Border, height: float, edge: float) -> tuple[Surface, Panels]:
    """Puts a collar on a garment.

    Args:
        surface: The garment on the mean body.
        panels: Its panels.
        neck: The border that the collar is sewn to.
        height: Height of the collar [m].
        edge: Edge length of the garment [m].

    Returns:
        The garment with the collar's vertices and faces after its own; the panels with one more, `collar`, sewn on
        along the seam `collar`, and, if it goes all around, closed by the seam `collar_back`.
    """
    rings, base = max(1, round(height / (RING * edge))), neck.loop
    count, size = len(surface.vertices), len(base)
    points = surface.vertices[base]
    even = _evened(points, neck.closed)
    rise = np.array([0.0, -LEAN, 1.0]) * height / rings
    away = points - points.mean(axis=0)
    away[:, 2] = 0.0
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    if not neck.closed:
        # The ends stay above each other, along the front's borders.
        away[[0, -1], 0] = 0.0
    step = rise - INWARD * height / rings * away
    lines = [points] + [points + (even - points) * k / rings + k * step for k in range(1, rings + 1)]
    vertices = np.concatenate([surface.vertices, *lines[1:]])
    numbers = np.concatenate([base[None], count + np.arange(rings * size).reshape(rings, size)])
    faces = np.concatenate([_strip(vertices, low, high, neck.closed) for low, high in pairwise(numbers)])
    whole = Surface(
        vertices,
        np.concatenate([surface.faces, faces]),
        sp.vstack([surface.rows, *[surface.rows[base]] * rings], format="csr"),
    )
    seams = {"collar": _edges(base, neck.closed)}
    if neck.closed:
        back = int(surface.vertices[base, 1].argmax())
        seams["collar_back"] = _edges(numbers[:, back], closed=False)
    of_face = np.concatenate([panels.of_face, np.full(len(faces), len(panels.names))])
    return whole, Panels([*panels.names, "collar"], of_face, panels.seams | seams)


def _evened(line: Array, closed: bool) -> Array:
    """As many points on the line [n, 3] at even distances along it; the ends of an open one stay."""
    around = np.concatenate([line, line[:1]]) if closed else line
    along = np.concatenate([[0.0], np.linalg.norm(np.diff(around, axis=0), axis=1).cumsum()])
    even = along[-1] * np.arange(len(line)) / (len(around) - 1)
    if closed:
        even += (along[:-1] - even).mean()
    return np.stack([np.interp(even, along, around[:, k], period=along[-1] if closed else None) for k in range(3)], 1)


def _strip(points: Array, low: Faces, high: Faces, closed: bool) -> Faces:
    """Triangles between two lines of as many vertices [n], which the faces below `low` use in its direction."""
    a, b, c, d = low, np.roll(low, -1), high, np.roll(high, -1)
    falling = np.stack([np.stack([b, a, c], axis=1), np.stack([b, c, d], axis=1)], axis=1)
    rising = np.stack([np.stack([b, a, d], axis=1), np.stack([a, c, d], axis=1)], axis=1)
    shorter = np.linalg.norm(points[b] - points[c], axis=1) < np.linalg.norm(points[a] - points[d], axis=1)
    faces: Faces = np.where(shorter[:, None, None], falling, rising)
    return (faces if closed else faces[:-1]).reshape(-1, 3)


def _edges(line: Faces, closed: bool) -> Faces:
    """Edges along a line of vertices, smaller vertex first, shape [n, 2] or [n - 1, 2]."""
    edges = np.sort(np.stack([line, np.roll(line, -1)], axis=1), axis=1)
    return edges if closed else edges[:-1]
