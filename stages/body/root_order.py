"""Mends recordings whose root was turned by the right angles in the wrong order.

A public release of CMU's clips as exponential maps, and what was made from it, has this fault. The angles x, y, z of
the root were meant as Rz Ry Rx, as in CMU's own files, and were put together as Rz Rx Ry. As long as a person looks
along one axis little is wrong; who turns leans over, tips or whirls round. The angles can be had back, since each
rotation is Rz Rx Ry of two sets of angles, and each goes on from frame to frame. Which is right, and whether
a recording has the fault at all, is told by its feet: with the right rotations those that stand do stand still.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stages.body.joint_map import match
from stages.body.recording import Recording
from stages.body.retarget import axes_of

Array = NDArray[np.float64]

SHORTEST = 1.0
"""Recordings shorter than this tell too little [s]."""

STILLER = 0.98
"""The feet must move less than this share of what they do as recorded, or nothing is mended [1]."""


def mend_root_order(recording: Recording, name: str) -> tuple[Recording, bool]:
    """Puts the root's angles together in the order that they were meant in, if that makes standing feet stand.

    Args:
        recording: A recording.
        name: Name of the motion, for errors.

    Returns:
        The recording, and whether it was mended.
    """
    root = match(recording.names)[0]
    short = len(recording.rotations) < 2 or len(recording.rotations) * recording.frame_time < SHORTEST
    if recording.bodily or short or axes_of(recording, name)[1, 1] < 0.5:
        return recording, False
    best, least = recording, STILLER * _restlessness(recording)
    for angles in _angles(recording.rotations[:, root]):
        rotations = recording.rotations.copy()
        rotations[:, root] = Rotation.from_euler("xyz", angles).as_matrix()
        tried = replace(recording, rotations=rotations)
        if (restlessness := _restlessness(tried)) < least:
            best, least = tried, restlessness
    return best, best is not recording


def _angles(rotations: Array) -> Array:
    """The two sets of angles x, y, z of rotations Rz Rx Ry that go on from frame to frame.

    Args:
        rotations: Matrices, shape [F, 3, 3].

    Returns:
        Angles [rad], shape [2, F, 3].
    """
    y, x, z = Rotation.from_matrix(rotations).as_euler("yxz").T
    sets = np.stack([np.stack([x, y, z], axis=-1), np.stack([np.pi - x, y + np.pi, z + np.pi], axis=-1)])
    out = np.empty_like(sets)
    out[:, 0] = sets[:, 0]
    for t in range(1, len(x)):
        steps = (sets[None, :, t] - out[:, None, t - 1] + np.pi) % (2 * np.pi) - np.pi
        nearest = (steps**2).sum(axis=-1).argmin(axis=1)
        out[:, t] = out[:, t - 1] + steps[[0, 1], nearest]
    return out


def _restlessness(recording: Recording) -> float:
    """Mean speed of whichever joint of the feet is slowest in a frame [file units/s]."""
    source = match(recording.names)
    feet = recording.forward()[1][:, [source[joint] for joint in (7, 8, 10, 11) if joint in source]]
    speeds = np.linalg.norm(np.diff(feet, axis=0), axis=-1) / recording.frame_time
    return float(speeds.min(axis=1).mean())
