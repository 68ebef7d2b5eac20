"""A garment of another edge length: one half of it remeshed, and mirrored."""

import igl
import numpy as np
from numpy.typing import NDArray

from model.mesh.geometry import edge_lengths
from model.mesh.remesh import remesh
from model.mesh.split import split_along
from model.mesh.topology import compact, edge_list

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

PASSES, ROUNDS = 6, 4
"""Passes of remeshing in a round, and rounds at most."""

CLOSE = 0.04
"""No further round where the mean edge is as near to the target as this [1] ..."""

BLUNT = np.deg2rad(20.0)
"""... and no angle is smaller than this [rad]."""

CORRECTION = 0.06
"""By how much at most the remesher is told another edge length than the target, to come nearer to it [1]."""

SNAP = 1e-5
"""Vertices of a garment nearer than this to x = 0 lie on it, as a share of half its width [1]."""

ON_PLANE = 1e-5
"""Vertices of a half nearer than this to x = 0 lie on it [m]."""


def resampled(vertices: Array, faces: Faces, wanted: float) -> tuple[Array, Faces]:
    """The same garment with other triangles.

    Args:
        vertices: Vertices of a garment that is symmetric about x = 0 [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        wanted: Edge length to aim at [m].

    Returns:
        Vertices [m], shape [N', 3], on the surface of the half with x >= 0 and on its borders, or mirror images of
        such; faces, shape [F', 3]. Left and right have mirrored triangles.
    """
    points, triangles, left = split_along(vertices, faces, vertices[:, 0], SNAP)
    triangles, kept = compact(triangles[left], len(points))
    surface = _flattened(points[kept]), triangles
    (points, triangles), aim = surface, wanted
    for _ in range(ROUNDS):
        points, triangles = remesh(points, triangles, aim, PASSES, surface)
        ratio = float(edge_lengths(points, edge_list(triangles)).mean()) / wanted
        if abs(ratio - 1) < CLOSE and igl.internal_angles(points, triangles).min() > BLUNT:
            break
        aim = wanted * float(np.clip(aim / wanted / ratio, 1 - CORRECTION, 1 + CORRECTION))
    points, triangles = mirrored(_flattened(points), triangles)
    order = sweep_order(points)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    triangles = rank[triangles]
    return points[order], triangles[np.lexsort(triangles.T[::-1])]


def mirrored(points: Array, faces: Faces) -> tuple[Array, Faces]:
    """A half with x >= 0 and its mirror image, joined at the vertices with x = 0.

    Args:
        points: Vertices of the half [m], shape [n, 3].
        faces: Its triangles, shape [f, 3].

    Returns:
        Vertices [m], shape [2 n - m, 3], and faces, oriented alike, shape [2 f, 3].
    """
    apart = points[:, 0] > 0
    other = np.arange(len(points))
    other[apart] = len(points) + np.arange(int(apart.sum()))
    vertices = np.concatenate([points, points[apart] * [-1.0, 1.0, 1.0]])
    return vertices, np.concatenate([faces, other[faces][:, ::-1]])


def sweep_order(vertices: Array) -> NDArray[np.int64]:
    """Vertices from top to bottom in bands of 2 cm, around the axis in each: neighbours get near numbers."""
    band = np.floor(vertices[:, 2] / 0.02)
    return np.lexsort((np.arctan2(vertices[:, 1], vertices[:, 0]), -band))


def _flattened(points: Array) -> Array:
    """The points, those next to the plane x = 0 moved onto it."""
    flat = points.copy()
    flat[np.abs(flat[:, 0]) < ON_PLANE, 0] = 0.0
    return flat
