"""Where a garment's vertices are in terms of the wearer: along the arms, along the legs, and how high."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from model.body import JOINT_NAMES

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Axes:
    """The lines of a wearer in the rest frame that garments are measured along; x > 0 is the wearer's left."""

    shoulder: Array
    """Left shoulder joint [m], shape [3]; the right one is its mirror image."""
    wrist: Array
    """Left wrist joint [m], shape [3]."""
    hip: Array
    """Left hip joint [m], shape [3]."""
    ankle: Array
    """Left ankle joint [m], shape [3]."""

    @classmethod
    def of(cls, joints: Array) -> "Axes":
        """The axes through SMPL's joints [m], shape [24, 3], the sides averaged."""

        def mean(name: str) -> Array:
            left, right = (joints[JOINT_NAMES.index(f"{side}_{name}")] for side in ("left", "right"))
            middle: Array = (left + right * [-1, 1, 1]) / 2
            return middle

        return cls(mean("shoulder"), mean("wrist"), mean("hip"), mean("ankle"))

    @property
    def arm_length(self) -> float:
        """Shoulder to wrist [m]."""
        return float(np.linalg.norm(self.wrist - self.shoulder))

    @property
    def leg_length(self) -> float:
        """Hip to ankle [m]."""
        return float(np.linalg.norm(self.ankle - self.hip))

    def along_arm(self, points: Array) -> Array:
        """Position along the nearer arm: 0 at the shoulder, 1 at the wrist, shape [n]."""
        return _along(points, self.shoulder, self.wrist)

    def along_leg(self, points: Array) -> Array:
        """Position along the nearer leg: 0 at the hip, 1 at the ankle, shape [n]."""
        return _along(points, self.hip, self.ankle)

    def arm_centre(self, points: Array) -> Array:
        """Foot of each point on the nearer arm's axis [m], shape [n, 3]."""
        return _foot(points, self.shoulder, self.wrist)

    def leg_centre(self, points: Array) -> Array:
        """Foot of each point on the nearer leg's axis [m], shape [n, 3]."""
        return _foot(points, self.hip, self.ankle)


def _along(points: Array, start: Array, end: Array) -> Array:
    """Share of the way from start to end, after mirroring every point to x >= 0."""
    axis = end - start
    mirrored = np.stack([np.abs(points[:, 0]), points[:, 1], points[:, 2]], axis=1)
    share: Array = (mirrored - start) @ axis / (axis @ axis)
    return share


def _foot(points: Array, start: Array, end: Array) -> Array:
    """Foot of each point on the axis of its own side."""
    feet = start + _along(points, start, end)[:, None] * (end - start)
    feet[:, 0] *= np.where(points[:, 0] < 0, -1.0, 1.0)
    return feet


def smooth_step(values: Array, low: float, high: float) -> Array:
    """0 up to `low`, 1 from `high`, and a smooth rise between them, shape [n]."""
    t = np.clip((values - low) / (high - low), 0.0, 1.0)
    rise: Array = t * t * (3.0 - 2.0 * t)
    return rise
