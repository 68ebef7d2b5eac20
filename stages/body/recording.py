"""A recorded motion as every reader gives it: a skeleton and what its joints do, frame by frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class Recording:
    """A skeleton and its motion, in the file's own axes and length unit."""

    names: tuple[str, ...]
    """Names of the joints, parents first, J of them."""
    parents: NDArray[np.int64]
    """Parent of each joint, -1 for the root, shape [J]."""
    offsets: Array
    """Offset from the parent [file units], shape [J, 3]."""
    tips: dict[str, Array]
    """Offset of the end site of each joint that has one [file units], shape [3]."""
    rotations: Array
    """Rotation of each joint relative to its parent, matrices, shape [F, J, 3, 3]."""
    translations: Array
    """Position of each joint relative to its parent [file units], shape [F, J, 3]."""
    frame_time: float
    """Time between two frames [s]."""
    bodily: bool = False
    """Whether the rotations are those of SMPL's own joints, so that no difference of rest poses is to be solved."""

    def forward(self) -> tuple[Array, Array]:
        """World rotations [F, J, 3, 3] and positions [F, J, 3] (file units) of all joints."""
        rotations, positions = np.empty_like(self.rotations), np.empty_like(self.translations)
        for j, parent in enumerate(self.parents):
            if parent < 0:
                rotations[:, j], positions[:, j] = self.rotations[:, j], self.translations[:, j]
                continue
            rotations[:, j] = rotations[:, parent] @ self.rotations[:, j]
            moved = np.einsum("fij,fj->fi", rotations[:, parent], self.translations[:, j])
            positions[:, j] = positions[:, parent] + moved
        return rotations, positions

    def rest(self) -> Array:
        """Joint positions with no rotation, the root at the origin [file units], shape [J, 3]."""
        positions = np.zeros_like(self.offsets)
        for j, parent in enumerate(self.parents):
            if parent >= 0:
                positions[j] = positions[parent] + self.offsets[j]
        return positions
