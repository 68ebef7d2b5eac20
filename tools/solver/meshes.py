"""Meshes of the extreme cases: sheets fine, coarse, graded and of slivers, and a capsule to hit them with."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

Mesh = tuple[np.ndarray, np.ndarray]
"""Vertices [m], shape [N, 3], and faces, shape [F, 3], int32."""


def grid(x: np.ndarray, y: np.ndarray) -> Mesh:
    """A flat sheet with vertices at every x (I,) and y (J,) [m], centred on the origin, faces up."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(len(x) - 1), np.arange(len(y) - 1), indexing="ij"))
    a, b, c, d = (p * len(y) + q for p, q in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.stack([a, b, c], 1), np.stack([a, b, d], 1))
    second = np.where(even, np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    place = np.stack([*np.meshgrid(x - np.mean(x[[0, -1]]), y - np.mean(y[[0, -1]]), indexing="ij")], axis=-1)
    vertices = np.concatenate([place.reshape(-1, 2), np.zeros((len(x) * len(y), 1))], axis=1)
    return vertices, np.concatenate([first, second]).astype(np.int32)


def sheet(count: int, edge: float) -> Mesh:
    """A square sheet of count x count vertices, `edge` [m] apart."""
    line = np.arange(count) * edge
    return grid(line, line)


def graded(finest: float, coarsest: float, radius: float) -> Mesh:
    """A disc whose edges grow from `finest` in the middle to `coarsest` at the rim [m]."""
    rings, r = [np.zeros((1, 2))], 0.0
    while r + (edge := finest + (coarsest - finest) * r / radius) < radius + 0.5 * edge:
        r += edge
        count = max(6, round(2 * np.pi * r / edge))
        angle = 2 * np.pi * (np.arange(count) + 0.5 * (len(rings) % 2)) / count
        rings.append(r * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    flat = np.concatenate(rings)
    faces = Delaunay(flat).simplices
    u, v = flat[faces[:, 1]] - flat[faces[:, 0]], flat[faces[:, 2]] - flat[faces[:, 0]]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    # Along the rim the hull adds triangles as thin as its curvature; the disc ends at its own edges.
    longest = np.linalg.norm(np.stack([u, v, u - v]), axis=2).max(0)
    keep = np.abs(area) > 0.02 * longest**2
    faces[area < 0] = faces[area < 0][:, ::-1]
    return np.column_stack([flat, np.zeros(len(flat))]), faces[keep].astype(np.int32)


def needles(count: int, edge: float, ratio: float) -> Mesh:
    """A sheet of count x count vertices of which every other row is `ratio` times as near to the one before."""
    steps = np.where(np.arange(count - 1) % 2 == 0, edge, edge * ratio)
    return grid(np.concatenate([[0.0], np.cumsum(steps)]), np.arange(count) * edge)


def caps(count: int, edge: float, ratio: float) -> Mesh:
    """A sheet in which every third vertex inside lies at `ratio` of an edge from the diagonal opposite to it."""
    vertices, faces = sheet(count, edge)
    i, j = np.divmod(np.arange(len(vertices)), count)
    inside = (i > 0) & (i < count - 1) & (j > 0) & (j < count - 1) & ((i + j) % 2 == 1) & (i % 3 == 1)
    # Odd vertices have four faces, whose far sides are the four diagonals about them.
    vertices[inside, :2] += (0.5 - ratio / 2**0.5) * edge
    return vertices, faces


def capsule(radius: float, length: float, around: int = 24) -> Mesh:
    """A capsule along z about the origin, `length` [m] between its caps' centres, faces outward; 0 makes a ball."""
    caps = max(3, around // 4)
    angle = np.linspace(-np.pi / 2, 0, caps + 1)[1:]
    side = np.linspace(-length / 2, length / 2, max(2, round(length * around / (2 * np.pi * radius)) + 1))
    low = np.stack([radius * np.cos(angle), radius * np.sin(angle) - length / 2], axis=1)
    middle = np.stack([np.full(len(side), radius), side], axis=1)[1:-1]
    profile = np.concatenate([low, middle, low[::-1] * [1, -1]])
    if length == 0:
        profile = np.concatenate([low, low[-2::-1] * [1, -1]])
    turn = 2 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rows = [np.column_stack([r * ring, np.full(around, z)]) for r, z in profile]
    end = length / 2 + radius
    vertices = np.concatenate([[[0.0, 0.0, -end]], *rows, [[0.0, 0.0, end]]])
    k, near = np.arange(around), len(vertices) - 1
    after = (k + 1) % around
    faces = [np.stack([np.zeros(around, int), 1 + after, 1 + k], axis=1)]
    for row in range(len(profile) - 1):
        a, b = 1 + row * around + k, 1 + row * around + after
        faces += [np.stack([a, b, b + around], axis=1), np.stack([a, b + around, a + around], axis=1)]
    top = near - around
    faces.append(np.stack([top + k, top + after, np.full(around, near)], axis=1))
    return vertices, np.concatenate(faces).astype(np.int32)


def tube(around: int, rows: int, radius: float, edge: float) -> Mesh:
    """An open tube along z about the origin, rows `edge` [m] apart, faces outward."""
    turn = 2 * np.pi * np.arange(around) / around
    ring = np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1)
    height = (np.arange(rows) - 0.5 * (rows - 1)) * edge
    vertices = np.concatenate([np.column_stack([ring, np.full(around, z)]) for z in height])
    k = np.arange(around)
    after, faces = (k + 1) % around, []
    for row in range(rows - 1):
        a, b = row * around + k, row * around + after
        faces += [np.stack([a, b, b + around], axis=1), np.stack([a, b + around, a + around], axis=1)]
    return vertices, np.concatenate(faces).astype(np.int32)
