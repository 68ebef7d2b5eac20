"""Which edges of one segment go through which faces of another: the exact test, both ways, in one posed body."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stages.body.collision.patches import Patches, cut, merged, product
from stages.body.collision.segments import Segments
from stages.body.collision.vectors import cross, dot

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]

ROUNDING = 1e-12
"""Heights over a plane below this are rounding errors [m]."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """Edges that go through faces of another segment."""

    faces: Index
    """The edge's face and the face that is pierced, shape [C, 2]."""
    points: Array
    """Where [m], shape [C, 3]."""

    def __len__(self) -> int:
        """Number of crossings C."""
        return len(self.faces)


class Intersector:
    """Tests posed bodies of one person."""

    def __init__(self, segments: Segments) -> None:
        """Cuts the faces into patches."""
        self.faces = segments.faces.astype(np.int64)
        centres = segments.rest[self.faces].mean(axis=1)
        self.patches: Patches = cut(centres, segments.face_label, segments.pairs)
        self.ordered = segments.faces[self.patches.order]
        bounds = [np.unique(self.ordered[a:b]) for a, b in pairwise(self.patches.start)]
        self.vertices = np.concatenate(bounds)
        self.vertex_start = np.append(0, np.cumsum([len(rows) for rows in bounds]))
        self.patch_of = np.empty(len(self.faces), np.int64)
        self.patch_of[self.patches.order] = np.repeat(np.arange(len(bounds)), np.diff(self.patches.start))

    def crossings(self, x: NDArray[np.float32], known: Crossings | None = None, moved: Mask | None = None) -> Crossings:
        """All crossings between the pairs of segments.

        Args:
            x: Vertices [m], shape [V, 3].
            known: What was found in this frame before some skin moved; None looks for everything.
            moved: The vertices that moved since, shape [V].

        Returns:
            The crossings; those of skin that didn't move come first.
        """
        near = np.ones(len(self.patches.start) - 1, bool)
        if known is not None and moved is not None:
            near = np.logical_or.reduceat(moved[self.vertices], self.vertex_start[:-1])
        a, b = self._candidates(x, near)
        found = _pierced(x.astype(np.float64), self.faces, np.concatenate([a, b]), np.concatenate([b, a]))
        if known is None or not len(known):
            return found
        stays = ~near[self.patch_of[known.faces]].any(axis=1)
        return Crossings(
            np.concatenate([known.faces[stays], found.faces]), np.concatenate([known.points[stays], found.points])
        )

    def _candidates(self, x: NDArray[np.float32], asked: Mask) -> tuple[Index, Index]:
        """Pairs of faces, one of a patch `asked` for, whose boxes overlap and neither of which lies on one side."""
        patches = self.patches
        rows = np.take(x, self.vertices, axis=0)
        boxes = merged((rows, rows), self.vertex_start)
        near = patches.near_boxes(boxes)
        near = near[asked[near].any(axis=1)]
        # Boxes about faces only where patches meet.
        meets = np.zeros(len(boxes[0]), bool)
        meets[near] = True
        used = np.flatnonzero(np.repeat(meets, np.diff(patches.start)))
        start = np.append(0, np.cumsum(np.diff(patches.start) * meets))
        corners = np.take(x, self.ordered[used], axis=0)
        low = np.minimum(np.minimum(corners[:, 0], corners[:, 1]), corners[:, 2])
        high = np.maximum(np.maximum(corners[:, 0], corners[:, 1]), corners[:, 2])
        a, b = product(near, boxes, start, (low, high)).T
        for one, other in ((0, 1), (1, 0)):
            pair = (a, b)
            keep = _straddles(corners, pair[one], pair[other])
            a, b = a[keep], b[keep]
        order = patches.order[used]
        return order[a], order[b]


def _straddles(corners: NDArray[np.float32], of: Index, plane: Index) -> NDArray[np.bool_]:
    """Whether the corners of faces `of` lie on both sides of the planes of faces `plane`."""
    tri = corners[plane].astype(np.float64)
    normal = cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    height = np.einsum("nki,ni->nk", corners[of] - tri[:, :1], normal)
    nothing = ROUNDING * np.linalg.norm(normal, axis=1)  # corners that both faces share are this near
    return (height.min(axis=1) < -nothing) & (height.max(axis=1) > nothing)


def _pierced(x: Array, faces: Index, edge_of: Index, pierced: Index) -> Crossings:
    """Edges of the faces `edge_of` that go through the faces `pierced`, pair by pair.

    An edge goes through a face if its ends lie on either side of the plane, and it passes all three sides of the face
    in the same sense. Edges that end in a corner of the face touch it only there.
    """
    found, points = [], []
    tri = x[faces[pierced]]
    normal = cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    for k in range(3):
        ends = faces[edge_of][:, [k, (k + 1) % 3]]
        apart = (ends[:, :, None] != faces[pierced][:, None, :]).all(axis=(1, 2))
        p, q = x[ends[:, 0]], x[ends[:, 1]]
        up = dot(p - tri[:, 0], normal)
        down = dot(q - tri[:, 0], normal)
        rows = np.flatnonzero(apart & (up * down < 0))
        way = q[rows] - p[rows]
        about = [dot(way, cross(tri[rows, i] - p[rows], tri[rows, (i + 1) % 3] - p[rows])) for i in range(3)]
        same = np.abs(np.sign(np.stack(about)).sum(axis=0)) == 3
        rows = rows[same]
        share = up[rows] / (up[rows] - down[rows])
        found.append(np.column_stack([edge_of[rows], pierced[rows]]))
        points.append(p[rows] + share[:, None] * (q[rows] - p[rows]))
    return Crossings(np.concatenate(found), np.concatenate(points))
