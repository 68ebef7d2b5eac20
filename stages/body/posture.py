"""From what an animator thinks in - pelvis, feet, spine, arms, gaze - to the 24 joint rotations of a pose."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stages.body.figure import ANKLES, BALLS, HIPS, KNEES, SIDES, Figure
from stages.body.legs import LegPose, solve_leg
from stages.body.turns import WORLD_FROM_MODEL, axis_angle, rotate, turn

Array = NDArray[np.float64]

SPINE, NECK, HEAD = (3, 6, 9), 12, 15
COLLARS, SHOULDERS, ELBOWS, WRISTS = (13, 14), (16, 17), (18, 19), (20, 21)

SPINE_SHARES = (0.3, 0.4, 0.3)
"""How the bend of the trunk is divided over the three spine joints."""

COLLAR_SHARE = 0.14
"""Share of the collar in the rotation of the arm away from the T-pose."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Arm:
    """One arm, frame by frame; all angles are 0 when it hangs straight down, palm to the thigh [rad], shape [T]."""

    out: Array
    """Away from the body to the side; pi/2 is the T-pose."""
    forward: Array
    """Swing of the whole arm to the front."""
    twist: Array
    """Turn about the upper arm's own axis; positive turns a bent forearm inward, across the body."""
    elbow: Array
    """Bend of the elbow."""
    wrist: Array
    """Bend of the wrist towards the palm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Posture:
    """The whole person, frame by frame, in the y-up frame of motion."""

    root: Array
    """Position of the root joint [m], shape [T, 3]."""
    pelvis: Array
    """World rotation of the pelvis, shape [T, 3, 3]."""
    ankles: tuple[Array, Array]
    """Ankle positions, left and right [m], shape [T, 3]."""
    feet: tuple[Array, Array]
    """World rotations of the feet, shape [T, 3, 3]."""
    toes: tuple[Array, Array]
    """Rotation of the toe joints about x [rad], shape [T]."""
    knees_out: Array
    """Heading of both knees away from that of the pelvis, outward [rad], shape [T]."""
    trunk: Array
    """Rotation of the chest relative to the pelvis, as a vector (bend, turn, lean) [rad], shape [T, 3]."""
    gaze: Array
    """World rotation of the head, shape [T, 3, 3]."""
    arms: tuple[Arm, Arm] = field(repr=False)
    """Left and right arm."""


def assemble(figure: Figure, posture: Posture) -> tuple[Array, Array, tuple[LegPose, LegPose]]:
    """Solves the legs and gathers all joint rotations.

    Args:
        figure: The person.
        posture: What the person does.

    Returns:
        `pose`, axis-angle in the z-up world [rad], shape [T, 24, 3]; `trans`, world position of the root joint [m],
        shape [T, 3]; and both legs.
    """
    local = np.broadcast_to(np.eye(3), (len(posture.root), 24, 3, 3)).copy()
    local[:, 0] = WORLD_FROM_MODEL @ posture.pelvis
    legs = []
    for side in (0, 1):
        hip = posture.root + rotate(posture.pelvis, figure.joints[HIPS[side]] - figure.joints[0])
        knee_forward = rotate(posture.pelvis @ turn("y", SIDES[side] * posture.knees_out), [0.0, 0.0, 1.0])
        leg = solve_leg(figure.leg(side), hip, posture.ankles[side], knee_forward)
        local[:, HIPS[side]] = _inverse(posture.pelvis) @ leg.thigh
        local[:, KNEES[side]] = turn("x", leg.knee)
        local[:, ANKLES[side]] = _inverse(leg.shank) @ posture.feet[side]
        local[:, BALLS[side]] = turn("x", posture.toes[side])
        legs.append(leg)
    chest = posture.pelvis
    for joint, share in zip(SPINE, SPINE_SHARES, strict=True):
        local[:, joint] = _from_vector(posture.trunk * share)
        chest = chest @ local[:, joint]
    half = _from_vector(axis_angle(_inverse(chest) @ posture.gaze) / 2)
    local[:, NECK] = local[:, HEAD] = half
    for side in (0, 1):
        _place_arm(local, posture.arms[side], side)
    trans = posture.root @ WORLD_FROM_MODEL.T
    return axis_angle(local), trans, (legs[0], legs[1])


def _place_arm(local: Array, arm: Arm, side: int) -> None:
    """Writes the rotations of one arm into `local` [T, 24, 3, 3]."""
    sign = SIDES[side]
    raised = turn("x", -arm.forward) @ turn("z", sign * (arm.out - np.pi / 2)) @ turn("x", arm.twist)
    collar = _from_vector(axis_angle(raised) * COLLAR_SHARE)
    local[:, COLLARS[side]] = collar
    local[:, SHOULDERS[side]] = _inverse(collar) @ raised
    local[:, ELBOWS[side]] = turn("y", -sign * arm.elbow)
    local[:, WRISTS[side]] = turn("z", -sign * arm.wrist)


def _from_vector(vectors: Array) -> Array:
    """Rotation matrices [..., 3, 3] of axis-angle vectors [..., 3]."""
    return Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(*vectors.shape, 3)


def _inverse(matrices: Array) -> Array:
    """Transposes of rotation matrices [..., 3, 3]."""
    return np.swapaxes(matrices, -1, -2)
