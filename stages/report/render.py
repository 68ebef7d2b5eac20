"""Pictures of shaded meshes on a machine without GPU, display or OpenGL: rays by Embree, shading in NumPy.

A scene is lit once (`Studio`) and can then be seen from several cameras (`Studio.picture`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter

from stages.report.camera import Camera
from stages.report.light import bake_dome, key_directions, key_light

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

# Four samples a pixel on a turned grid, which smooths near-vertical and near-level edges alike [px].
SAMPLES = np.array([[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]])
BACKDROP_TOP, BACKDROP_BOTTOM = (0.93, 0.94, 0.95), (0.80, 0.81, 0.83)
DOME_SHARE, KEY_SHARE = 0.52, 0.78
FLOOR_CELL = 0.06
# Floor shadows of the dome are wide; smoothing over this many cells hides that they are sums over few directions.
FLOOR_BLUR = 1.5
FLOOR_REACH = 1.6
LINE_SPACING, LINE_WIDTH, LINE_DEPTH = 0.5, 0.008, 0.10


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A surface to show; both its sides are drawn.

    Attributes:
        vertices: Positions in the world, z up [m], shape [V, 3].
        faces: Triangles, counter-clockwise seen from outside, shape [F, 3].
        colour: Red, green and blue as on the screen (sRGB), each 0 to 1.
        smooth: Shade with normals interpolated from the vertices; False shows every triangle flat.
        gloss: Strength of a soft highlight, 0 for cloth, about 0.1 for skin.
    """

    vertices: ArrayLike
    faces: ArrayLike
    colour: tuple[float, float, float] = (0.72, 0.72, 0.74)
    smooth: bool = True
    gloss: float = 0.0


def linear(colour: ArrayLike) -> Array:
    """Screen colours (sRGB) as proportional to light (IEC 61966-2-1)."""
    c = np.asarray(colour, dtype=float)
    return np.where(c <= 0.04045, c / 12.92, ((np.maximum(c, 0.04045) + 0.055) / 1.055) ** 2.4)


def screen(light: Array) -> Picture:
    """Colours proportional to light as 8-bit screen colours (IEC 61966-2-1)."""
    c = np.clip(light, 0.0, 1.0)
    curve = np.where(c <= 0.0031308, 12.92 * c, 1.055 * np.maximum(c, 0.0031308) ** (1.0 / 2.4) - 0.055)
    return np.rint(255.0 * curve).astype(np.uint8)


def face_vectors(vertices: Array, faces: NDArray[np.int32]) -> Array:
    """Normals of the triangles, as long as twice their area [m^2], shape [F, 3]."""
    a, b, c = vertices[faces[:, 0]], vertices[faces[:, 1]], vertices[faces[:, 2]]
    return np.cross(b - a, c - a)


