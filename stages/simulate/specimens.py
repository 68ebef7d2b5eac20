"""Specimens of cloth for virtual experiments: strips and discs, cut from lattices of nearly equilateral triangles."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay


def strip(length: float, width: float, edge: float, clamp: int = 2) -> tuple[np.ndarray, np.ndarray, float]:
    """A flat strip along x, whose first `clamp` columns, of which the last is at x = 0, are to be held.

    Args:
        length: Free length [m].
        width: Width along y [m].
        edge: Length of an edge [m], about.
        clamp: Columns that are there to be held; with 0 the strip begins at x = 0.

    Returns:
        Vertices [m], shape [N, 3]; faces, upward, shape [F, 3]; the step between its columns [m].
    """
    count = max(2, round(length / (edge * 3**0.5 / 2)))
    step, rows = length / count, max(1, round(width / edge))
    even = np.arange(rows + 1) * width / rows
    odd = np.concatenate([[0.0], (even[1:] + even[:-1]) / 2, [width]])
    columns, faces, first = [], [], 0
    for c in range(count + max(clamp, 1)):
        y = odd if c % 2 else even
        columns.append(np.stack([np.full(len(y), c * step), y, np.zeros(len(y))], axis=1))
        if c:
            # The column of rows + 1 vertices, on whichever side it is, and that of rows + 2.
            a, b = (first - len(even), first) if c % 2 else (first, first - len(odd))
            k = np.arange(rows + 1)
            whole = np.stack([a + k, b + k + 1, b + k], axis=1)
            part = np.concatenate([whole, np.stack([a + k, a + k + 1, b + k + 1], axis=1)[:-1]])
            faces.append(part[:, [0, 2, 1]] if c % 2 else part)
        first += len(y)
    vertices = np.concatenate(columns)
    if clamp:
        vertices[:, 0] -= (clamp - 1) * step
    return vertices, np.concatenate(faces).astype(np.int32), step


def disc(radius: float, held: float, edge: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A flat disc about the origin, of rings turned against each other so that no direction is favoured.

    Args:
        radius: Of the cloth [m].
        held: Radius of the support [m]: there is a ring there, the last that is held.
        edge: Length of an edge [m], about.

    Returns:
        Vertices [m], shape [N, 3]; faces, upward, shape [F, 3]; the indices of the vertices to hold, shape [K].
    """
    # Rings nearer than an edge, as the triangles between them are no wider than they are high.
    free, inner = max(2, round((radius - held) / (0.93 * edge))), max(2, round(held / (0.93 * edge)))
    rings = [np.zeros((1, 2))]
    for k, r in enumerate(np.concatenate([np.arange(1, inner) * held / inner, np.linspace(held, radius, free + 1)])):
        # On either side of the support's ring one like it, half an edge turned: so it bends there in its edges alone.
        near = abs(k + 1 - inner) <= 1
        count = max(3, round(2 * np.pi * (held if near else r) / edge))
        turn = 2 * np.pi * ((0.5 * ((k + 1 - inner) % 2) if near else 0.618034 * k) + np.arange(count)) / count
        rings.append(r * np.stack([np.cos(turn), np.sin(turn)], axis=1))
    points = np.concatenate(rings)
    faces = Delaunay(points).simplices
    u, v = points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    faces = np.where(area[:, None] < 0, faces[:, [0, 2, 1]], faces)[np.abs(area) > 1e-3 * edge**2]
    vertices = np.concatenate([points, np.zeros((len(points), 1))], axis=1)
    return vertices, faces.astype(np.int32), np.flatnonzero(np.hypot(*points.T) < held + 1e-9)
