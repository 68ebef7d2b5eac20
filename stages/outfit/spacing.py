"""Brings a fitted garment's edges back within a range of lengths: the vertices around an edge that resizing or pushing
left too short or too long slide along the cloth, on a border or seam along that line. Triangles stay as they are.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model.mesh.geometry import vertex_normals
from model.mesh.topology import adjacency, border_halfedges, edge_list
from stages.outfit.clearance import OVERSHOOT
from stages.outfit.obstacle import Gauge
from stages.outfit.surface import Array, Faces, grown

LEAST, MOST = 0.52, 1.95
"""Edge lengths that are aimed at, as shares of the template's: a little within the 0.5 to 2 that is asked for."""

RINGS = 4
"""How many rings of vertices around such an edge may move."""

PASSES, ROUNDS = 6, 25
"""How often vertices slide and are pushed out of what they came too near to; rounds of sliding each time."""

SPRUNG = 1.2
"""Share of what an edge lacks that a round corrects: each vertex takes the mean over its edges, less than it needs."""

CORNER = np.cos(np.deg2rad(55.0))
"""Cosine of the turn of a border beyond which its vertex is a corner and stays."""


def space(
    points: Array, faces: Faces, edge: float, seam: NDArray[np.bool_], gauges: Sequence[Gauge], extra: Array
) -> tuple[Array, float]:
    """Slides vertices until no edge is too short or too long.

    Args:
        points: Vertices of a garment clear of the obstacles [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        edge: Edge length of its template [m].
        seam: Vertices on a seam, shape [N]; like those of a border they only slide along it.
        gauges: The vertices' distances from what to stay out of; kept up with where they go.
        extra: Further distance that each vertex keeps from every obstacle [m], shape [N].

    Returns:
        The vertices [m], shape [N, 3], and the least distance left beyond the margins [m].

    Source: projection of distance constraints as in Mueller et al., Position Based Dynamics (2007).
    """
    edges = edge_list(faces)
    wrong = _lacking(points, edges, edge) != 0
    if not wrong.any():
        return points, np.inf
    free = np.zeros(len(points), dtype=bool)
    free[edges[wrong]] = True
    free = grown(free, faces, RINGS)
    moving = np.flatnonzero(free)
    onto = _ways(points, faces, seam)[moving]
    # All that is near, numbered anew, first what may move.
    edges = edges[free[edges].any(axis=1)]
    rim = np.setdiff1d(edges, moving)
    number = np.empty(len(points), dtype=np.int64)
    number[moving], number[rim] = np.arange(len(moving)), len(moving) + np.arange(len(rim))
    near, edges, points = points[np.concatenate([moving, rim])], number[edges], points.copy()
    for _ in range(PASSES):
        points[moving] = _slide(near, edges, edge, onto)[: len(moving)]
        _push_out(points, gauges, extra)
        near[: len(moving)] = points[moving]
        if not _lacking(near, edges, edge).any():
            break
    return points, -max(float(gauge.lacking(extra).max(initial=-np.inf)) for gauge in gauges)


def _lacking(points: Array, edges: Faces, edge: float) -> Array:
    """By how much each edge is too short, or, negative, too long [m], shape [E]."""
    length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    lacking: Array = np.clip(length, LEAST * edge, MOST * edge) - length
    return lacking


def _slide(points: Array, edges: Faces, edge: float, onto: Array) -> Array:
    """Moves the ends of edges apart or together, the first n the way that `onto` [n, 3, 3] leaves to them."""
    points, count = points.copy(), len(onto)
    for _ in range(ROUNDS):
        lacking = _lacking(points, edges, edge)
        wrong = np.flatnonzero(lacking)
        if len(wrong) == 0:
            break
        a, b = edges[wrong].T
        along = points[b] - points[a]
        along *= (0.5 * SPRUNG * lacking[wrong] / np.linalg.norm(along, axis=1))[:, None]
        ends, pull = np.concatenate([a, b]), np.zeros_like(points)
        np.add.at(pull, ends, np.concatenate([-along, along]))
        pull /= np.maximum(np.bincount(ends, minlength=len(points)), 1)[:, None]
        points[:count] += np.einsum("nij,nj->ni", onto, pull[:count])
    return points


def _ways(points: Array, faces: Faces, seam: NDArray[np.bool_]) -> Array:
    """Projections onto the ways that vertices may go: along the cloth, or along their border or seam, [N, 3, 3]."""
    normals = vertex_normals(points, faces)
    onto = np.eye(3) - normals[:, :, None] * normals[:, None]
    border, edges = border_halfedges(faces), edge_list(faces)
    links = adjacency(np.concatenate([border, edges[seam[edges].all(axis=1)]]), len(points))
    beside = np.diff(links.indptr)
    onto[beside > 0] = 0.0
    inner = np.flatnonzero(beside == 2)
    one, other = links.indices[links.indptr[inner]], links.indices[links.indptr[inner] + 1]
    come, go = points[inner] - points[one], points[other] - points[inner]
    straight = (come * go).sum(axis=1) > CORNER * np.linalg.norm(come, axis=1) * np.linalg.norm(go, axis=1)
    way = (come + go)[straight]
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    onto[inner[straight]] = way[:, :, None] * way[:, None]
    return onto


def _push_out(points: Array, gauges: Sequence[Gauge], extra: Array) -> None:
    """Pushes points [N, 3] out of the obstacles, in place, one obstacle after the other."""
    for gauge in gauges:
        gauge.follow(points, gauge.obstacle.margin + extra)
        short = gauge.lacking(extra)
        points += np.where(short > 0, short + OVERSHOOT, 0.0)[:, None] * gauge.outwards
    for gauge in gauges:
        gauge.follow(points, gauge.obstacle.margin + extra)
