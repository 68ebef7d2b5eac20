"""Dressed people as pictures: who is seen from where, and how a sequence becomes frames."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from stages.report.camera import Camera
from stages.report.palette import SKIN, SKIN_GLOSS, Colour
from stages.report.render import Mesh, Studio
from stages.report.sheet import contact_sheet

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

# The camera follows the root's way on the floor, without its sway at every step [frames].
FOLLOW_SIGMA = 8.0
MARGIN = 1.12


@dataclass(frozen=True, kw_only=True)
class Surface:
    """A moving surface: `vertices` [T, N, 3] in the world [m], `faces` [F, 3]; skin, or the cloth of a garment."""

    vertices: Array
    faces: NDArray[np.int32]
    cloth: Colour | None = None

    def at(self, frame: int) -> Mesh:
        """The surface in one frame."""
        if self.cloth is not None:
            return Mesh(vertices=self.vertices[frame], faces=self.faces, colour=self.cloth)
        return Mesh(vertices=self.vertices[frame], faces=self.faces, colour=SKIN, gloss=SKIN_GLOSS)


def heading(root_rotations: ArrayLike) -> float:
    """Mean direction that a person faces, seen from above [rad], counter-clockwise from +x.

    Args:
        root_rotations: Axis-angle rotations of the root joint [rad], shape [T, 3]; the unposed body faces +z.
    """
    facing = Rotation.from_rotvec(root_rotations).apply([0.0, 0.0, 1.0])[:, :2].mean(axis=0)
    return float(np.arctan2(facing[1], facing[0]))


@dataclass(frozen=True, kw_only=True)
class Shot:
    """How a sequence is filmed.

    Attributes:
        targets: Middle of the picture in each frame [m], shape [T, 3].
        span: What the picture's height covers [m].
        azimuths: Directions to the cameras of the views, seen from above [rad].
    """

    targets: Array
    span: float
    azimuths: tuple[float, ...]

    def cameras(self, frame: int) -> list[Camera]:
        """The cameras of all views in one frame."""
        return [Camera.around(self.targets[frame], azimuth, height=self.span) for azimuth in self.azimuths]


def frame_shot(surfaces: Sequence[Surface], trans: ArrayLike, facing: float, width: int, height: int) -> Shot:
    """Front and side views that keep a whole person in the picture over a whole sequence.

    In the side view the camera stands on the person's right, so that walking ahead goes to the right.

    Args:
        surfaces: The body and what it wears.
        trans: Root joint in each frame [m], shape [T, 3].
        facing: Direction that the person faces [rad].
        width: Width of a view [px].
        height: Height of a view [px].
    """
    way = gaussian_filter1d(np.asarray(trans, dtype=float)[:, :2], FOLLOW_SIGMA, axis=0, mode="nearest")
    top = max(float(s.vertices[..., 2].max()) for s in surfaces)
    reach = max(float(np.abs(s.vertices[..., :2] - way[:, None]).max()) for s in surfaces)
    span = MARGIN * max(top, 2.0 * reach * height / width)
    middle = np.full((len(way), 1), 0.5 * top)
    return Shot(targets=np.hstack([way, middle]), span=span, azimuths=(facing, facing - 0.5 * np.pi))


def frame_pictures(surfaces: Sequence[Surface], frame: int, shot: Shot, width: int, height: int) -> Picture:
    """All views of one frame side by side, shape [height, views * width, 3]."""
    studio = Studio([surface.at(frame) for surface in surfaces])
    views = [studio.picture(camera, width, height) for camera in shot.cameras(frame)]
    return contact_sheet(views, len(views))


def film(surfaces: Sequence[Surface], shot: Shot, width: int, height: int) -> Iterator[Picture]:
    """The frames of a sequence in order, drawn on all cores; the pictures don't depend on how many there are."""
    frames = range(len(shot.targets))
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        yield from pool.map(lambda frame: frame_pictures(surfaces, frame, shot, width, height), frames)


def portrait(surfaces: Sequence[Surface], azimuths: Sequence[float], width: int, height: int, span: float) -> Picture:
    """Views of one still frame, side by side, standing on its own lowest point.

    Args:
        surfaces: The body and what it wears; their first frame is shown.
        azimuths: Directions to the cameras [rad].
        width: Width of a view [px].
        height: Height of a view [px].
        span: What a view's height covers [m].
    """
    points = surfaces[0].vertices[0]
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high) + [0.0, 0.0, 0.03 * span]
    studio = Studio([surface.at(0) for surface in surfaces], floor=float(low[2]))
    views = [studio.picture(Camera.around(middle, a, height=span), width, height) for a in azimuths]
    return contact_sheet(views, len(views))
