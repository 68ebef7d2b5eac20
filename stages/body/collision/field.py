"""How far each vertex moves along the plane's normal: nowhere less than needed, smooth in time and over the skin."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, maximum_filter1d
from scipy.spatial import cKDTree

from stages.body.collision.segments import Segments

Field = NDArray[np.float32]
Index = NDArray[np.int64]

GLIDE = 2.0
"""Standard deviation in time of a movement's coming and going [frames]."""

HOLD = 5
"""Frames for which a vertex stays where it is needed, before and after: `GLIDE` then undercuts no need."""

SLOPE = 1.0
"""Steepest change of a movement over the skin, where no need is steeper."""

SWEEPS = 8
"""Sweeps over the skin that round the movement off."""


def envelope(need: Field) -> Field:
    """A curve that is smooth in time and nowhere less than `need` [m], shape [T, N]."""
    wide = maximum_filter1d(need, 2 * HOLD + 1, axis=0, mode="nearest")
    return np.asarray(gaussian_filter1d(wide, GLIDE, axis=0, mode="nearest", truncate=HOLD / GLIDE), np.float32)


def spread(segments: Segments, pair: tuple[int, int], need: Field, rows: Index) -> tuple[Index, Field]:
    """Spreads what some vertices need over the skin about them.

    A movement falls off with the distance d in the T-pose, u_i = max_j (need_j - SLOPE d_ij), and is then rounded off
    by a few sweeps of u = mean(u of the neighbours) over the obstacle |u| >= need. It is positive on the first segment
    and negative on the second; elsewhere the two are added.

    Args:
        segments: The person's segments.
        pair: The two segments.
        need: How far each vertex must move away from the other segment, shape [T, N] [m].
        rows: Those vertices, of either segment, shape [N].

    Returns:
        Vertices [M], and their movement along the normal towards the first segment [m], shape [T, M].
    """
    label, rest = segments.label, segments.rest
    reach = float(need.max()) / SLOPE
    low, high = rest[rows].min(axis=0) - reach, rest[rows].max(axis=0) + reach
    about = np.flatnonzero(((rest > low) & (rest < high)).all(axis=1))
    about = about[np.isfinite(cKDTree(rest[rows]).query(rest[about], distance_upper_bound=reach)[0])]
    region = np.union1d(about, rows)
    u = np.zeros((len(region), len(need)), np.float32)
    floor, ceiling = np.full_like(u, -np.inf), np.full_like(u, np.inf)
    for side, bound, own, other in ((1, floor, *pair), (-1, ceiling, *pair[::-1])):
        mine = label[rows] == own
        if mine.any():
            may = np.flatnonzero(label[region] != other)
            u[may] += side * _cones(rest[region[may]], rest[rows[mine]], need.T[mine])
        bound[label[region] == own] = 0.0
        bound[np.searchsorted(region, rows[mine])] = side * need.T[mine]
    local = sp.csr_array(segments.mean[region][:, region])
    for _ in range(SWEEPS):
        u = np.clip(local @ u, floor, ceiling)
    return region, np.ascontiguousarray(u.T)


def _cones(points: NDArray[np.float64], peaks: NDArray[np.float64], height: Field) -> Field:
    """max_j (height_j - SLOPE d_ij), at least 0, of points [M, 3] and peaks [N, 3] of some height [N, T]: [M, T]."""
    out = np.zeros((len(points), height.shape[1]), np.float32)
    highest = height.max(axis=1)
    for peak, tall, row in zip(peaks, highest, height):
        fall = (SLOPE * np.sqrt(((points - peak) ** 2).sum(axis=1))).astype(np.float32)
        under = np.flatnonzero(fall < tall)
        out[under] = np.maximum(out[under], row[None] - fall[under, None])
    return out