def unit(vectors: Array) -> Array:
    """`vectors` scaled to length 1, shape [N, 3]; zero stays zero."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.maximum(length, 1e-20)


class Studio:
    """Meshes over a floor, lit by a dome and a key lamp that stands to the left of whichever camera looks.

    Args:
        meshes: What to show.
        floor: Height of the floor [m]; None shows no floor.
    """

    def __init__(self, meshes: Sequence[Mesh], floor: float | None = 0.0) -> None:
        counts = np.cumsum([0] + [len(np.asarray(m.vertices)) for m in meshes])
        self.floor = floor
        self.vertices = np.concatenate([np.asarray(m.vertices, dtype=float) for m in meshes])
        self.faces = np.concatenate([np.asarray(m.faces) + n for m, n in zip(meshes, counts)]).astype(np.int32)
        owner = np.repeat(np.arange(len(meshes)), [len(np.asarray(m.faces)) for m in meshes])
        self.colour = np.stack([linear(m.colour) for m in meshes])[owner]
        self.gloss = np.array([m.gloss for m in meshes])[owner]
        self.smooth = np.array([m.smooth for m in meshes])[owner]

        vectors = face_vectors(self.vertices, self.faces)
        self.face_normals = unit(vectors)
        sums = np.stack(
            [np.bincount(self.faces.ravel(), np.repeat(vectors[:, k], 3), len(self.vertices)) for k in range(3)], 1
        )
        self.normals = unit(sums)

        self.scene = EmbreeScene()
        TriangleMesh(self.scene, self.vertices.astype(np.float32), self.faces)
        self.dome_outside = bake_dome(self.vertices, self.normals, self._occluded)
        # Only what has a border can show its inside.
        self.dome_inside = np.zeros(len(self.vertices))
        for mesh, start, stop in zip(meshes, counts[:-1], counts[1:]):
            if _has_border(np.asarray(mesh.faces)):
                part = slice(start, stop)
                self.dome_inside[part] = bake_dome(self.vertices[part], -self.normals[part], self._occluded)
        if floor is not None:
            self._bake_floor(floor)

    def _occluded(self, origins: Array, directions: Array) -> NDArray[np.bool_]:
        hit = self.scene.run(
            np.ascontiguousarray(origins, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
            query="OCCLUDED",
        )
        return np.asarray(hit) >= 0

    def _bake_floor(self, floor: float) -> None:
        """The dome's light on a grid of floor points around the meshes."""
        low, high = self.vertices[:, :2].min(0) - FLOOR_REACH, self.vertices[:, :2].max(0) + FLOOR_REACH
        shape = np.ceil((high - low) / FLOOR_CELL).astype(int) + 1
        x, y = (low[k] + FLOOR_CELL * np.arange(shape[k]) for k in range(2))
        points = np.stack([*np.meshgrid(x, y, indexing="ij"), np.full(shape, floor)], axis=-1).reshape(-1, 3)
        up = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
        self.floor_low = low
        self.floor_dome = gaussian_filter(bake_dome(points, up, self._occluded).reshape(shape), FLOOR_BLUR)

    def picture(self, camera: Camera, width: int, height: int) -> Picture:
        """What `camera` sees, shape [height, width, 3].

        Args:
            camera: The camera.
            width: Width of the picture [px].
            height: Height of the picture [px].
        """
        away = np.subtract(camera.position, camera.target)
        lamp = key_directions(float(np.arctan2(away[1], away[0])))
        light = self._background(camera, lamp, width, height)

        corners = camera.project(self.vertices, width, height)
        low = np.clip(np.floor(corners.min(0)).astype(int) - 1, 0, (width, height))
        high = np.clip(np.ceil(corners.max(0)).astype(int) + 1, 0, (width, height))
        if np.all(high > low):
            rows, columns = np.mgrid[low[1] : high[1], low[0] : high[0]]
            pixels = np.stack([columns.ravel(), rows.ravel()], axis=1)
            colour = np.zeros((len(pixels), 3))
            covered = np.zeros(len(pixels))
            for k, sample in enumerate(SAMPLES):
                directions = camera.directions(pixels + sample, width, height)
                seen, shaded = self._shade(np.asarray(camera.position), directions, lamp[k :: len(SAMPLES)])
                colour[seen] += shaded / len(SAMPLES)
                covered[seen] += 1.0 / len(SAMPLES)
            row, column = pixels[:, 1], pixels[:, 0]
            light[row, column] = colour + (1.0 - covered)[:, None] * light[row, column]
        return screen(light)

    def _shade(self, origin: Array, directions: Array, lamp: Array) -> tuple[NDArray[np.int64], Array]:
        """Which rays from the camera meet a mesh, shape [S], and the light that comes back along them, [S, 3]."""
        origins = np.broadcast_to(origin.astype(np.float32), directions.shape)
        hits = self.scene.run(np.ascontiguousarray(origins), directions.astype(np.float32), output=1)
        seen = np.flatnonzero(hits["primID"] >= 0)
        face = hits["primID"][seen]
        u, v = hits["u"][seen].astype(float), hits["v"][seen].astype(float)
        weights = np.stack([1.0 - u - v, u, v], axis=1)
        corner = self.faces[face]
        points = np.einsum("nk,nkc->nc", weights, self.vertices[corner])
        view = -directions[seen]

        flat = self.face_normals[face]
        side = np.where(np.einsum("nc,nc->n", flat, view) >= 0.0, 1.0, -1.0)
        flat = flat * side[:, None]
        smooth = unit(np.einsum("nk,nkc->nc", weights, self.normals[corner])) * side[:, None]
        normals = np.where(self.smooth[face][:, None], smooth, flat)
        dome = np.where(
            side > 0.0, *(np.einsum("nk,nk->n", weights, d[corner]) for d in (self.dome_outside, self.dome_inside))
        )
        key = key_light(points, normals, flat, lamp, self._occluded)

        colour = self.colour[face]
        light = colour * (DOME_SHARE * dome + KEY_SHARE * key)[:, None]
        half = unit(view + lamp.mean(axis=0))
        shine = self.gloss[face] * np.maximum(np.einsum("nc,nc->n", normals, half), 0.0) ** 24 * (key > 0.0)
        return seen, light + shine[:, None]

    def _in_shadow_box(self, points: Array, lamp: Array) -> NDArray[np.int64]:
        """Which floor points lie in the rectangle along the lamp's direction that holds the meshes' whole shadow."""
        along = lamp[:, :2].mean(axis=0)
        frame = np.stack([along, [-along[1], along[0]]]) / np.linalg.norm(along)
        height = self.vertices[:, 2] - (self.floor or 0.0)
        thrown = np.concatenate([(self.vertices[:, :2] - height[:, None] * d[:2] / d[2]) @ frame.T for d in lamp])
        here = points[:, :2] @ frame.T
        return np.flatnonzero(np.all((here >= thrown.min(0) - 0.01) & (here <= thrown.max(0) + 0.01), axis=1))

    def _background(self, camera: Camera, lamp: Array, width: int, height: int) -> Array:
        """The backdrop, with the shadows on the floor, as light, shape [height, width, 3]."""
        down = ((np.arange(height) + 0.5) / height)[:, None, None]
        top, bottom = linear(BACKDROP_TOP), linear(BACKDROP_BOTTOM)
        light = np.broadcast_to(top + (bottom - top) * down, (height, width, 3)).copy()
        if self.floor is None:
            return light
        rows, columns = np.mgrid[0:height, 0:width]
        directions = camera.directions(np.stack([columns.ravel(), rows.ravel()], 1) + 0.5, width, height)
        position = np.asarray(camera.position)
        below = np.flatnonzero(directions[:, 2] < -1e-3)
        points = position + directions[below] * ((self.floor - position[2]) / directions[below, 2])[:, None]
        cell = (points[:, :2] - self.floor_low) / FLOOR_CELL
        inside = np.all((cell >= 0.0) & (cell < np.array(self.floor_dome.shape) - 1.001), axis=1)
        below, points, cell = below[inside], points[inside], cell[inside]

        dome = _bilinear(self.floor_dome, cell)
        up = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
        key = np.ones(len(points))
        shaded = self._in_shadow_box(points, lamp)
        key[shaded] = key_light(points[shaded], up[shaded], up[shaded], lamp, self._occluded) / lamp[:, 2].mean()
        # Where the lit grid ends, its shadows must have faded to nothing.
        edge = np.minimum(cell, np.array(self.floor_dome.shape) - 1 - cell).min(axis=1) * FLOOR_CELL
        fade = np.clip(edge / (0.5 * FLOOR_REACH), 0.0, 1.0)
        shadow = (DOME_SHARE * dome + 0.55 * KEY_SHARE * key) / (DOME_SHARE + 0.55 * KEY_SHARE)
        near = np.abs(points[:, :2] / LINE_SPACING - np.rint(points[:, :2] / LINE_SPACING)) * LINE_SPACING
        # A line narrower than a pixel is drawn a pixel wide and paler.
        pixel = np.linalg.norm(points - position, axis=1) * 2.0 * np.tan(0.5 * camera.field_of_view) / height
        reach = np.stack([pixel, pixel / np.maximum(-directions[below, 2], 0.02)], axis=1)
        lines = np.clip((0.5 * LINE_WIDTH + 0.5 * reach - near) / reach, 0.0, 1.0) * np.minimum(1.0, LINE_WIDTH / reach)
        tone = (1.0 + fade * (shadow - 1.0)) * (1.0 - LINE_DEPTH * fade * lines.max(axis=1))
        flat = light.reshape(-1, 3)
        flat[below] *= tone[:, None]
        return light


def _has_border(faces: NDArray[np.int32]) -> bool:
    """Whether some edge of the mesh belongs to one triangle only."""
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64), axis=1)
    _, uses = np.unique(edges[:, 0] * (faces.max() + 1) + edges[:, 1], return_counts=True)
    return bool(np.any(uses == 1))


def _bilinear(grid: Array, cell: Array) -> Array:
    """`grid` between its nodes at fractional indices `cell`, shape [N, 2] -> [N]."""
    i, j = np.floor(cell).astype(int).T
    s, t = (cell - np.floor(cell)).T
    return (1 - s) * ((1 - t) * grid[i, j] + t * grid[i, j + 1]) + s * (
        (1 - t) * grid[i + 1, j] + t * grid[i + 1, j + 1]
    )


def render(meshes: Sequence[Mesh], camera: Camera, width: int, height: int, floor: float | None = 0.0) -> Picture:
    """One picture of `meshes`: `Studio(meshes, floor).picture(camera, width, height)`."""
    return Studio(meshes, floor).picture(camera, width, height)
