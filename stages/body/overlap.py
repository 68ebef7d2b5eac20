"""How near one part of the body comes to another, frame by frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Points = NDArray[np.float32]

FAR = 0.08
"""Distances are not looked at beyond this [m]."""

TANGENT = 0.03
"""Nearer than this, the tangent plane at the nearest point gives the distance; points lie 14 mm apart [m]."""

INWARD = 0.5
"""Farther away, a point is inside only if it lies below that plane by this share of its distance."""


@dataclass(frozen=True, eq=False)
class Nearness:
    """The signed distance of points to a part, and which way leads out."""

    distance: NDArray[np.float64]
    """Signed distance, negative inside, at most `FAR` [m], shape [N]."""
    normals: Points
    """Outward normal of the other part there, shape [N, 3]."""


def nearness(points: Points, surface: Points, normals: Points) -> Nearness:
    """Signed distances of points to a surface that is given by points and normals.

    Args:
        points: Points to test [m], shape [N, 3].
        surface: Points of the surface [m], shape [M, 3].
        normals: Outward normals there, shape [M, 3].

    Returns:
        Distance and way out of each point.
    """
    if not len(points):
        return Nearness(distance=np.zeros(0), normals=points)
    inside = (surface > points.min(axis=0) - FAR) & (surface < points.max(axis=0) + FAR)
    near = np.flatnonzero(inside[:, 0] & inside[:, 1] & inside[:, 2])
    if not len(near):
        return Nearness(distance=np.full(len(points), FAR), normals=np.zeros_like(points))
    apart, index = cKDTree(surface[near]).query(points, distance_upper_bound=FAR)
    found = np.isfinite(apart)
    index = near[np.where(found, index, 0)]
    way = normals[index]
    height = np.einsum("ni,ni->n", points - surface[index], way).astype(np.float64)
    inside = height < -INWARD * apart
    distance = np.where((apart < TANGENT) | inside, height, apart)
    return Nearness(distance=np.where(found, distance, FAR), normals=way)
