"""Which edges of one segment go through which faces of another: the exact test, both ways, in posed bodies."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.collision.patches import Patches, cut, product
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
        sizes = np.diff(self.patches.start)
        self.patch_of = np.empty(len(self.faces), np.int64)
        self.patch_of[self.patches.order] = np.repeat(np.arange(len(sizes)), sizes)
        # Each patch's vertices, once.
        count = len(segments.rest)
        corners = np.unique(self.patch_of[:, None] * count + self.faces)
        self.vertices = corners % count
        self.vertex_start = np.searchsorted(corners, np.arange(len(sizes) + 1) * count)

    def crossings(
        self, x: NDArray[np.float32], known: Sequence[Crossings] | None = None, moved: Mask | None = None
    ) -> list[Crossings]:
        """All crossings between the pairs of segments, body by body.

        Args:
            x: Vertices [m], shape [T, V, 3].
            known: What was found in these bodies before some skin moved; None looks for everything.
            moved: The vertices that moved since, shape [V].

        Returns:
            The crossings; those of skin that didn't move come first.
        """
        asked = np.ones(len(self.patches.start) - 1, bool)
        if known is not None and moved is not None:
            asked = np.logical_or.reduceat(moved[self.vertices], self.vertex_start[:-1])
        out = self._found(x, asked)
        for t, old in enumerate(known or ()):
            if len(old):
                stays = ~asked[self.patch_of[old.faces]].any(axis=1)
                faces, points = old.faces[stays], old.points[stays]
                out[t] = Crossings(np.concatenate([faces, out[t].faces]), np.concatenate([points, out[t].points]))
        return out

    def _found(self, x: NDArray[np.float32], asked: Mask) -> list[Crossings]:
        """Crossings in bodies x [m], shape [T, V, 3], of the patches `asked` for, shape [P]."""
        patches, sizes = self.patches, np.diff(self.patches.start)
        boxes = patches.boxes(x, self.vertices, self.vertex_start)
        near = patches.near(boxes)
        near = near[asked[near % len(sizes)].any(axis=1)]
        # Boxes about faces only where patches meet.
        meets = np.zeros(len(boxes[0]), bool)
        meets[near] = True
        sizes = np.tile(sizes, len(x))
        used = np.flatnonzero(np.repeat(meets, sizes))
        frame, face = used // len(self.faces), patches.order[used % len(self.faces)]
        rows = self.faces[face] + x.shape[1] * frame[:, None]
        corners = np.take(x.reshape(-1, 3), rows, axis=0)
        low = np.minimum(np.minimum(corners[:, 0], corners[:, 1]), corners[:, 2])
        high = np.maximum(np.maximum(corners[:, 0], corners[:, 1]), corners[:, 2])
        a, b = product(near, boxes, np.append(0, np.cumsum(sizes * meets)), (low, high)).T
        for one, other in ((0, 1), (1, 0)):
            pair = (a, b)
            keep = _straddles(corners, pair[one], pair[other])
            a, b = a[keep], b[keep]
        edge_of, pierced, points = _pierced(corners, rows, np.concatenate([a, b]), np.concatenate([b, a]))
        out = []
        for t in range(len(x)):
            mine = frame[edge_of] == t
            out.append(Crossings(face[np.column_stack([edge_of[mine], pierced[mine]])], points[mine]))
        return out


def _straddles(corners: NDArray[np.float32], of: Index, plane: Index) -> Mask:
    """Whether the corners of faces `of` lie on both sides of the planes of faces `plane`."""
    tri = corners[plane].astype(np.float64)
    normal = cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    height = np.stack([dot(corners[of, k] - tri[:, 0], normal) for k in range(3)])
    nothing = ROUNDING * np.sqrt(dot(normal, normal))  # corners that both faces share are this near
    return (height.min(axis=0) < -nothing) & (height.max(axis=0) > nothing)


def _pierced(corners: NDArray[np.float32], names: Index, edge_of: Index, pierced: Index) -> tuple[Index, Index, Array]:
    """Edges of the faces `edge_of` that go through the faces `pierced`, pair by pair; and where.

    An edge goes through a face if its ends lie on either side of the plane, and it passes all three sides of the face
    in the same sense. Edges that end in a corner of the face touch it only there. `corners` [F, 3, 3] are those of the
    faces, `names` [F, 3] tell which are the same.
    """
    found, points = [], []
    tri, own = corners[pierced].astype(np.float64), corners[edge_of].astype(np.float64)
    normal = cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    height = [dot(own[:, k] - tri[:, 0], normal) for k in range(3)]
    shared = [(names[edge_of, k, None] == names[pierced]).any(axis=1) for k in range(3)]
    for k in range(3):
        end = (k + 1) % 3
        rows = np.flatnonzero((height[k] * height[end] < 0) & ~shared[k] & ~shared[end])
        p, q = own[rows, k], own[rows, end]
        about = [dot(q - p, cross(tri[rows, i] - p, tri[rows, (i + 1) % 3] - p)) for i in range(3)]
        same = np.abs(np.sign(np.stack(about)).sum(axis=0)) == 3
        rows, p, q = rows[same], p[same], q[same]
        share = height[k][rows] / (height[k][rows] - height[end][rows])
        found.append(rows)
        points.append(p + share[:, None] * (q - p))
    kept = np.concatenate(found)
    return edge_of[kept], pierced[kept], np.concatenate(points)
