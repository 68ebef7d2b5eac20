"""Pictures of shaded meshes on a machine without GPU, display or OpenGL: rays by Embree, shading in NumPy.

A scene (`Studio`) can be seen from several cameras (`Studio.picture`), which share the light that was computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh  # type: ignore[import-untyped]
from embreex.rtcore_scene import EmbreeScene  # type: ignore[import-untyped]
from numpy.typing import ArrayLike, NDArray

from model.mesh.geometry import face_normals, vertex_normals
from stages.report.backdrop import Floor, backdrop
from stages.report.camera import Camera
from stages.report.light import DOME_SHARE, KEY_SHARE, bake_dome, key_directions, key_light

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Picture = NDArray[np.uint8]

# Four samples of a pixel on an outline, on a turned grid: it smooths near-vertical and near-level edges alike [px].
SAMPLES = np.array([[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]])
# Neighbouring pixels further apart than this along the view have an outline between them [m].
OUTLINE_STEP = 0.02


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A surface to show; both its sides are drawn.

    Attributes:
        vertices: Positions in the world, z up [m], shape [V, 3].
        faces: Triangles, counter-clockwise seen from outside, shape [F, 3].
        colour: Red, green and blue as on the screen (sRGB), each 0 to 1.
        smooth: Shade with normals interpolated from the vertices; False shows every triangle flat.
        gloss: Strength of a soft highlight: 0 for cloth, about 0.05 for skin.
    """

    vertices: ArrayLike
    faces: ArrayLike
    colour: tuple[float, float, float] = (0.72, 0.72, 0.74)
    smooth: bool = True
    gloss: float = 0.0


class Studio:
    """Meshes over a floor, lit by a dome and a key lamp that stands to the left of whichever camera looks.

    Args:
        meshes: What to show.
        floor: Height of the floor [m]; None shows no floor.
    """

    def __init__(self, meshes: Sequence[Mesh], floor: float | None = 0.0) -> None:
        counts = np.cumsum([0] + [len(np.asarray(m.vertices)) for m in meshes])
        self.vertices = np.concatenate([np.asarray(m.vertices, dtype=float) for m in meshes])
        self.faces = np.concatenate([np.asarray(m.faces) + n for m, n in zip(meshes, counts)]).astype(np.int32)
        self.owner = np.repeat(np.arange(len(meshes)), [len(np.asarray(m.faces)) for m in meshes])
        self.colour = np.stack([linear(m.colour) for m in meshes])
        self.gloss = np.array([m.gloss for m in meshes])
        self.smooth = np.array([m.smooth for m in meshes])

        self.face_normals = face_normals(self.vertices, self.faces)
        self.normals = vertex_normals(self.vertices, self.faces)

        self.scene = EmbreeScene()
        TriangleMesh(self.scene, self.vertices.astype(np.float32), self.faces)
        # Light of the dome at each vertex; NaN where no picture has needed it yet.
        self.dome = np.full(len(self.vertices), np.nan)
        self.floor = None if floor is None else Floor(floor, self.vertices, self._occluded)

    def _occluded(self, origins: Array, directions: Array) -> NDArray[np.bool_]:
        hit = self.scene.run(
            np.ascontiguousarray(origins, dtype=np.float32),
            np.ascontiguousarray(directions, dtype=np.float32),
            query="OCCLUDED",
        )
        return np.asarray(hit) >= 0

    def picture(self, camera: Camera, width: int, height: int) -> Picture:
        """What `camera` sees, shape [height, width, 3].

        Args:
            camera: The camera.
            width: Width of the picture [px].
            height: Height of the picture [px].
        """
        away = np.subtract(camera.position, camera.target)
        lamp = key_directions(float(np.arctan2(away[1], away[0])))
        light = backdrop(width, height)
        if self.floor is not None:
            self.floor.darken(light, camera, lamp)

        at = camera.project(self.vertices, width, height)
        low = np.clip(np.floor(at.min(0)).astype(int) - 1, 0, (width, height))
        high = np.clip(np.ceil(at.max(0)).astype(int) + 1, 0, (width, height))
        if np.any(high <= low):
            return screen(light)
        rows, columns = np.mgrid[low[1] : high[1], low[0] : high[0]]
        pixels = np.stack([columns, rows], axis=-1)
        window = light[low[1] : high[1], low[0] : high[0]]

        centre = self._look(camera, camera.directions(pixels.reshape(-1, 2) + 0.5, width, height))
        outline = self._outline(centre, rows.shape)
        inner = np.flatnonzero(centre.hit & ~outline)
        flat = window.reshape(-1, 3).copy()
        flat[inner] = self._shade(centre, inner, lamp)
        edge = np.flatnonzero(outline)
        behind = flat[edge]
        flat[edge] = 0.0
        for k, sample in enumerate(SAMPLES):
            view = self._look(camera, camera.directions(pixels.reshape(-1, 2)[edge] + sample, width, height))
            seen = np.flatnonzero(view.hit)
            colour = behind.copy()
            colour[seen] = self._shade(view, seen, lamp[k :: len(SAMPLES)])
            flat[edge] += colour / len(SAMPLES)
        window[:] = flat.reshape(window.shape)
        return screen(light)

    def _look(self, camera: Camera, directions: NDArray[np.float32]) -> View:
        """What rays from the camera meet first."""
        origins = np.broadcast_to(np.asarray(camera.position, dtype=np.float32), directions.shape)
        hits = self.scene.run(np.ascontiguousarray(origins), directions, output=1)
        return View(directions, hits["primID"], hits["tfar"], hits["u"], hits["v"])

    def _bake(self, corners: NDArray[np.int32]) -> None:
        """Lights those of the vertices `corners` that no picture has needed before: most are hidden from any camera."""
        wanted = np.zeros(len(self.vertices), dtype=bool)
        wanted[corners] = True
        dark = np.flatnonzero(wanted & np.isnan(self.dome))
        self.dome[dark] = bake_dome(self.vertices[dark], self.normals[dark], self._occluded)

    def _outline(self, view: View, shape: tuple[int, ...]) -> NDArray[np.bool_]:
        """Which pixels of a window of `shape` touch one that shows another mesh, or the same far away, shape [N]."""
        owner = np.where(view.hit, self.owner[view.face], -1).reshape(shape)
        depth = np.where(view.hit, view.distance, 0.0).reshape(shape)
        outline = np.zeros(shape, dtype=bool)
        for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
            here = slice(0, shape[0] - dy), slice(max(-dx, 0), shape[1] - max(dx, 0))
            there = slice(dy, shape[0]), slice(max(dx, 0), shape[1] + min(dx, 0))
            step = (owner[here] != owner[there]) | (np.abs(depth[here] - depth[there]) > OUTLINE_STEP)
            outline[here] |= step
            outline[there] |= step
        return outline.ravel()

    def _shade(self, view: View, rays: Index, lamp: Array) -> Array:
        """Light that comes back along `rays` of `view`, each of which meets a mesh, shape [N, 3]."""
        face = view.face[rays]
        u, v = view.u[rays].astype(float), view.v[rays].astype(float)
        weights = np.stack([1.0 - u - v, u, v], axis=1)
        corner, owner = self.faces[face], self.owner[face]
        points = np.einsum("nk,nkc->nc", weights, self.vertices[corner])
        back = -view.directions[rays].astype(np.float64)

        flat = self.face_normals[face]
        side = np.where(np.einsum("nc,nc->n", flat, back) >= 0.0, 1.0, -1.0)
        flat = flat * side[:, None]
        around = self.normals[corner] * side[:, None, None]
        smooth = unit(np.einsum("nk,nkc->nc", weights, around))
        normals = np.where(self.smooth[owner][:, None], smooth, flat)
        self._bake(corner)
        dome = np.einsum("nk,nk->n", weights, self.dome[corner])
        # Little is seen of insides: their light is not baked but gathered where it is needed.
        inside = np.flatnonzero(side < 0.0)
        dome[inside] = bake_dome(points[inside], normals[inside], self._occluded)
        key = key_light(lifted(points, weights, self.vertices[corner], around), normals, flat, lamp, self._occluded)

        half = unit(back + lamp.mean(axis=0))
        shine = self.gloss[owner] * np.maximum(np.einsum("nc,nc->n", normals, half), 0.0) ** 24 * (key > 0.0)
        return self.colour[owner] * (DOME_SHARE * dome + KEY_SHARE * key)[:, None] + shine[:, None]


