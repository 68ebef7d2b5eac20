"""Reader of the clips of DeepMimic's humanoid, `humanoid3d_*.txt`, as pybullet carries them.

JSON with "Frames" of 44 numbers: how long the frame lasts [s], the root's position [m] and quaternion, then turns of
the joints relative to their parents, as quaternions (w, x, y, z) or, of knees and elbows, as an angle about z [rad].
y is up, the person faces x, the right side is +z (X. B. Peng et al., DeepMimic, 2018; the skeleton is that of
pybullet's `humanoid.urdf`, which is four times as large).
"""

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from stages.body.readers.text import LARGEST, read_bytes
from stages.body.recording import Recording
from stages.spec import DataError

Array = NDArray[np.float64]

SKELETON: tuple[tuple[str, str, tuple[float, float, float], int], ...] = (
    ("pelvis", "", (0.0, 0.0, 0.0), 4),
    ("spine3", "pelvis", (0.0, 0.236151, 0.0), 4),
    ("neck", "spine3", (0.0, 0.223894, 0.0), 4),
    ("right_hip", "pelvis", (0.0, 0.0, 0.084887), 4),
    ("right_knee", "right_hip", (0.0, -0.421546, 0.0), 1),
    ("right_ankle", "right_knee", (0.0, -0.40987, 0.0), 4),
    ("right_shoulder", "spine3", (-0.02405, 0.2435, 0.18311), 4),
    ("right_elbow", "right_shoulder", (0.0, -0.274788, 0.0), 1),
    ("left_hip", "pelvis", (0.0, 0.0, -0.084887), 4),
    ("left_knee", "left_hip", (0.0, -0.421546, 0.0), 1),
    ("left_ankle", "left_knee", (0.0, -0.40987, 0.0), 4),
    ("left_shoulder", "spine3", (-0.02405, 0.2435, -0.18311), 4),
    ("left_elbow", "left_shoulder", (0.0, -0.274788, 0.0), 1),
    ("head", "neck", (0.0, 0.175, 0.0), 0),
    ("right_wrist", "right_elbow", (0.0, -0.258947, 0.0), 0),
    ("left_wrist", "left_elbow", (0.0, -0.258947, 0.0), 0),
)
"""Joint, parent, offset [m] and how many numbers of a frame turn it, in the order of a frame."""

WIDTH = 4 + sum(count for *_, count in SKELETON)
"""Numbers of a frame."""

LONGEST = 600.0
"""Clips longer than this are none of DeepMimic's [s]."""


UNEVEN = 0.25
"""Quaternions are off length 1 by up to an eighth in the clips themselves; more is damage [1]."""


def read_deepmimic(path: Path) -> Recording:
    """Reads a clip.

    Args:
        path: The file.

    Returns:
        The recording [m], at the rate of its shortest frame, as frames may differ in length.

    Raises:
        DataError: The file is missing, no such clip, or holds no or no finite motion.
    """
    values = _frames(path)
    durations = values[:, 0]
    # The last frame's own duration leads nowhere.
    steps = durations[:-1] if len(values) > 1 else durations[:1]
    if not (steps > 1e-4).all() or not steps.sum() < LONGEST:
        raise DataError(
            f"{path.name}: frames must last from 0.0001 s, {LONGEST:g} s together; correct the first numbers"
        )
    names = [name for name, *_ in SKELETON]
    offsets = np.array([offset for _, _, offset, _ in SKELETON])
    rotations = np.broadcast_to(np.eye(3), (len(values), len(names), 3, 3)).copy()
    column = 4
    for j, (name, _, _, count) in enumerate(SKELETON):
        block = values[:, column : column + count]
        column += count
        if count == 4:
            lengths = np.linalg.norm(block, axis=1)
            if not np.all(np.abs(lengths - 1) < UNEVEN):
                frame = int(np.abs(lengths - 1).argmax())
                raise DataError(
                    f"{path.name}: frame {frame}: the quaternion of {name} must have length 1, got {lengths[frame]:g}"
                )
            rotations[:, j] = Rotation.from_quat(block, scalar_first=True).as_matrix()
        elif count == 1:
            rotations[:, j] = Rotation.from_euler("z", block).as_matrix()
    translations = np.broadcast_to(offsets, (len(values), len(names), 3)).copy()
    translations[:, 0] = values[:, 1:4]
    parents = np.array([names.index(parent) if parent else -1 for _, parent, _, _ in SKELETON])
    times = np.concatenate([[0.0], np.cumsum(durations[:-1])])
    rotations, translations, step = _evenly(times, rotations, translations, float(steps.min()))
    return Recording(
        names=tuple(names),
        parents=parents,
        offsets=offsets,
        tips={},
        rotations=rotations,
        translations=translations,
        frame_time=step,
    )


def _frames(path: Path) -> Array:
    """Numbers of all frames, shape [F, 44]."""
    content = read_bytes(path)
    try:
        clip = json.loads(content)
    except (ValueError, RecursionError):
        raise DataError(f"{path.name}: is no clip of DeepMimic's, which are JSON; copy the file again") from None
    frames = clip.get("Frames") if isinstance(clip, dict) else None
    if not isinstance(frames, list) or not frames:
        raise DataError(f"{path.name}: has no 'Frames' with {WIDTH} numbers each; name a clip of DeepMimic's humanoid")
    for number, frame in enumerate(frames):
        if not isinstance(frame, list) or len(frame) != WIDTH:
            got = len(frame) if isinstance(frame, list) else type(frame).__name__
            raise DataError(f"{path.name}: frame {number} must have {WIDTH} numbers, got {got}; the file is damaged")
        for value in frame:
            if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST:
                shown = repr(value)[:30]
                raise DataError(f"{path.name}: frame {number} must have finite numbers, got {shown}; repair the motion")
    return np.array(frames, dtype=np.float64)


def _evenly(times: Array, rotations: Array, translations: Array, step: float) -> tuple[Array, Array, float]:
    """The motion at even times, and the time between them [s]."""
    if len(times) == 1 or np.ptp(np.diff(times)) < 1e-6:
        return rotations, translations, step
    step = max(step, float(times[-1]) / 20000)
    at = np.minimum(np.arange(int(times[-1] / step + 1e-6) + 1) * step, times[-1])
    turned = np.stack(
        [Slerp(times, Rotation.from_matrix(rotations[:, j]))(at).as_matrix() for j in range(rotations.shape[1])], axis=1
    )
    flat = translations.reshape(len(times), -1)
    moved = np.stack([np.interp(at, times, column) for column in flat.T], axis=1)
    return turned, moved.reshape(len(at), *translations.shape[1:]), step
