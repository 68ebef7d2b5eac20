"""The person to be moved: bone vectors, soles and girth, measured on the shaped body itself."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.body import BodyModel

HIPS, KNEES, ANKLES, BALLS = (1, 2), (4, 5), (7, 8), (10, 11)
"""Joints of the legs, left and right."""

SIDES = (1.0, -1.0)
"""Sign of x on the left and on the right side of the body."""

SOLE_BAND = 0.03
"""Height of the slice at the bottom of a foot that can touch the ground [m]."""

THIGH_GAP = 0.012
"""Free space wanted between the thighs of a person who stands [m]: two layers of cloth with their contact margins."""

CREASE = 0.22
"""Share of the thigh, from the hip down, in which the thighs meet in the crease of the crotch and may touch."""


@dataclass(frozen=True, eq=False)
class Figure:
    """What motion has to know of a shaped body; the model frame is y up, metres."""

    joints: NDArray[np.float64]
    """Joints in the T-pose [m], shape [24, 3]."""
    soles: tuple[NDArray[np.float64], NDArray[np.float64]]
    """Points of each foot that can touch the ground, relative to the ankle [m], shape [S, 3] each."""
    toe_weights: tuple[NDArray[np.float64], NDArray[np.float64]]
    """Share of the toe joint in the motion of each of those points, shape [S] each."""
    thigh_points: tuple[NDArray[np.float64], NDArray[np.float64]]
    """Points of each thigh below the crease, relative to the hip [m], shape [H, 3] each."""

    @cached_property
    def leg_length(self) -> float:
        """Thigh and shank together, mean of both sides [m]."""
        return float(np.mean([sum(np.linalg.norm(b, axis=-1)) for b in (self.leg(0), self.leg(1))]))

    @cached_property
    def hip_height(self) -> float:
        """Height of the root joint above the soles in the T-pose [m]."""
        return float(-min((self.joints[ANKLES[i]] + self.soles[i])[:, 1].min() for i in (0, 1)) + self.joints[0, 1])

    @cached_property
    def ankle_heights(self) -> tuple[float, float]:
        """Height of each ankle above its sole when the foot is flat [m]."""
        return float(-self.soles[0][:, 1].min()), float(-self.soles[1][:, 1].min())

    def leg(self, side: int) -> NDArray[np.float64]:
        """Vectors hip to knee and knee to ankle in the T-pose [m], shape [2, 3]; side 0 is left."""
        j = self.joints
        return np.stack([j[KNEES[side]] - j[HIPS[side]], j[ANKLES[side]] - j[KNEES[side]]])

    def ball(self, side: int) -> NDArray[np.float64]:
        """Vector ankle to ball of the foot in the T-pose [m], shape [3]."""
        ball: NDArray[np.float64] = self.joints[BALLS[side]] - self.joints[ANKLES[side]]
        return ball

    @cached_property
    def stance(self) -> float:
        """Smallest distance of an ankle from the midline at which straight legs leave `THIGH_GAP` [m]."""
        hip, leg = abs(self.joints[HIPS[0], 0]), self.leg(0).sum(axis=0)
        points, best = self.thigh_points[0], 0.0
        for splay in np.linspace(-0.10, 0.30, 81):
            c, s = np.cos(splay), np.sin(splay)
            if hip + (c * points[:, 0] - s * points[:, 1]).min() >= THIGH_GAP / 2:
                best = hip + c * leg[0] - s * leg[1]
                break
        else:
            best = hip + np.cos(0.30) * leg[0] - np.sin(0.30) * leg[1]
        return float(best)


def measure(model: BodyModel, betas: ArrayLike) -> Figure:
    """Measures one person.

    Args:
        model: The body.
        betas: Shape coefficients, shape [B].

    Returns:
        The figure of that person.
    """
    vertices, joints = model.shape(betas)
    soles, toe_weights, thighs = [], [], []
    for side in (0, 1):
        foot_weights = model.weights[:, [ANKLES[side], BALLS[side]]]
        foot = foot_weights.sum(axis=1) > 0.5
        low = foot & (vertices[:, 1] < vertices[foot, 1].min() + SOLE_BAND)
        soles.append(vertices[low].astype(np.float64) - joints[ANKLES[side]])
        toe_weights.append((foot_weights[low, 1] / foot_weights[low].sum(axis=1)).astype(np.float64))
        thigh = model.weights.argmax(axis=1) == HIPS[side]
        crease = joints[HIPS[side], 1] - CREASE * (joints[HIPS[side], 1] - joints[KNEES[side], 1])
        thigh &= vertices[:, 1] < crease
        thighs.append(vertices[thigh].astype(np.float64) - joints[HIPS[side]])
    return Figure(
        joints=joints.astype(np.float64),
        soles=(soles[0], soles[1]),
        toe_weights=(toe_weights[0], toe_weights[1]),
        thigh_points=(thighs[0], thighs[1]),
    )