@dataclass(frozen=True)
class View:
    """What rays meet first: `directions` [N, 3]; `face` (-1 for none), `distance` [m] and barycentric `u`, `v`, [N]."""

    directions: NDArray[np.float32]
    face: NDArray[np.int32]
    distance: NDArray[np.float32]
    u: NDArray[np.float32]
    v: NDArray[np.float32]

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Which rays meet anything, shape [N]."""
        return self.face >= 0


def render(meshes: Sequence[Mesh], camera: Camera, width: int, height: int, floor: float | None = 0.0) -> Picture:
    """One picture of `meshes`: `Studio(meshes, floor).picture(camera, width, height)`."""
    return Studio(meshes, floor).picture(camera, width, height)


def lifted(points: Array, weights: Array, corners: Array, normals: Array) -> Array:
    """Points of flat triangles, raised onto the curved surface that the vertices' normals stand for, shape [N, 3].

    Rays to the lamp that start there don't meet the neighbouring triangles where the light grazes, which would show
    every triangle's edges (Hanika, Hacking the Shadow Terminator, Ray Tracing Gems II, 2021).

    Args:
        points: Points of triangles [m], shape [N, 3].
        weights: Their barycentric coordinates, shape [N, 3].
        corners: The triangles' vertices [m], shape [N, 3, 3].
        normals: Unit normals at these, towards the lit side, shape [N, 3, 3].
    """
    below = np.minimum(np.einsum("nkc,nkc->nk", points[:, None] - corners, normals), 0.0)
    return points - np.einsum("nk,nk,nkc->nc", weights, below, normals)


def linear(colour: ArrayLike) -> Array:
    """Screen colours (sRGB) as proportional to light (IEC 61966-2-1)."""
    c = np.asarray(colour, dtype=float)
    return np.where(c <= 0.04045, c / 12.92, ((np.maximum(c, 0.04045) + 0.055) / 1.055) ** 2.4)


def screen(light: Array) -> Picture:
    """Colours proportional to light as 8-bit screen colours (IEC 61966-2-1)."""
    c = np.clip(light, 0.0, 1.0)
    curve = np.where(c <= 0.0031308, 12.92 * c, 1.055 * np.maximum(c, 0.0031308) ** (1.0 / 2.4) - 0.055)
    return np.rint(255.0 * curve).astype(np.uint8)


def unit(vectors: Array) -> Array:
    """`vectors` scaled to length 1, shape [N, 3]; zero stays zero."""
    length = np.sqrt(np.einsum("nc,nc->n", vectors, vectors))
    return vectors / np.maximum(length, 1e-20)[:, None]
