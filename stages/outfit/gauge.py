"""Distances of a garment's vertices from an obstacle while they move: measured anew only where that could matter.

A vertex that has moved by m since it was d away is still d - m away at least, and on the same side of the surface while
m < |d|. Nothing is lost: all that is read within the distances asked for is exact.
"""

from collections.abc import Callable

import igl
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


class Obstacle:
    """A closed surface that a garment stays outside of."""

    def __init__(self, vertices: Array, faces: Faces, margin: float) -> None:
        """Prepares the search.

        Args:
            vertices: Vertices [m], shape [V, 3].
            faces: Triangles, counter-clockwise seen from outside, shape [F, 3].
            margin: Least distance of a garment's vertices [m].
        """
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.faces = np.ascontiguousarray(faces, dtype=np.int64)
        self.margin = margin
        self._boxes, self._winding = igl.AABB(), igl.FastWindingNumberBVH()
        self._boxes.init(self.vertices, self.faces)
        self._winding.init(self.vertices, self.faces, 2)

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Distance of points [m], negative inside, shape [n]; direction of its fastest increase, 0 on the surface.

        The distance is exact. Its sign comes from the winding number: the nearest triangle's side, which others use,
        lies where extreme bodies fold into themselves.
        """
        return self._signed(points, lambda _: self._inside(points))

    def followed(self, points: Array, before: Array, moved: Array) -> tuple[Array, Array]:
        """The same for points that were at distances `before` [n] until they moved by `moved` [n] [m]."""

        def inside(length: Array) -> NDArray[np.bool_]:
            within = before < 0
            crossed = np.flatnonzero(moved >= np.abs(before))
            within[crossed] = self._inside(points[crossed])
            return within

        return self._signed(points, inside)

    def _signed(self, points: Array, inside: Callable[[Array], NDArray[np.bool_]]) -> tuple[Array, Array]:
        points = np.ascontiguousarray(points, dtype=np.float64)
