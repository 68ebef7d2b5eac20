"""Brings a fitted garment's edges back within a range of lengths, and its triangles from being too flat: the vertices
around what resizing or pushing left so slide along the cloth, on a border or seam along that line. Which vertices are
neighbours stays as it is.
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

FLAT = 0.29
"""Least height of a triangle over its longest edge, as a share of that edge: no angle is then below 16 degrees."""

ENOUGH = 0.01
"""What edges and heights may lack of this in the end, as a share of the template's edge length."""

RINGS = 4
"""How many rings of vertices around such an edge or triangle may move."""

PASSES, ROUNDS = 10, 25
"""How often vertices slide and are pushed out of what they came too near to; rounds of sliding each time."""

MORE_RINGS, MOMENTUM = 12, 0.9
"""What is tried where that was not enough: more rings may move, and go on in each round by this share of the round
before. Where many edges side by side along a border are too short, they make room for each other by small steps."""

SPRUNG = 1.2
"""Share of what an edge or height lacks that a round corrects: each vertex takes the mean of what pulls at it, which is
less than it needs."""

CORNER = np.cos(np.deg2rad(55.0))
"""Cosine of the turn of a border beyond which its vertex is a corner and stays."""


def space(
    points: Array, faces: Faces, edge: float, seam: NDArray[np.bool_], gauges: Sequence[Gauge], extra: Array
) -> tuple[Array, float]:
    """Slides vertices until no edge is too short or too long and no triangle too flat.

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
    edges, slid = edge_list(faces), False
    for rings, momentum in ((RINGS, 0.0), (MORE_RINGS, MOMENTUM)):
        wrong, flat = np.abs(_lacking(points, edges, edge)), _flatness(points, faces)[0]
        if max(wrong.max(), flat.max()) <= (ENOUGH * edge if slid else 0.0):
            break
        free = np.zeros(len(points), dtype=bool)
        free[edges[wrong > 0]] = free[faces[flat > 0]] = True
        near = _Near(points, faces, edges, grown(free, faces, rings), _ways(points, faces, seam))
        points, slid = _spaced(points, near, edge, gauges, extra, momentum), True
    if not slid:
        return points, np.inf
    return points, -max(float(gauge.lacking(extra).max(initial=-np.inf)) for gauge in gauges)


class _Near:
    """What is near edges and triangles to be mended, numbered anew: first the vertices that may move."""

    def __init__(self, points: Array, faces: Faces, edges: Faces, free: NDArray[np.bool_], ways: Array) -> None:
        self.moving = np.flatnonzero(free)
        self.ways = ways[self.moving]
        edges, faces = edges[free[edges].any(axis=1)], faces[free[faces].any(axis=1)]
        rim = np.setdiff1d(edges, self.moving)
        number = np.empty(len(points), dtype=np.int64)
        number[self.moving] = np.arange(len(self.moving))
        number[rim] = len(self.moving) + np.arange(len(rim))
        self.points, self.edges, self.faces = points[np.concatenate([self.moving, rim])], number[edges], number[faces]

    def enough(self, edge: float) -> bool:
        """Whether nothing is left to mend."""
        lacking = np.abs(_lacking(self.points, self.edges, edge)).max()
        return bool(max(lacking, _flatness(self.points, self.faces)[0].max()) < ENOUGH * edge)


def _spaced(points: Array, near: _Near, edge: float, gauges: Sequence[Gauge], extra: Array, momentum: float) -> Array:
    """Slides and pushes out in turn."""
    points = points.copy()
    for _ in range(PASSES):
        points[near.moving] = _slide(near, edge, momentum)[: len(near.moving)]
        _push_out(points, gauges, extra)
        near.points[: len(near.moving)] = points[near.moving]
        if near.enough(edge):
            break
    return points


def _lacking(points: Array, edges: Faces, edge: float) -> Array:
    """By how much each edge is too short, or, negative, too long [m], shape [E]."""
    length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    lacking: Array = np.clip(length, LEAST * edge, MOST * edge) - length
    return lacking


def _flatness(points: Array, faces: Faces) -> tuple[Array, Faces, Array, Array]:
    """How flat each triangle is.

    Returns:
        What its height over its longest edge lacks [m], shape [F]; its corners, the apex first, shape [F, 3]; the
        height, from that edge to the apex [m], shape [F, 3]; its foot's place on the edge, 0 to 1, shape [F].
    """
    sides = points[faces[:, [2, 0, 1]]] - points[faces[:, [1, 2, 0]]]
    length2 = (sides**2).sum(axis=2)
    apex, rows = length2.argmax(axis=1), np.arange(len(faces))
    corners = faces[rows[:, None], (apex[:, None] + [0, 1, 2]) % 3]
    base, length2 = sides[rows, apex], length2[rows, apex]
    up = points[corners[:, 0]] - points[corners[:, 1]]
    share = (up * base).sum(axis=1) / length2
    up -= share[:, None] * base
    lacking: Array = FLAT * np.sqrt(length2) - np.sqrt((up**2).sum(axis=1))
    return lacking, corners, up, share


def _slide(near: _Near, edge: float, momentum: float) -> Array:
    """Moves the ends of edges apart or together, and the corners of flat triangles: the points near by, [n, 3]."""
    points, edges, faces, onto, count = near.points.copy(), near.edges, near.faces, near.ways, len(near.moving)
    step = np.zeros((count, 3))
    for _ in range(ROUNDS):
        lacking = _lacking(points, edges, edge)
        short, corners, up, share = _flatness(points, faces)
        if max(np.abs(lacking).max(), short.max()) < ENOUGH * edge:
            break
        wrong, flat = np.flatnonzero(lacking), np.flatnonzero(short > 0)
        a, b = edges[wrong].T
        along = points[b] - points[a]
        along *= (0.5 * SPRUNG * lacking[wrong] / np.linalg.norm(along, axis=1))[:, None]
        lift, t = up[flat], share[flat, None]
        lift *= (SPRUNG * short[flat] / np.linalg.norm(lift, axis=1))[:, None] / (1.0 + t**2 + (1.0 - t) ** 2)
        ends, pull = np.concatenate([a, b, *corners[flat].T]), np.zeros_like(points)
        np.add.at(pull, ends, np.concatenate([-along, along, lift, (t - 1.0) * lift, -t * lift]))
        pull /= np.maximum(np.bincount(ends, minlength=len(points)), 1)[:, None]
        step = momentum * step + np.einsum("nij,nj->ni", onto, pull[:count])
        points[:count] += step
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
