"""Mends what is wrong with many public recordings: a fake first frame, and flips of the root."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_dilation
from scipy.spatial.transform import Rotation, Slerp

from stages.body.joint_map import match
from stages.body.recording import Recording

FAKE_JUMP = np.deg2rad(6.0)
"""Least mean rotation of the joints between the first two frames that betrays a fake first frame [rad]."""

FAKE_RATIO = 4.0
"""How many times larger that rotation is than the largest one between other frames."""

FASTEST_TURN = 20.0
"""No person turns faster than this about any axis, whirling dancers included [rad/s]."""

FLIP_GAP = 0.10
"""Flips that are nearer to each other than this are mended as one [s]."""


def drop_fake_start(recording: Recording) -> Recording:
    """Drops a first frame that was put in front of the motion, such as a T-pose.

    Args:
        recording: A recording.

    Returns:
        The recording without its first frame if the pose jumps from there to the next as it never does afterwards,
        else the recording itself.
    """
    if len(recording.rotations) < 3:
        return recording
    # Fingers and thumbs jump all the time: only the joints that move the body are looked at.
    joints = sorted(match(recording.names).values()) or list(range(len(recording.names)))
    jumps = _turning(recording.rotations[:, joints]).mean(axis=1)
    if jumps[0] < FAKE_JUMP or jumps[0] < FAKE_RATIO * jumps[1:].max():
        return recording
    return replace(recording, rotations=recording.rotations[1:], translations=recording.translations[1:])


def mend_flips(recording: Recording) -> tuple[Recording, int]:
    """Bridges the moments in which the root spins faster than a person can.

    Rotation vectors that were filtered or interpolated across half a turn leave such flips: the person whirls round
    within a few hundredths of a second. The rotations there are replaced by the shortest way between their neighbours.

    Args:
        recording: A recording.

    Returns:
        The recording, and how many of its frames were mended.
    """
    root = recording.rotations[:, 0]
    count = len(root)
    fast = _turning(root[:, None])[:, 0] > FASTEST_TURN * recording.frame_time
    if not fast.any():
        return recording, 0
    bad = np.zeros(count, dtype=bool)
    bad[:-1] |= fast
    bad[1:] |= fast
    gap = max(1, round(FLIP_GAP / recording.frame_time))
    bad = binary_closing(np.pad(bad, gap), np.ones(gap))[gap:-gap]
    # The frames beside a flip are bent towards it by the same filter.
    bad = binary_dilation(bad, iterations=gap)
    good = np.flatnonzero(~bad)
    if len(good) < 2:
        return recording, 0
    at = np.clip(np.arange(count), good[0], good[-1])
    mended = recording.rotations.copy()
    mended[:, 0] = Slerp(good, Rotation.from_matrix(root[good]))(at).as_matrix()
    return replace(recording, rotations=mended), int(bad.sum())


def _turning(rotations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles between successive frames [rad], shape [F - 1, J], of rotations [F, J, 3, 3]."""
    turned = np.swapaxes(rotations[:-1], -1, -2) @ rotations[1:]
    cosine = (np.trace(turned, axis1=-2, axis2=-1) - 1) / 2
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))
