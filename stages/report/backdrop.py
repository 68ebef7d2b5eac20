"""What stands behind the meshes: a bright backdrop, and a floor that shows their shadows and how fast it passes by."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter

from stages.report.camera import Camera
from stages.report.light import DOME_SHARE, KEY_SHARE, Occluded, bake_dome, key_light

Array = NDArray[np.float64]

# Light, not screen colours, at the top and at the bottom of the picture.
TOP, BOTTOM = np.array([0.85, 0.87, 0.90]), np.array([0.60, 0.62, 0.65])
CELL = 0.06  # [m]
REACH = 1.6  # how far the floor goes beyond the meshes [m]
# Shadows of the dome are wide; smoothing over this many cells hides that they are sums over few directions.
BLUR = 1.5
# Smoothing of the lamp's shadow [traced pixels].
SHADOW_BLUR = 1.6
LINE_SPACING, LINE_WIDTH, LINE_DEPTH = 0.5, 0.008, 0.10  # [m], [m], share of the light taken
# The floor takes less of the lamp than a surface that faces it, or its shadow would be the darkest thing in sight.
KEY_ON_FLOOR = 0.55


def backdrop(width: int, height: int) -> Array:
    """The backdrop alone, as light, shape [height, width, 3]."""
    down = ((np.arange(height) + 0.5) / height)[:, None, None]
    return np.broadcast_to(TOP + (BOTTOM - TOP) * down, (height, width, 3)).copy()


class Floor:
    """A level floor under a scene, with the dome's shadows on it.

    Args:
        height: Height of the floor [m].
        vertices: The scene's vertices [m], shape [V, 3].
        occluded: Whether rays (origins, directions) hit the scene.
    """

    def __init__(self, height: float, vertices: Array, occluded: Occluded) -> None:
        self.height = height
        self.vertices = vertices
        self.occluded = occluded
        self.low = vertices[:, :2].min(0) - REACH
        shape = np.ceil((vertices[:, :2].max(0) + REACH - self.low) / CELL).astype(int) + 1
        x, y = (self.low[k] + CELL * np.arange(shape[k]) for k in range(2))
        points = np.stack([*np.meshgrid(x, y, indexing="ij"), np.full(shape, height)], axis=-1).reshape(-1, 3)
        up = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
        self.dome = gaussian_filter(bake_dome(points, up, occluded).reshape(shape), BLUR)

    def darken(self, light: Array, camera: Camera, lamp: Array) -> None:
        """Multiplies the picture `light`, shape [height, width, 3], by the floor's shadows and lines.

        Args:
            light: Picture as light; changed.
            camera: The camera.
            lamp: Directions to parts of the key lamp, shape [D, 3].
        """
        height, width, _ = light.shape
        position = np.asarray(camera.position)
        # The camera doesn't roll: a whole row looks up or down.
        middle = np.stack([np.full(height, 0.5 * width), np.arange(height) + 0.5], axis=1)
        first = int(np.count_nonzero(camera.directions(middle, width, height)[:, 2] > -1e-2))
        if first == height or self.height >= position[2]:
            return
        rows, columns = np.mgrid[first:height, 0:width]
        directions = camera.directions(np.stack([columns.ravel(), rows.ravel()], axis=1) + 0.5, width, height)
        distance = (self.height - position[2]) / directions[:, 2]
        points = position[:2] + directions[:, :2] * distance[:, None]

        cell = (points - self.low) / CELL
        last = np.array(self.dome.shape) - 1
        dome = bilinear(self.dome, cell).reshape(rows.shape)
        key = self._lamp_shadow(points.reshape(*rows.shape, 2), lamp)
        key_share = KEY_ON_FLOOR * KEY_SHARE
        shadow = (DOME_SHARE * dome + key_share * key) / (DOME_SHARE + key_share)
        # Where the lit grid ends, its shadows must have faded to nothing.
        inside = np.minimum(np.minimum(cell[:, 0], last[0] - cell[:, 0]), np.minimum(cell[:, 1], last[1] - cell[:, 1]))
        fade = np.clip(inside * (CELL / (0.5 * REACH)), 0.0, 1.0).reshape(rows.shape)

        # A line narrower than a pixel is drawn a pixel wide and paler.
        pixel = distance * (2.0 * np.tan(0.5 * camera.field_of_view) / height)
        reach = (pixel / -directions[:, 2])[:, None]
        near = np.abs(points / LINE_SPACING - np.rint(points / LINE_SPACING)) * LINE_SPACING
        cover = np.clip((0.5 * LINE_WIDTH + 0.5 * reach - near) / reach, 0.0, 1.0) * np.minimum(1.0, LINE_WIDTH / reach)
        lines = np.maximum(cover[:, 0], cover[:, 1]).reshape(rows.shape)
        light[first:] *= ((1.0 + fade * (shadow - 1.0)) * (1.0 - LINE_DEPTH * fade * lines))[:, :, None]

    def _lamp_shadow(self, points: Array, lamp: Array) -> Array:
        """The lamp's light at floor points seen in neighbouring pixels, [R, C, 2] -> [R, C]; 1 where it is open.

        The shadow's border is wide, so it is traced at every other pixel of every other row and smoothed between.
        """
        coarse = points[::2, ::2]
        flat = coarse.reshape(-1, 2)
        shaded = self._in_shadow_box(flat, lamp)
        at = np.concatenate([flat[shaded], np.full((len(shaded), 1), self.height)], axis=1)
        up = np.broadcast_to([0.0, 0.0, 1.0], at.shape)
        light = np.ones(len(flat))
        light[shaded] = key_light(at, up, up, lamp, self.occluded) / lamp[:, 2].mean()
        smooth = gaussian_filter(light.reshape(coarse.shape[:2]), SHADOW_BLUR, mode="nearest")
        cell = np.indices(points.shape[:2]).reshape(2, -1).T / 2
        return bilinear(smooth, cell).reshape(points.shape[:2])

    def _in_shadow_box(self, points: Array, lamp: Array) -> NDArray[np.int64]:
        """Which floor points lie in the rectangle along the lamp's direction that holds the scene's whole shadow."""
        along = lamp[:, :2].mean(axis=0)
        frame = np.stack([along, [-along[1], along[0]]]).T / np.linalg.norm(along)
        rise = (self.vertices[:, 2] - self.height)[:, None]
        thrown = np.concatenate([(self.vertices[:, :2] - rise * (d[:2] / d[2])) @ frame for d in lamp])
        here = points @ frame
        return np.flatnonzero(np.all((here >= thrown.min(0) - 0.01) & (here <= thrown.max(0) + 0.01), axis=1))


def bilinear(grid: Array, cell: ArrayLike) -> Array:
    """Values of `grid`, shape [I, J], between its nodes at fractional indices `cell`, shape [N, 2] -> [N].

    Beyond the grid, its border goes on.
    """
    at = np.clip(np.asarray(cell, dtype=float), 0.0, np.array(grid.shape) - 1.0)
    i, j = np.minimum(np.floor(at).astype(int), np.array(grid.shape) - 2).T
    s, t = at[:, 0] - i, at[:, 1] - j
    near, far = (1 - t) * grid[i, j] + t * grid[i, j + 1], (1 - t) * grid[i + 1, j] + t * grid[i + 1, j + 1]
    return (1 - s) * near + s * far
