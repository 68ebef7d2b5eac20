"""The broad phase: boxes about segments, about patches of a few centimetres of skin in them, and about single rows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.collision.segments import Segments

SIZE = 0.04
"""Side of the cubes that cut the skin into patches [m]."""

Index = NDArray[np.int64]
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

    def near(self, low: NDArray[np.float32], high: NDArray[np.float32], reach: float = 0.0) -> Index:
        """Pairs of patches whose boxes come nearer than `reach`.

        Args:
            low: Lowest corner of each row, in the order of `order` [m], shape [N, 3].
            high: Highest corner [m], shape [N, 3].
            reach: Distance [m].

        Returns:
            Patches, shape [M, 2].
        """
        return self.near_boxes(merged((low - np.float32(reach) / 2, high + np.float32(reach) / 2), self.start))

    def near_boxes(self, boxes: Boxes) -> Index:
        """Pairs of patches whose boxes, of shape [P, 3], overlap, shape [M, 2]."""
        return product(self.pairs, merged(boxes, self.segment_start), self.segment_start, boxes)


def cut(points: NDArray[np.float64], label: Index, pairs: tuple[tuple[int, int], ...]) -> Patches:
    """Cuts points in the T-pose [m], shape [N, 3], of segments `label` [N], into patches."""
    cells, patch = np.unique(
        np.column_stack([label, np.floor(points / SIZE).astype(np.int64)]), axis=0, return_inverse=True
    )
    order = np.argsort(patch.reshape(-1), kind="stable")
    start = np.append(0, np.cumsum(np.bincount(patch.reshape(-1))))
    segments, first = np.unique(cells[:, 0], return_index=True)
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


def overlap(a: Boxes, rows_a: Index, b: Boxes, rows_b: Index) -> NDArray[np.bool_]:
    """Whether boxes rows_a of a overlap boxes rows_b of b, one by one."""
    apart = np.take(a[0], rows_a, axis=0) > np.take(b[1], rows_b, axis=0)
    apart |= np.take(b[0], rows_b, axis=0) > np.take(a[1], rows_a, axis=0)
    return ~(apart[:, 0] | apart[:, 1] | apart[:, 2])


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
    """Patches of vertices that come near each other, though they lie far apart on the skin."""

    def __init__(self, segments: Segments, apart: float) -> None:
        """Leaves out pairs of patches that are nearer than `apart` [m] to each other in the T-pose."""
        self.patches = cut(segments.rest, segments.label, segments.pairs)
        rows = segments.rest[self.patches.order].astype(np.float32)
        low, high = merged((rows, rows), self.patches.start)
        self.apart = np.zeros((len(low), len(low)), bool)
        for k in range(3):
            self.apart |= low[:, None, k] > high[None, :, k] + apart
            self.apart |= low[None, :, k] > high[:, None, k] + apart

    def find(self, x: NDArray[np.float32], reach: float) -> dict[tuple[int, int], tuple[Index, Index]]:
        """What is nearer than `reach` [m] in vertices x [m], shape [V, 3].

        Returns:
            Vertices of the first and of the second segment in such patches, for each pair of segments that has any.
        """
        patches = self.patches
        rows = x[patches.order]
        pairs = patches.near(rows, rows, reach)
        pairs = pairs[self.apart[pairs[:, 0], pairs[:, 1]]]
        segment = np.searchsorted(patches.segment_start, pairs, side="right") - 1
        found = {}
        for a, b in np.unique(segment, axis=0):
            mine = pairs[(segment == (a, b)).all(axis=1)]
            found[int(patches.segments[a]), int(patches.segments[b])] = (self._rows(mine[:, 0]), self._rows(mine[:, 1]))
        return found

    def _rows(self, patches: Index) -> Index:
        start = self.patches.start
        return np.concatenate([self.patches.order[start[p] : start[p + 1]] for p in np.unique(patches)])
