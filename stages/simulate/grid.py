"""A dense grid that sorts points into cells, in the points' own order: no hash and no atomics."""

import numpy as np
import taichi as ti

from stages.simulate.kernels import Array, Int, Real, Value, inline, kernel, vec

CELLS = 1 << 18
"""Most cells of a grid; a larger scene gets larger cells."""


@inline
def cell_of(p: Value, lo: Value, size: Value, dims: Value) -> Value:
    """Cell coordinates of point p, clamped into the grid."""
    c = ti.Vector([0, 0, 0])
    for k in ti.static(range(3)):
        c[k] = ti.max(0, ti.min(ti.i32(dims[k]) - 1, ti.i32(ti.floor((p[k] - lo[k]) / size))))
    return c


@kernel
def sort_into_cells(
    points: Array,
    lo: Array,
    size: Real,
    dims: Array,
    cells: Int,
    # outputs
    cell: Array,
    first: Array,
    items: Array,
) -> None:
    """Counting sort of `points` [n, 3]: the points of cell c are items[first[c]:first[c + 1]], ascending."""
    for i in range(points.shape[0]):
        c = cell_of(vec(points, i), lo, size, dims)
        cell[i] = (c[2] * dims[1] + c[1]) * dims[0] + c[0]
    for c in range(cells + 2):
        first[c] = 0
    for _ in range(1):
        for i in range(points.shape[0]):
            first[cell[i] + 2] += 1
        for c in range(cells):
            first[c + 2] += first[c + 1]
        for i in range(points.shape[0]):
            k = first[cell[i] + 1]
            items[k] = i
            first[cell[i] + 1] = k + 1


@kernel
def copy_balls(
    points: Array,
    radius: Array,
    items: Array,
    # outputs
    balls: Array,
) -> None:
    """balls[k] = (point, radius) of items[k]."""
    for k in range(points.shape[0]):
        i = items[k]
        for c in ti.static(range(3)):
            balls[k, c] = points[i, c]
        balls[k, 3] = radius[i]


class Grid:
    """Buffers of one grid over at most `count` points.

    Attributes:
        lo [m], size [m], dims: Origin, cell size and cells along each axis.
        first, items: Points of each cell; see `sort_into_cells`.
        balls: Centre and radius of the points in the order of `items` [m], shape [n, 4].
    """

    def __init__(self, count: int) -> None:
        self.cell, self.items = np.zeros(count, np.int32), np.zeros(count, np.int32)
        self.first, self.balls = np.zeros(CELLS + 2, np.int32), np.zeros((count, 4))
        self.lo, self.dims, self.size = np.zeros(3), np.ones(3, np.int32), 1.0

    def fill(self, points: np.ndarray, radius: np.ndarray, size: float, lo: np.ndarray, hi: np.ndarray) -> None:
        """Sort `points` [n, 3] into cells of at least `size` [m] over the box lo..hi; outside, they go to its rim.

        `radius` [n] comes along: the balls are copied in the order of the cells, so that a search reads them in turn.
        """
        extent = np.maximum(hi - lo, 1e-6)
        while True:
            dims = np.minimum(np.floor(extent / size) + 1, 1e6)
            if dims.prod() <= CELLS:
                break
            size *= 1.3
        self.lo, self.size, self.dims = np.ascontiguousarray(lo, np.float64), float(size), dims.astype(np.int32)
        sort_into_cells(points, self.lo, self.size, self.dims, int(dims.prod()), self.cell, self.first, self.items)
        copy_balls(points, radius, self.items, self.balls)
