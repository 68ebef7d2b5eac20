"""From any frame rate to 30 fps: frames are picked in time, rotations are interpolated on the sphere."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import interp1d
from scipy.spatial.transform import Rotation, Slerp

from stages.body.motion import FPS
from stages.body.recording import Recording

SLACK = 1e-3
"""Share of a frame by which the last frame may lie beyond the recording: 1/120 s is often written as .0083333."""


def frames_at_30(count: int, frame_time: float) -> int:
    """Number of frames at 30 fps of a recording of so many frames, this time apart [s]."""
    return int(np.floor((count - 1) * frame_time * FPS + SLACK)) + 1


def resample(recording: Recording) -> Recording:
    """The recording at 30 fps.

    Args:
        recording: A recording at any rate.

    Returns:
        The recording at the times 0, 1/30 s, 2/30 s... up to its end.
    """
    count = len(recording.rotations)
    frames = frames_at_30(count, recording.frame_time)
    at = np.minimum(np.arange(frames) / (FPS * recording.frame_time), count - 1)
    if count == 1:
        return replace(recording, frame_time=1 / FPS)
    old = np.arange(count)
    rotations = np.empty((frames, *recording.rotations.shape[1:]))
    for j in range(rotations.shape[1]):
        rotations[:, j] = Slerp(old, Rotation.from_matrix(recording.rotations[:, j]))(at).as_matrix()
    translations = interp1d(old, recording.translations, axis=0, assume_sorted=True)(at)
    return replace(recording, rotations=rotations, translations=translations, frame_time=1 / FPS)
