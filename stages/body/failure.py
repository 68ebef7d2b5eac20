"""The failure set: of each rejected body a picture of the worst frame and what there is to know about it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from embreex.mesh_construction import TriangleMesh  # type: ignore[import-untyped]
from embreex.rtcore_scene import EmbreeScene  # type: ignore[import-untyped]
from numpy.typing import NDArray
from PIL import Image

from stages.body.freeing import UnsolvableError

SIDE = 480
"""Width and height of each of the two views [px]."""

SKIN = np.array([219.0, 190.0, 170.0])
AT_FAULT = np.array([230.0, 60.0, 40.0])
PAPER = 245
AMBIENT = 0.35
"""Share of the light that comes from everywhere."""


def record_failure(
    output: Path, item: str, faces: NDArray[np.int32], error: UnsolvableError, about: dict[str, Any]
) -> None:
    """Writes `failures/<item>.png` and `.json` beside what would have been published at `output`.

    Args:
        output: Where the shard would be.
        item: Name of the item.
        faces: Triangles of the body, shape [F, 3].
        error: What went wrong.
        about: What else there is to know: seed, betas, motion.
    """
    folder = output.parent / "failures"
    folder.mkdir(parents=True, exist_ok=True)
    views = [picture(error.vertices, faces, error.marked, angle) for angle in (-np.pi / 2 + 0.4, np.pi / 2 + 0.9)]
    Image.fromarray(np.concatenate(views, axis=1)).save(folder / f"{item}.png")
    known = {"cause": str(error), "frame": error.frame} | about
    (folder / f"{item}.json").write_text(json.dumps(known, indent=1, sort_keys=True) + "\n")


def picture(
    vertices: NDArray[np.float32], faces: NDArray[np.int32], marked: NDArray[np.bool_], azimuth: float
) -> NDArray[np.uint8]:
    """A body seen from one side, in parallel light and projection.

    Args:
        vertices: Positions, z up [m], shape [V, 3].
        faces: Triangles, shape [F, 3].
        marked: Vertices to show in red, shape [V].
        azimuth: Direction of the camera, counter-clockwise from +x seen from above [rad].

    Returns:
        Red, green and blue, shape [SIDE, SIDE, 3].
    """
    x = vertices.astype(np.float64)
    away = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    middle, size = (x.min(axis=0) + x.max(axis=0)) / 2, 1.05 * float(np.ptp(x, axis=0).max())
    step = (np.arange(SIDE) + 0.5) / SIDE - 0.5
    origins = (
        middle + 5.0 * away + size * (step[None, :, None] * right + -step[:, None, None] * np.array([0.0, 0.0, 1.0]))
    )
    scene = EmbreeScene()
    TriangleMesh(scene, vertices.astype(np.float32), faces.astype(np.int32))
    rays = np.broadcast_to(-away, (SIDE * SIDE, 3)).astype(np.float32)
    hit = scene.run(origins.reshape(-1, 3).astype(np.float32), np.ascontiguousarray(rays))
    out = np.full((SIDE * SIDE, 3), PAPER, np.uint8)
    seen = np.flatnonzero(hit >= 0)
    corners = x[faces[hit[seen]]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    lamp = away + 0.6 * right + np.array([0.0, 0.0, 0.8])
    light = AMBIENT + (1 - AMBIENT) * np.clip(normal @ lamp / np.linalg.norm(lamp), 0.0, 1.0)
    colour = np.where(marked[faces[hit[seen]]].any(axis=1)[:, None], AT_FAULT, SKIN)
    out[seen] = (colour * light[:, None]).astype(np.uint8)
    return out.reshape(SIDE, SIDE, 3)
