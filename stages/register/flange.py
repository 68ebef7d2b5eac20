"""Continue a garment a little beyond its borders, so that the layer has something to follow there."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.mesh.topology import border_halfedges

SMOOTHING = 8
"""Passes that even out the direction of the flange along a border, so that its ribs do not cross in the corners."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Flanged:
    """A garment with its flange.

    Attributes:
        vertices: The garment's vertices first, then the flange's [m], shape [V, 3].
        faces: The garment's faces first, then the flange's, shape [F, 3].
        garment_faces: Number of the garment's own faces.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    garment_faces: int


def add_flange(vertices: ArrayLike, faces: ArrayLike, width: float, rings: int) -> Flanged:
    """Extends a surface along its tangent planes.

    Args:
        vertices: Garment [m], shape [M, 3].
        faces: Triangles, oriented, shape [G, 3].
        width: How far the flange reaches [m].
        rings: Rings of faces across that width.

    Returns:
        The garment with one flange along each border.
    """
    points, triangles = np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64)
    half = border_halfedges(triangles)
    count = len(half)
    if count == 0:
        return Flanged(vertices=points, faces=triangles, garment_faces=len(triangles))
    rim, flat = np.unique(half, return_inverse=True)
    a, b = np.reshape(flat, (count, 2)).T
    outward = _conormals(points, triangles, half)
    direction = np.zeros((len(rim), 3))
    np.add.at(direction, a, outward)
    np.add.at(direction, b, outward)
    for _ in range(SMOOTHING):
        direction = _unit(direction)
        spread = 2.0 * direction
        np.add.at(spread, a, direction[b])
        np.add.at(spread, b, direction[a])
        direction = spread
    direction = _unit(direction)
    levels = [points[rim] + width * (k + 1) / rings * direction for k in range(rings)]
    numbers = np.vstack([rim, len(points) + np.arange(rings * len(rim)).reshape(rings, -1)])
    new_faces = []
    for inner, outer in pairwise(numbers):
        new_faces += [np.stack([inner[b], inner[a], outer[a]], 1), np.stack([inner[b], outer[a], outer[b]], 1)]
    return Flanged(
        vertices=np.vstack([points, *levels]),
        faces=np.vstack([triangles, *new_faces]),
        garment_faces=len(triangles),
    )


def _conormals(points: NDArray[np.float64], faces: NDArray[np.int64], half: NDArray[np.int64]) -> NDArray[np.float64]:
    """For each border edge the direction in its face's plane away from the face, shape [B, 3]."""
    base = len(points)
    codes = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2) @ [base, 1]
    order = np.argsort(codes)
    corner = order[np.searchsorted(codes[order], half @ [base, 1])]
    third = points[faces[corner // 3, (corner % 3 + 2) % 3]]
    start, end = points[half[:, 0]], points[half[:, 1]]
    along = _unit(end - start)
    inwards = third - start
    inwards -= (inwards * along).sum(axis=1, keepdims=True) * along
    return -_unit(inwards)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-20)
