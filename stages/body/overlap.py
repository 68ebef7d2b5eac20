"""How near one part of the body comes to another, frame by frame."""

from dataclasses import dataclass
from functools import cached_property

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


class Surface:
    """Points of a surface in one frame, in a tree that is built when first asked."""

    def __init__(self, points: Points, normals: Points) -> None:
        """Takes points [m] and outward normals, shape [M, 3] each."""
        self.points, self.normals = points, normals

    @cached_property
    def tree(self) -> cKDTree:
        """The points; not balanced, as a tree that few questions are asked takes longest to build."""
        return cKDTree(self.points, balanced_tree=False, compact_nodes=False)

    def nearness(self, points: Points) -> Nearness:
        """Distance and way out of points [m], shape [N, 3]."""
        if not len(points) or not len(self.points):
            return Nearness(distance=np.full(len(points), FAR), normals=np.zeros_like(points))
        apart, index = self.tree.query(points, distance_upper_bound=FAR)
        found = np.isfinite(apart)
        index = np.where(found, index, 0)
        way = self.normals[index]
        height = np.einsum("ni,ni->n", points - self.points[index], way).astype(np.float64)
        inside = height < -INWARD * apart
        distance = np.where((apart < TANGENT) | inside, height, apart)
        return Nearness(distance=np.where(found, distance, FAR), normals=way)
