"""Keeps a garment outside the body and other garments: every vertex a margin away, by exact signed distance."""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.mesh.geometry import vertex_normals
from model.mesh.topology import adjacency, edge_list
from stages.outfit.obstacle import Gauge

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

ROUNDS = 20
"""Rounds of measuring and pushing at most; two to five are usual."""

SPREAD, FADE = 8, 0.85
"""Rings of neighbours that a push carries with it, so that it leaves no spike, and what is left from ring to ring."""

PLAIN = 8
"""Rounds at the end that push nothing but the vertices concerned."""

EVENINGS = {2: 0.05, 4: 0.035, 6: 0.02}
"""After which rounds all that was pushed so far is evened out along the cloth, and how far [m]."""

OVERSHOOT = 2e-4
"""How much further than needed a vertex is pushed [m]: saves rounds where the surface curves."""

STRIDE = 0.015
"""Longest push of one round [m]."""

DEEP = 0.004
"""Depth beyond which the nearest surface of an obstacle is not trusted to be the way out [m]."""

ASTRAY = 0.3
"""Nor is it where its direction and the garment's outside have a smaller cosine than this."""


def clear(points: Array, faces: Faces, gauges: Sequence[Gauge], extra: Array | None = None) -> tuple[Array, float]:
    """Pushes a garment's vertices out of the obstacles, and their neighbours with them, so that it stays smooth.

    Args:
        points: Vertices of the garment [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        gauges: The vertices' distances from what to stay out of; kept up with where they go.
        extra: Further distance that each vertex keeps from every obstacle [m], shape [N].

    Returns:
        The vertices [m], shape [N, 3], and the least distance left beyond the margins [m]: 0 or more if all are kept.
    """
    points = points.copy()
    more = np.zeros(len(points)) if extra is None else extra
    edges = edge_list(faces)
    links = adjacency(edges, len(points))
    averaging = sp.diags(1.0 / np.maximum(np.asarray(links.sum(axis=1)).reshape(-1), 1.0)) @ links
    start, evenings = points.copy(), _evening_steps(points, edges)
    _follow(points, gauges, more)
    for round_ in range(ROUNDS):
        push = _push(points, faces, gauges, more)
        pushed = (push != 0).any(axis=1)
        if not pushed.any() and (round_ == 0 or round_ > max(evenings)):
            break
        points += _spread(push, pushed, averaging) if round_ < ROUNDS - PLAIN else push
        if round_ in evenings:
            total = points - start
            for _ in range(evenings[round_]):
                total = 0.5 * (total + averaging @ total)
            points = start + total
        _follow(points, gauges, more)
    return points, -max(float(gauge.lacking(more).max(initial=-np.inf)) for gauge in gauges)


def _follow(points: Array, gauges: Sequence[Gauge], more: Array) -> None:
    for gauge in gauges:
        gauge.follow(points, gauge.obstacle.margin + more)


def _push(points: Array, faces: Faces, gauges: Sequence[Gauge], more: Array) -> Array:
    """What each vertex lacks of its margins, as a displacement [m], shape [N, 3].

    Near the surface of an obstacle the way out is straight away from it. Further in, the nearest surface may be that
    of a navel or between the legs; the garment's own outside is the right way then.
    """
    push = np.zeros_like(points)
    own = vertex_normals(points, faces)
    for gauge in gauges:
        short = gauge.lacking(more)
        astray = (gauge.distance < -DEEP) | ((gauge.outwards * own).sum(axis=1) < ASTRAY)
        way = np.where(astray[:, None], own, gauge.outwards)
        push += np.where(short > 0, np.minimum(short + OVERSHOOT, STRIDE), 0.0)[:, None] * way
    return push


def _evening_steps(points: Array, edges: Faces) -> dict[int, int]:
    """Averaging steps after each round of `EVENINGS`: one step spreads by about half an edge length."""
    edge = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1).mean()
    return {round_: round(4.0 * (width / edge) ** 2) for round_, width in EVENINGS.items()}


def _spread(push: Array, pushed: NDArray[np.bool_], averaging: sp.csr_matrix) -> Array:
    """The push, fading over the neighbours of the pushed vertices."""
    spread = push
    for _ in range(SPREAD):
        spread = np.where(pushed[:, None], push, FADE * (averaging @ spread))
    return spread
