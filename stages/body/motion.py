"""A motion: what a body does, frame by frame, before and after it is put on a person."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FPS = 30.0
"""Frames a second of every published sequence."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """Joint rotations and the path of the root joint, in the z-up world."""

    pose: NDArray[np.float64]
    """Axis-angle of each joint relative to its parent [rad], shape [T, 24, 3]."""
    trans: NDArray[np.float64]
    """World position of the root joint [m], shape [T, 3]."""
    planted: NDArray[np.bool_]
    """Whether the left and the right foot bear weight, shape [T, 2]."""

    def __len__(self) -> int:
        """Number of frames T."""
        return len(self.pose)

    def cut(self, part: slice) -> "Motion":
        """Some of the frames."""
        return Motion(pose=self.pose[part], trans=self.trans[part], planted=self.planted[part])
