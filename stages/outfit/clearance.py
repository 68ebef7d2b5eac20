"""Keeps a garment outside the body and other garments: every vertex a margin away, by exact signed distance."""

from collections.abc import Sequence
from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.mesh.topology import adjacency, edge_list

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

ROUNDS = 20
"""Rounds of measuring and pushing at most; two to five are usual."""

SPREAD, FADE = 8, 0.85
"""Rings of neighbours that a push carries with it, so that it leaves no spike, and what is left from ring to ring."""

PLAIN = 8
"""Rounds at the end that push nothing but the vertices concerned."""

EVENINGS = ((2, 12), (4, 8))
"""After which rounds all that was pushed so far is evened out along the cloth, and by how many averaging steps."""

OVERSHOOT = 2e-4
"""How much further than needed a vertex is pushed [m]: saves rounds where the surface curves."""

REACH = 0.03
"""Vertices further away than this from an obstacle at first are not measured again [m]."""


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A closed surface that a garment stays outside of."""

    vertices: Array
    """Vertices [m], shape [V, 3]."""
    faces: Faces
    """Triangles, counter-clockwise seen from outside, shape [F, 3]."""
    margin: float
    """Least distance of a garment's vertices [m]."""

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Exact distance of points [n, 3], negative inside [m], shape [n]; direction of its fastest increase [n, 3]."""
        distance, _, closest, normals = igl.signed_distance(
            np.ascontiguousarray(points, dtype=np.float64),
            np.ascontiguousarray(self.vertices, dtype=np.float64),
            np.ascontiguousarray(self.faces, dtype=np.int64),
            sign_type=igl.SIGNED_DISTANCE_TYPE_PSEUDONORMAL,
        )
        away = points - closest
        length = np.linalg.norm(away, axis=1)
        # On the surface itself the difference has no direction; the surface's normal has.
        direct = away * (np.sign(distance) / np.maximum(length, 1e-12))[:, None]
        return distance, np.where((length > 1e-5)[:, None], direct, normals)


def clear(points: Array, faces: Faces, obstacles: Sequence[Obstacle]) -> tuple[Array, float]:
    """Pushes a garment's vertices out of the obstacles, and their neighbours with them, so that it stays smooth.

    Args:
        points: Vertices of the garment [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        obstacles: What to stay out of.

    Returns:
        The vertices [m], shape [N, 3], and the least distance left beyond the margins [m]: 0 or more if all are kept.
    """
    points = points.copy()
    links = adjacency(edge_list(faces), len(points))
    averaging = sp.diags(1.0 / np.maximum(np.asarray(links.sum(axis=1)).reshape(-1), 1.0)) @ links
    measured = [obstacle.distance(points) for obstacle in obstacles]
    near = [np.flatnonzero(m[0] < o.margin + REACH) for m, o in zip(measured, obstacles)]
    start, evenings = points.copy(), dict(EVENINGS)
    for round_ in range(ROUNDS):
        push = np.zeros_like(points)
        for (distance, outwards), obstacle in zip(measured, obstacles):
            short = obstacle.margin - distance
            push += np.where(short > 0, short + OVERSHOOT, 0.0)[:, None] * outwards
        pushed = (push != 0).any(axis=1)
        if not pushed.any() and (round_ == 0 or round_ > max(evenings)):
            break
        points += _spread(push, pushed, averaging) if round_ < ROUNDS - PLAIN else push
        if round_ in evenings:
            total = points - start
            for _ in range(evenings[round_]):
                total = 0.5 * (total + averaging @ total)
            points = start + total
        for (distance, outwards), obstacle, around in zip(measured, obstacles, near):
            distance[around], outwards[around] = obstacle.distance(points[around])
    left = [float((m[0] - o.margin).min(initial=np.inf)) for m, o in zip(measured, obstacles)]
    return points, min(left)


def _spread(push: Array, pushed: NDArray[np.bool_], averaging: sp.csr_matrix) -> Array:
    """The push, fading over the neighbours of the pushed vertices."""
    spread = push
    for _ in range(SPREAD):
        spread = np.where(pushed[:, None], push, FADE * (averaging @ spread))
    return spread
