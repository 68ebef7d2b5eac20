"""A symmetric voxel field whose zero level set is a garment: hulls of body parts, joined and smoothed.

A woven garment bridges what is hollow and hangs straight from what stands out: the small of the back, the chest between
the breasts, the back of the knee. That is what the convex hull of a body part does, so a garment is a union of such
hulls, each moved outwards by the wearer's ease.
"""

from collections.abc import Callable
from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial import ConvexHull

Array = NDArray[np.float64]
Ease = Callable[[Array], Array]

BLOCK = 100_000
"""Grid points evaluated at a time: bounds the table of distances to the planes of a hull to some hundred MB."""


@dataclass(frozen=True, eq=False)
class Grid:
    """A regular grid over x >= 0; the other half is its mirror image."""

    origin: Array
    """Position of the first node [m], shape [3]; x is 0."""
    shape: tuple[int, int, int]
    """Nodes along x, y, z."""
    spacing: float
    """Distance between nodes [m]."""

    @classmethod
    def around(cls, points: Array, margin: float, spacing: float) -> "Grid":
        """A grid over the points' bounding box with a margin [m] on every side."""
        low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
        low[0] = 0.0
        shape = np.ceil((high - low) / spacing).astype(int) + 1
        return cls(low, (int(shape[0]), int(shape[1]), int(shape[2])), spacing)

    def nodes(self) -> Array:
        """Positions of all nodes [m], shape [X Y Z, 3]."""
        axes = [o + self.spacing * np.arange(n) for o, n in zip(self.origin, self.shape)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def hull_field(nodes: Array, points: Array, ease: Ease) -> Array:
    """How far each node is outside the eased hull of some points [m]: positive outside, exact inside the hull.

    Args:
        nodes: Where to evaluate [m], shape [n, 3].
        points: Points to wrap [m], shape [m, 3].
        ease: Distance [m] that the surface keeps from the hull, as a function of position.

    Returns:
        The field, shape [n].
    """
    planes = np.unique(np.round(ConvexHull(points).equations, 9), axis=0)
    out = np.empty(len(nodes))
    for start in range(0, len(nodes), BLOCK):
        block = nodes[start : start + BLOCK]
        out[start : start + BLOCK] = (block @ planes[:, :3].T + planes[:, 3]).max(axis=1) - ease(block)
    return out


@dataclass(frozen=True, eq=False)
class Volume:
    """A field on a grid, smoothed, and mirrored over x = 0."""

    grid: Grid
    values: Array
    """Field at the nodes of the mirrored grid [m], shape [2 X - 1, Y, Z]."""

    @classmethod
    def smoothed(cls, grid: Grid, field: Array, width: float) -> "Volume":
        """Mirrors the field [X Y Z] and blurs it with a Gaussian of standard deviation `width` [m]."""
        half = field.reshape(grid.shape)
        whole = np.concatenate([half[:0:-1], half], axis=0)
        return cls(grid, gaussian_filter(whole, width / grid.spacing, mode="nearest"))

    @property
    def origin(self) -> Array:
        """Position of the first node of the mirrored grid [m]."""
        return self.grid.origin - np.array([(self.grid.shape[0] - 1) * self.grid.spacing, 0.0, 0.0])

    def surface(self) -> tuple[Array, NDArray[np.int64]]:
        """The zero level set as triangles: vertices [m], shape [n, 3], and faces, all oriented alike, [f, 3]."""
        nx, ny, nz = self.values.shape
        axes = [o + self.grid.spacing * np.arange(n) for o, n in zip(self.origin, (nx, ny, nz))]
        # igl lets x run fastest.
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).transpose(2, 1, 0, 3).reshape(-1, 3)
        values = np.ascontiguousarray(self.values.transpose(2, 1, 0)).reshape(-1)
        vertices, faces, _ = igl.marching_cubes(values, np.ascontiguousarray(nodes), nx, ny, nz, 0.0)
        return vertices, faces

    def project(self, points: Array, iterations: int = 3) -> Array:
        """Moves points [m], shape [n, 3], along the gradient onto the zero level set (Newton's method)."""
        points = points.copy()
        gradient = np.gradient(self.values, self.grid.spacing)
        for _ in range(iterations):
            where = ((points - self.origin) / self.grid.spacing).T
            value = map_coordinates(self.values, where, order=1)
            slope = np.stack([map_coordinates(g, where, order=1) for g in gradient], axis=1)
            points -= (value / np.maximum((slope**2).sum(axis=1), 1e-3))[:, None] * slope
        return points
