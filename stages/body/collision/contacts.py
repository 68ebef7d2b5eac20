"""Where two segments touch, in one frame: vertices, the way out, and how much room there is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from stages.body.collision.intersect import Crossings
from stages.body.collision.segments import Segments
from stages.body.collision.vectors import cross, dot

Array = NDArray[np.float64]
Index = NDArray[np.int64]

REACH = 0.05
"""Vertices deeper inside than this aren't recognised as such [m]."""

TANGENT = 0.02
"""Nearer than this, the height over the tangent plane at the nearest vertex is the distance [m]."""

INWARD = 0.5
"""Farther away, a vertex is inside only if it lies below that plane by this share of its distance."""

APART = 0.025
"""Vertices nearer than this in the T-pose are neighbours across the seam, and no contact [m]."""

STRETCH = 2.5
"""So are those whose distance in the T-pose is less than so many times that in the pose."""

FACING = 0.3
"""Skin that touches faces each other: the cosine of the angle between its normals is below this."""


@dataclass(frozen=True, eq=False)
class Contact:
    """Vertices of both segments that touch, pair by pair."""

    a: Index
    """Vertices of the first segment, shape [N]."""
    b: Index
    """Vertices of the second, shape [N]."""
    weights: Array
    """How much nearer than wanted they are [m], shape [N]."""
    normal: Array
    """Unit vector from the second segment to the first, shape [3]."""

    def only(self, chosen: NDArray[np.bool_]) -> "Contact":
        """The pairs of vertices that are `chosen` [N]."""
        return Contact(self.a[chosen], self.b[chosen], self.weights[chosen], self.normal)


class Normals:
    """Normals at the vertices of posed bodies, where they are asked for."""

    def __init__(self, faces: NDArray[np.int32], count: int) -> None:
        """Lists the faces about each of `count` vertices."""
        corner = faces.reshape(-1)
        order = np.argsort(corner, kind="stable")
        place = np.arange(len(order)) - np.searchsorted(corner[order], corner[order])
        # As many columns as the busiest vertex has faces; the others' are filled up with a face without area.
        self.about = np.full((count, place.max() + 1), len(faces))
        self.about[corner[order], place] = order // 3
        self.faces = np.concatenate([faces, np.zeros((1, 3), faces.dtype)])

    def at(self, x: NDArray[np.float32], vertices: Index) -> Array:
        """Unit normals of `vertices`, weighted by area, in the body x [m], shape [N, 3]."""
        corners = x[self.faces[self.about[vertices]]].astype(np.float64)
        out = cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0]).sum(axis=1)
        return out / np.maximum(np.sqrt(dot(out, out)), 1e-30)[:, None]


def touch(
    segments: Segments, normals: Array, x: NDArray[np.float32], rows: tuple[Index, Index], gap: float
) -> Contact | None:
    """Vertices of two segments that are nearer than `gap`, or inside each other.

    Args:
        segments: The person's segments.
        normals: Unit normals, of use at `rows`, shape [V, 3].
        x: Vertices [m], shape [V, 3].
        rows: Vertices of the first and of the second segment to look at.
        gap: Distance wanted [m].

    Returns:
        The contact; None if there is none.
    """
    n_a, n_b = normals[rows[0]], normals[rows[1]]
    x_a, x_b = x[rows[0]].astype(np.float64), x[rows[1]].astype(np.float64)
    one = _inside(segments, (x_a, n_a, rows[0]), (x_b, n_b, rows[1]), gap)
    other = _inside(segments, (x_b, n_b, rows[1]), (x_a, n_a, rows[0]), gap)
    a, b = np.concatenate([one[0], other[1]]), np.concatenate([one[1], other[0]])
    weights = np.concatenate([one[2], other[2]])
    if not len(a):
        return None
    way = weights @ (n_b[b] - n_a[a])
    return Contact(rows[0][a], rows[1][b], weights, way / max(float(np.linalg.norm(way)), 1e-30))


def _inside(
    segments: Segments, mine: tuple[Array, Array, Index], theirs: tuple[Array, Array, Index], gap: float
) -> tuple[Index, Index, Array]:
    """Rows of `mine` and of `theirs` that are nearer than `gap`, and how much nearer [m]."""
    x, n, vertices = mine
    apart, near = cKDTree(theirs[0]).query(x, distance_upper_bound=REACH)
    i = np.flatnonzero(np.isfinite(apart))
    j, apart = near[i], apart[i]
    height = dot(x[i] - theirs[0][j], theirs[1][j])
    distance = np.where((apart < TANGENT) | (height < -INWARD * apart), height, apart)
    rest = np.linalg.norm(segments.rest[vertices[i]] - segments.rest[theirs[2][j]], axis=1)
    facing = dot(n[i], theirs[1][j]) < FACING
    kept = (distance < gap) & (rest > APART) & (rest > STRETCH * apart) & facing
    return i[kept], j[kept], gap - distance[kept]


def pierced(
    segments: Segments,
    normals: Normals,
    x: NDArray[np.float32],
    crossings: Crossings,
    pair: tuple[int, int],
    gap: float,
) -> Contact | None:
    """The contact of two segments where edges go through faces: the corners of both faces.

    Args:
        segments: The person's segments.
        normals: Normals of the body.
        x: Vertices [m], shape [V, 3].
        crossings: What was found in this frame.
        pair: The segments.
        gap: Distance wanted [m].

    Returns:
        The contact; None if there is none.
    """
    label = segments.face_label[crossings.faces]
    straight, swapped = (label == pair).all(axis=1), (label == pair[::-1]).all(axis=1)
    faces = np.concatenate([crossings.faces[straight], crossings.faces[swapped][:, ::-1]])
    if not len(faces):
        return None
    a, b = (segments.faces[faces[:, k]].reshape(-1).astype(np.int64) for k in (0, 1))
    way = (normals.at(x, b) - normals.at(x, a)).sum(axis=0)
    return Contact(a, b, np.full(len(a), gap), way / max(float(np.linalg.norm(way)), 1e-30))
