"""The broad phase: boxes about segments, about patches of a few centimetres of skin in them, and about single rows."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

SIZE = 0.04
"""Side of the cubes that cut the skin into patches [m]."""

Index = NDArray[np.int64]
Pairs = tuple[tuple[int, int], ...]
Boxes = tuple[NDArray[np.float32], NDArray[np.float32]]
"""Lowest and highest corners [m], shape [N, 3] each."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Patches:
    """Rows of something - vertices or faces - in patches, each within one segment."""

    order: Index
    """The rows, patch by patch and segment by segment, shape [N]."""
    start: Index
    """Where each patch starts in `order`, and the end, shape [P + 1]."""
    segments: Index
    """Those segments that have rows, ascending, shape [S]."""
    segment_start: Index
    """Where the patches of each of `segments` start, and the end, shape [S + 1]."""
    pairs: Index
    """Pairs of rows of `segments` to look at, the first before the second, shape [M, 2]."""

    def boxes(self, x: NDArray[np.float32], rows: Index, start: Index) -> Boxes:
        """Boxes about the patches of posed bodies.

        Args:
            x: Vertices [m], shape [T, V, 3].
            rows: Vertices of each patch, patch by patch, shape [N].
            start: Where each patch starts in `rows`, and the end, shape [P + 1].

        Returns:
            Lowest and highest corners [m], shape [T * P, 3], body by body.
        """
        # Vertex by vertex the numbers of all bodies lie side by side.
        moving = np.ascontiguousarray(x.transpose(1, 0, 2)).reshape(x.shape[1], -1)
        low, high = (
            np.ascontiguousarray(box.reshape(len(start) - 1, len(x), 3).transpose(1, 0, 2)).reshape(-1, 3)
            for box in merged((moving[rows],) * 2, start)
        )
        return low, high

    def near(self, boxes: Boxes) -> Index:
        """Pairs of patches whose boxes overlap, body by body.

        Args:
            boxes: Those of the patches of T bodies, shape [T * P, 3].

        Returns:
            Rows of `boxes`, shape [M, 2].
        """
        count, segments = len(self.start) - 1, len(self.segments)
        body = np.arange(len(boxes[0]) // count)
        start = np.append((self.segment_start[:-1] + count * body[:, None]).reshape(-1), len(boxes[0]))
        pairs = (self.pairs + segments * body[:, None, None]).reshape(-1, 2)
        return product(pairs, merged(boxes, start), start, boxes)


def cut(points: NDArray[np.float64], label: Index, pairs: Pairs, size: float = SIZE) -> Patches:
    """Cuts points in the T-pose [m], shape [N, 3], of segments `label` [N], into patches in cubes of side `size`."""
    cube = np.floor(points / size).astype(np.int64)
    cube -= cube.min(axis=0)
    cells, patch = np.unique(
        np.ravel_multi_index((label, *cube.T), (label.max() + 1, *cube.max(axis=0) + 1)), return_inverse=True
    )
    order = np.argsort(patch, kind="stable")
    start = np.append(0, np.cumsum(np.bincount(patch)))
    segments, first = np.unique(label[order[start[:-1]]], return_index=True)
    place = {int(segment): k for k, segment in enumerate(segments)}
    return Patches(
        order=order,
        start=start,
        segments=segments,
        segment_start=np.append(first, len(cells)),
        pairs=np.array([(place[a], place[b]) for a, b in pairs if a in place and b in place]).reshape(-1, 2),
    )


def merged(boxes: Boxes, start: Index) -> Boxes:
    """Boxes about each stretch of `boxes` that begins at an entry of `start` [P + 1] and ends at the next."""
    return np.minimum.reduceat(boxes[0], start[:-1]), np.maximum.reduceat(boxes[1], start[:-1])


def overlap(a: Boxes, rows_a: Index, b: Boxes, rows_b: Index) -> Index:
    """Those k for which box rows_a[k] of a overlaps box rows_b[k] of b, ascending."""
    kept = np.arange(len(rows_a))
    for axis in range(3):  # one axis after the other: most are apart along the first
        (low_a, high_a), (low_b, high_b) = ((low[:, axis], high[:, axis]) for low, high in (a, b))
        i, j = rows_a[kept], rows_b[kept]
        kept = kept[(low_a[i] <= high_b[j]) & (low_b[j] <= high_a[i])]
    return kept


def product(pairs: Index, parents: Boxes, start: Index, children: Boxes) -> Index:
    """Pairs of children whose boxes overlap, of the pairs of parents whose boxes do.

    Args:
        pairs: Pairs of parents, shape [M, 2].
        parents: Their boxes.
        start: Where the children of each parent start, and the end, shape [P + 1].
        children: The children's boxes.

    Returns:
        Pairs of children, those of the first parent first, shape [K, 2].
    """
    pairs = pairs[overlap(parents, pairs[:, 0], parents, pairs[:, 1])]
    # Only children that reach into the box that both parents have in common.
    common = (
        np.maximum(parents[0][pairs[:, 0]], parents[0][pairs[:, 1]]),
        np.minimum(parents[1][pairs[:, 0]], parents[1][pairs[:, 1]]),
    )
    groups, rows = [], []
    for side in (0, 1):
        begin = start[pairs[:, side]]
        count = start[pairs[:, side] + 1] - begin
        group = np.repeat(np.arange(len(pairs)), count)
        row = np.repeat(begin - (np.cumsum(count) - count), count) + np.arange(len(group))
        inside = overlap(children, row, common, group)
        groups.append(group[inside])
        rows.append(row[inside])
    count = np.bincount(groups[1], minlength=len(pairs))
    times = count[groups[0]]
    first = (np.cumsum(count) - count)[groups[0]] - (np.cumsum(times) - times)
    a = np.repeat(rows[0], times)
    b = rows[1][np.repeat(first, times) + np.arange(len(a))]
    both = overlap(children, a, children, b)
    return np.column_stack([a[both], b[both]])


class Nearby:
    """Patches of points that come near each other, though they lie far apart on the skin."""

    def __init__(
        self,
        rest: NDArray[np.float64],
        label: Index,
        pairs: tuple[tuple[int, int], ...],
        apart: float,
        size: float = SIZE,
    ) -> None:
        """Cuts points into patches.

        Args:
            rest: The points in the T-pose [m], shape [N, 3].
            label: Segment of each, shape [N].
            pairs: Segments to look at.
            apart: Pairs of patches that are nearer than this to each other in the T-pose are left out [m].
            size: Side of the cubes that cut them [m].
        """
        self.patches = cut(rest, label, pairs, size)
        rows = rest[self.patches.order].astype(np.float32)
        low, high = merged((rows, rows), self.patches.start)
        self.apart = np.zeros((len(low), len(low)), bool)
        for k in range(3):
            self.apart |= low[:, None, k] > high[None, :, k] + apart
            self.apart |= low[None, :, k] > high[:, None, k] + apart

    def find(self, x: NDArray[np.float32], reach: float) -> list[tuple[int, tuple[int, int], tuple[Index, Index]]]:
        """What is nearer than `reach` [m] where the points are at x [m], shape [T, N, 3].

        Returns:
            Frame, pair of segments, and points of the first and of the second in patches that come near each other.
        """
        patches, count = self.patches, len(self.patches.start) - 1
        low, high = patches.boxes(x, patches.order, patches.start)
        pairs = patches.near((low - np.float32(reach) / 2, high + np.float32(reach) / 2))
        frame, (a, b) = pairs[:, 0] // count, (pairs % count).T
        apart = self.apart[a, b]
        frame, a, b = frame[apart], a[apart], b[apart]
        if not len(frame):
            return []
        one, other = (np.searchsorted(patches.segment_start, rows, side="right") - 1 for rows in (a, b))
        # They come frame by frame, and pair by pair of segments.
        new = (np.diff(frame) != 0) | (np.diff(one) != 0) | (np.diff(other) != 0)
        bounds = np.concatenate([[0], np.flatnonzero(new) + 1, [len(frame)]])
        return [
            (
                int(frame[i]),
                (int(patches.segments[one[i]]), int(patches.segments[other[i]])),
                (self._rows(one[i], a[i:j]), self._rows(other[i], b[i:j])),
            )
            for i, j in pairwise(bounds.tolist())
        ]

    def _rows(self, segment: int, patches: Index) -> Index:
        """Points of some patches of a segment."""
        first, last = self.patches.segment_start[segment : segment + 2]
        start = self.patches.start[first : last + 1]
        used = np.zeros(last - first, bool)
        used[patches - first] = True
        return self.patches.order[start[0] : start[-1]][np.repeat(used, np.diff(start))]
