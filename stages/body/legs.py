"""Two-bone inverse kinematics: legs that put the ankle exactly where it is asked to be."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.turns import rotate, turn, unit

Array = NDArray[np.float64]

STRAIGHTEST = np.deg2rad(4.0)
"""Least bend of a knee [rad]: a knee that locks straight snaps from frame to frame, and none may bend backwards."""

DEEPEST = np.deg2rad(150.0)
"""Greatest bend of a knee [rad]."""


@dataclass(frozen=True, eq=False)
class LegPose:
    """Rotations of one leg, frame by frame."""

    thigh: Array
    """World rotation of the thigh, shape [T, 3, 3]."""
    knee: Array
    """Rotation of the knee joint about the model's x axis, as the pose stores it [rad], shape [T]."""
    bend: Array
    """Angle between thigh and shank, 0 when straight [rad], shape [T]."""
    miss: Array
    """Distance by which the ankle could not reach its target [m], shape [T]."""

    @property
    def shank(self) -> Array:
        """World rotation of the shank, shape [T, 3, 3]."""
        shank: Array = self.thigh @ turn("x", self.knee)
        return shank


def hinge(leg: Array) -> tuple[float, float, float]:
    """Law of cosines of a knee that turns about x: |hip to ankle|^2 = offset + 2 rho cos(knee - straight).

    Args:
        leg: Vectors hip to knee and knee to ankle in the T-pose [m], shape [2, 3].

    Returns:
        `straight` [rad], the knee rotation at which the leg is longest; `rho` and `offset` [m^2].
    """
    (ux, uy, uz), (sx, sy, sz) = leg
    a, b = uy * sy + uz * sz, uz * sy - uy * sz
    return float(np.arctan2(b, a)), float(np.hypot(a, b)), float((leg**2).sum() + 2 * ux * sx)


def reach(leg: Array, bend: float = STRAIGHTEST) -> float:
    """Distance hip to ankle at a given bend of the knee [m]."""
    _, rho, offset = hinge(leg)
    return float(np.sqrt(offset + 2 * rho * np.cos(bend)))


def solve_leg(leg: Array, hip: Array, ankle: Array, knee_forward: Array) -> LegPose:
    """Bends one leg so that its ankle is at the target, with the knee pointing where it should.

    Args:
        leg: Vectors hip to knee and knee to ankle in the T-pose [m], shape [2, 3].
        hip: Hip positions [m], shape [T, 3].
        ankle: Wanted ankle positions [m], shape [T, 3].
        knee_forward: Direction in which the knee points, roughly; any length, shape [T, 3].

    Returns:
        The pose of the leg; where the target is out of reach the leg points at it and `miss` says by how much.
    """
    straight, rho, offset = hinge(leg)
    aim = ankle - hip
    distance = np.linalg.norm(aim, axis=-1)
    reached = np.clip(distance, reach(leg, DEEPEST), reach(leg))
    bend = np.arccos(np.clip((reached**2 - offset) / (2 * rho), -1.0, 1.0))
    knee = straight + bend
    chord = leg[0] + rotate(turn("x", knee), leg[1])
    lateral = np.cross(-aim, knee_forward)
    thigh = _frame(aim, lateral) @ np.swapaxes(_frame(chord, np.broadcast_to([1.0, 0.0, 0.0], chord.shape)), -1, -2)
    return LegPose(thigh=thigh, knee=knee, bend=bend, miss=np.abs(distance - reached))


def _frame(first: Array, second: Array) -> Array:
    """Orthonormal frames [T, 3, 3] whose columns are `first`, `second` made orthogonal to it, and their product."""
    e1 = unit(first)
    e2 = unit(second - (second * e1).sum(-1, keepdims=True) * e1)
    return np.stack([e1, e2, np.cross(e1, e2)], axis=-1)
