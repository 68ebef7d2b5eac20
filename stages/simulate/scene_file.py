"""Scenes in a neutral file format, shared with other solvers: one cloth, a moving body, pinned vertices."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stages.spec import DataError


@dataclass(frozen=True, kw_only=True)
class SceneFile:
    """What an .npz scene holds: z up, metres, frame 0 = rest = start.

    Attributes:
        fps: Frames a second; frames: Frames after frame 0, one less than the number `frames` in the file.
        cloth_v [N, 3], cloth_f [F, 3], body_v [T, V, 3] (T = 1: it doesn't move, 0: there is none), body_f.
        pins [K]: Vertices that follow pin_pos [frames + 1, K, 3].
    """

    fps: float
    frames: int
    cloth_v: np.ndarray
    cloth_f: np.ndarray
    body_v: np.ndarray
    body_f: np.ndarray
    pins: np.ndarray
    pin_pos: np.ndarray


def read_scene(path: Path) -> SceneFile:
    """Read a scene.

    Raises:
        DataError: If the file can't be read, or an array is missing.
    """
    try:
        with np.load(path) as data:
            arrays = {k: data[k] for k in data.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise DataError(f"{path}: not a readable .npz scene ({error})") from error
    missing = {"fps", "frames", "cloth_v", "cloth_f", "body_v", "body_f", "pins", "pin_pos"} - set(arrays)
    if missing:
        raise DataError(f"{path}: scene lacks {', '.join(sorted(missing))}")
    return SceneFile(
        fps=float(arrays["fps"]),
        frames=int(arrays["frames"]) - 1,
        cloth_v=arrays["cloth_v"].astype(np.float64),
        cloth_f=arrays["cloth_f"].astype(np.int32),
        body_v=arrays["body_v"],
        body_f=arrays["body_f"].astype(np.int32),
        pins=arrays["pins"].astype(np.int64),
        pin_pos=arrays["pin_pos"].astype(np.float64),
    )
