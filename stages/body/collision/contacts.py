"""Where two segments touch, in one frame: vertices, the way out, and how much room there is."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.collision.intersect import Crossings
from stages.body.collision.segments import Segments
from stages.body.collision.vectors import cross, dot, squares

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

    def at(self, x: NDArray[np.float32], vertices: Index, first: Index | int = 0) -> Array:
        """Unit normals of `vertices`, weighted by area, shape [N, 3].

        Args:
            x: Vertices of bodies, one after the other [m], shape [T * V, 3].
            vertices: Vertices of a body, shape [N].
            first: Row of `x` where the body of each starts, shape [N].

        Returns:
            The normals.
        """
        corners = x[self.faces[self.about[vertices]] + np.reshape(first, (-1, 1, 1))].astype(np.float64)
        out = cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0]).sum(axis=1)
        return out / np.maximum(np.sqrt(dot(out, out)), 1e-30)[:, None]


def touch(
    segments: Segments,
    normals: Normals,
    x: NDArray[np.float32],
    near: Sequence[tuple[int, tuple[int, int], tuple[Index, Index]]],
    gap: float,
) -> Iterator[tuple[int, tuple[int, int], Contact]]:
    """Vertices of two segments that are nearer than `gap`, or inside each other.

    Args:
        segments: The person's segments.
        normals: Normals of the body.
        x: Vertices [m], shape [T, V, 3].
        near: Frame, pair of segments, and vertices of the first and of the second to look at.
        gap: Distance wanted [m].

    Yields:
        Frame, pair of segments, and their contact, where there is one.
    """
    nearest = [_nearest(x[t], rows) for t, _, rows in near]
    if not nearest:
        return
    # Of all frames and pairs together: who looks, `mine`, at whom, `theirs`.
    mine, theirs = (np.concatenate([found[k] for found in nearest]) for k in (0, 1))
    of_first = np.concatenate([found[2] for found in nearest])
    number = np.repeat(np.arange(len(near)), [len(found[0]) for found in nearest])
    rest = segments.rest[mine] - segments.rest[theirs]
    first = np.array([t for t, _, _ in near])[number] * x.shape[1]
    points = x.reshape(-1, 3)
    way = points[first + mine].astype(np.float64) - points[first + theirs]
    rest, apart = np.sqrt(dot(rest, rest)), np.sqrt(dot(way, way))
    kept = (rest > APART) & (rest > STRETCH * apart)
    mine, theirs, first, number, way, apart, of_first = (
        values[kept] for values in (mine, theirs, first, number, way, apart, of_first)
    )
    n_mine, n_theirs = normals.at(points, mine, first), normals.at(points, theirs, first)
    height = dot(way, n_theirs)
    distance = np.where((apart < TANGENT) | (height < -INWARD * apart), height, apart)
    kept = (distance < gap) & (dot(n_mine, n_theirs) < FACING)
    mine, theirs, number, of_first, weights = (v[kept] for v in (mine, theirs, number, of_first, gap - distance))
    turned = (n_theirs - n_mine)[kept] * np.where(of_first, 1.0, -1.0)[:, None]
    a, b = np.where(of_first, mine, theirs), np.where(of_first, theirs, mine)
    bounds = np.searchsorted(number, np.arange(len(near) + 1))
    for k in np.unique(number):
        rows = slice(bounds[k], bounds[k + 1])
        normal = weights[rows] @ turned[rows]
        t, pair, _ = near[k]
        yield t, pair, Contact(a[rows], b[rows], weights[rows], normal / max(float(np.linalg.norm(normal)), 1e-30))


def _nearest(x: NDArray[np.float32], rows: tuple[Index, Index]) -> tuple[Index, Index, NDArray[np.bool_]]:
    """Vertices of both `rows`, that of the other nearest to each, within `REACH`; and whether it is of the first."""
    squared = squares(x[rows[0]], x[rows[1]])
    b, a = squared.argmin(axis=1), squared.argmin(axis=0)
    far = REACH**2
    i = np.flatnonzero(squared[np.arange(len(b)), b] <= far)
    j = np.flatnonzero(squared[a, np.arange(len(a))] <= far)
    mine = np.concatenate([rows[0][i], rows[1][j]])
    return mine, np.concatenate([rows[1][b[i]], rows[0][a[j]]]), np.arange(len(mine)) < len(i)


def pierced(
    segments: Segments,
    normals: Normals,
    x: NDArray[np.float32],
    crossings: Crossings,
    pair: tuple[int, int],
    gap: float,
) -> Contact:
    """The contact of two segments where edges go through faces: the corners of both faces.

    Args:
        segments: The person's segments.
        normals: Normals of the body.
        x: Vertices [m], shape [V, 3].
        crossings: What was found in this frame.
        pair: The segments, of which there are some.
        gap: Distance wanted [m].

    Returns:
        The contact.
    """
    label = segments.face_label[crossings.faces]
    straight, swapped = (label == pair).all(axis=1), (label == pair[::-1]).all(axis=1)
    faces = np.concatenate([crossings.faces[straight], crossings.faces[swapped][:, ::-1]])
    a, b = (segments.faces[faces[:, k]].reshape(-1).astype(np.int64) for k in (0, 1))
    way = (normals.at(x, b) - normals.at(x, a)).sum(axis=0)
    return Contact(a, b, np.full(len(a), gap), way / max(float(np.linalg.norm(way)), 1e-30))
