"""One encoded item as the training reads it, and the conditions that its body sets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

FEMALE, MALE = 1.0, -1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class WornGarment:
    """One garment of an item.

    Attributes:
        name: Its name in the outfit.
        kind: Garment type.
        topology: "body" or "skirt".
        mask: Layer vertices that it covers, shape (N,).
        at_rest: Offsets from the layer at rest [m], rest frame, shape (N, 3).
        moving: Offsets from the posed layer [m], world axes, in the record's frames, shape (T, N, 3); T = 0 if static.
    """

    name: str
    kind: str
    topology: str
    mask: NDArray[np.bool_]
    at_rest: NDArray[np.float32]
    moving: NDArray[np.float32]


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """One item: a person and what it wears.

    Attributes:
        item: Its name.
        sequence: Whether it moves.
        train: Whether it is in the training split.
        gender: "female" or "male".
        betas: Shape coefficients, shape (10,).
        tightness: Offsets of the first two betas that the garments were resized by, shape (2,).
        pose: All poses [rad], shape (F, 24, 3).
        frames: Frames of `pose` that `moving` offsets were read for, shape (T,).
        garments: What is worn.
    """

    item: str
    sequence: bool
    train: bool
    gender: str
    betas: NDArray[np.float32]
    tightness: NDArray[np.float32]
    pose: NDArray[np.float32]
    frames: NDArray[np.int64]
    garments: tuple[WornGarment, ...]

    @property
    def static_conditions(self) -> NDArray[np.float32]:
        """cvar_s: betas, gender and tightness, 13 numbers (CLOTH3D, Network)."""
        return person_conditions(self.betas, self.gender, self.tightness)


def person_conditions(betas: NDArray, gender: str, tightness: NDArray) -> NDArray[np.float32]:
    """Betas (10,), gender as one more number, tightness (2,)."""
    return np.concatenate([betas, [FEMALE if gender == "female" else MALE], tightness]).astype(np.float32)


def headings(pose: NDArray) -> NDArray[np.float64]:
    """Rotation about z that each pose (F, 24, 3) is turned by, as matrices (F, 3, 3): where the person faces."""
    forward = Rotation.from_rotvec(np.array(pose[:, 0], np.float64)).as_matrix()[:, :, 2]
    # A person in the rest pose faces -y.
    angle = np.arctan2(forward[:, 0], -forward[:, 1])
    return Rotation.from_rotvec(angle[:, None] * np.array([0.0, 0.0, 1.0])).as_matrix()


def facing_front(pose: NDArray) -> NDArray[np.float64]:
    """The poses (F, 24, 3) turned about z until each person faces -y."""
    level = np.array(pose, np.float64)
    turned = np.swapaxes(headings(pose), 1, 2) @ Rotation.from_rotvec(level[:, 0]).as_matrix()
    level[:, 0] = Rotation.from_matrix(turned).as_rotvec()
    return level


def pose_conditions(pose: NDArray, frames: NDArray[np.int64], count: int, spacing: int) -> NDArray[np.float32]:
    """theta: the poses at each frame and before it, without the heading, which no garment feels.

    Args:
        pose: All poses [rad], shape (F, 24, 3).
        frames: Frames wanted, shape (T,).
        count: Poses for each, f in the paper.
        spacing: Frames between them; before the start, the first pose stands in.

    Returns:
        Shape (T, 72 f), each frame's own pose first.
    """
    level = facing_front(pose)
    index = np.maximum(frames[:, None] - spacing * np.arange(count), 0)
    return level[index].reshape(len(frames), -1).astype(np.float32)
