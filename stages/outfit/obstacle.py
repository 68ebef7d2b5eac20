"""What a garment stays outside of, and how far its vertices are from it."""

from dataclasses import dataclass
from functools import cached_property

import igl
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A closed surface that a garment stays outside of."""

    vertices: Array
    """Vertices [m], shape [V, 3]."""
    faces: Faces
    """Triangles, counter-clockwise seen from outside, shape [F, 3]."""
    margin: float
    """Least distance of a garment's vertices [m]."""

    @cached_property
    def _search(self) -> tuple[Array, Faces, igl.AABB, igl.FastWindingNumberBVH]:
        """The surface, and what finds nearest points and winding numbers on it."""
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float64)
        faces = np.ascontiguousarray(self.faces, dtype=np.int64)
        boxes, winding = igl.AABB(), igl.FastWindingNumberBVH()
        boxes.init(vertices, faces)
        winding.init(vertices, faces, 2)
        return vertices, faces, boxes, winding

    def distance(
        self, points: Array, inside: NDArray[np.bool_] | None = None, unsure: NDArray[np.bool_] | None = None
    ) -> tuple[Array, Array]:
        """Distance of points [m], negative inside, shape [n]; direction of its fastest increase, 0 on the surface.

        The distance is exact. Its sign comes from the winding number: the nearest triangle's side, which others use,
        lies where extreme bodies fold into themselves.

        Args:
            points: Where to measure [m], shape [n, 3].
            inside: Which points are inside, where that is known, shape [n].
            unsure: Where it isn't, shape [n]; nowhere known if left out.
        """
        vertices, faces, boxes, winding = self._search
        points = np.ascontiguousarray(points, dtype=np.float64)
        within = np.zeros(len(points), dtype=bool) if inside is None else inside.copy()
        tested = slice(None) if unsure is None else np.flatnonzero(unsure)
        within[tested] = winding.winding_number(np.ascontiguousarray(points[tested]), 2.0) > 0.5
        squared, _, closest = boxes.squared_distance(vertices, faces, points)
        sign = np.where(within, -1.0, 1.0)
        away = (points - closest) * sign[:, None]
        return np.sqrt(squared) * sign, away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-9)


class Gauge:
    """Distances of a garment's vertices from an obstacle while they move, measured anew only where that can matter.

    A vertex that has moved by m since it was a distance d away is still d - m away at least, and on the same side while
    m < |d|.
    """

    def __init__(self, obstacle: Obstacle, points: Array) -> None:
        """Measures all vertices [m], shape [N, 3]."""
        self.obstacle = obstacle
        self.distance, self.outwards = obstacle.distance(points)
        self._at = points.copy()

    def follow(self, points: Array, reach: Array | float) -> None:
        """Takes up where the vertices are now.

        Args:
            points: The vertices [m], shape [N, 3].
            reach: `distance` and `outwards` will be exact wherever they are nearer than this [m], shape [N].
        """
        moved = self._moved(points)
        near = np.flatnonzero((moved > 0) & (self.distance - moved < reach))
        if len(near) == 0:
            return
        before = self.distance[near]
        self.distance[near], self.outwards[near] = self.obstacle.distance(
            points[near], before < 0, moved[near] >= np.abs(before)
        )
        self._at[near] = points[near]

    def lacking(self, extra: Array | float = 0.0) -> Array:
        """What vertices lack of the margin and `extra` as they were last measured [m], shape [N]; <= 0 is nothing."""
        return self.obstacle.margin + extra - self.distance

    def may_meet(self, points: Array, faces: Faces) -> NDArray[np.bool_]:
        """Which faces can't be told by their vertices alone to stay off the surface, shape [F].

        No point of a triangle is further from its nearest corner than its longest edge over the square root of 3.
        """
        away = np.abs(self.distance) - self._moved(points)
        corners = points[faces]
        longest2 = ((corners - np.roll(corners, 1, axis=1)) ** 2).sum(axis=2).max(axis=1)
        least = away[faces].min(axis=1)
        near: NDArray[np.bool_] = least * np.abs(least) * 3.0 <= longest2
        return near

    def _moved(self, points: Array) -> Array:
        length: Array = np.sqrt(((points - self._at) ** 2).sum(axis=1))
        return length
