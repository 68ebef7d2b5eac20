"""The axes of a recorded skeleton's joints, where its rest pose tells nothing, found from the motion itself.

Some files have a rest pose that is no person's: in LAFAN1 all bones lie along one axis. Where its joints are in each
frame is known all the same. In the axes of a joint the direction to the next one is constant; so is, on average, the
axis about which knees and elbows bend, and the direction across the hips or the shoulders. Two such directions fix how
the joint's axes lie to those of the body's.
"""

import numpy as np
from numpy.typing import NDArray

from model.body import JOINT_NAMES, PARENTS
from stages.body.turns import turn, unit

Array = NDArray[np.float64]

LIMBS = ((1, 4, 7), (2, 5, 8), (16, 18, 20), (17, 19, 21))
"""Legs and arms: hip, knee, ankle; shoulder, elbow, wrist."""

TRUNK = (3, 6, 9, 12, 15)
"""Joints of the trunk, upwards."""

STEADY = 0.01
"""Weight of the trunk's axes against the axis of a bend at right angles: limbs that stay straight have no such axis."""

SHORT = 1e-3
"""Bones shorter than this share of the legs have no direction [1]."""


def calibrate(rotations: Array, positions: Array, source: dict[int, int], joints: Array) -> dict[int, Array]:
    """Turns from the axes of the body's joints in the T-pose to those of the recorded joints.

    Args:
        rotations: World rotations of the recorded joints, y up, shape [T, J, 3, 3].
        positions: Their positions, shape [T, J, 3].
        source: Joint of the body -> recorded joint.
        joints: Joints of the body in the T-pose [m], shape [24, 3].

    Returns:
        For each joint of the body in `source` its turn B, shape [3, 3]: a recorded rotation G is G B of the body's.
    """
    theirs = {joint: positions[:, index] for joint, index in source.items()}
    bends = [_bend(theirs, chain) for chain in LIMBS]
    own, at = _bent_pose(joints, bends)
    ours = {joint: at[None, joint] for joint in source}
    return {
        joint: _aligned(
            [_local(own[None, joint], v) for v in _references(ours, joint)],
            [_local(rotations[:, index], v) for v in _references(theirs, joint)],
        )
        for joint, index in source.items()
    }


def _bend(at: dict[int, Array], chain: tuple[int, int, int]) -> float:
    """Mean angle of a knee or an elbow, 0 when straight [rad]."""
    upper, lower = unit(at[chain[1]] - at[chain[0]]), unit(at[chain[2]] - at[chain[1]])
    return float(np.arccos(np.clip((upper * lower).sum(-1), -1.0, 1.0)).mean())


def _bent_pose(joints: Array, bends: list[float]) -> tuple[Array, Array]:
    """World rotations [24, 3, 3] and joints [24, 3] of the body's T-pose with its limbs bent [rad].

    A limb that is never quite straight has its hinge where a bent limb has it, not where the T-pose's own small bends
    would put it.
    """
    local = np.broadcast_to(np.eye(3), (24, 3, 3)).copy()
    for (_, hinge, _), bend, axis, sign in zip(LIMBS, bends, "xxyy", (1, 1, -1, 1), strict=True):
        local[hinge] = turn(axis, sign * bend)
    rotations, at = local.copy(), np.array(joints, dtype=np.float64)
    for joint in range(1, 24):
        parent = int(PARENTS[joint])
        rotations[joint] = rotations[parent] @ local[joint]
        at[joint] = at[parent] + rotations[parent] @ (joints[joint] - joints[parent])
    return rotations, at


def _references(at: dict[int, Array], joint: int) -> tuple[Array, Array]:
    """Two directions that belong to a joint, from positions [T, 3] of all joints; the first one counts exactly."""
    hips, shoulders = unit(at[1] - at[2]), unit(at[16] - at[17])
    length = float(np.linalg.norm(at[4] - at[1], axis=-1).mean())
    if joint == 0:
        return hips, _upward(at, (at[1] + at[2]) / 2, TRUNK, length)
    if joint in TRUNK:
        across = shoulders if joint >= 9 else hips if joint == 3 else hips + shoulders
        beyond = tuple(j for j in TRUNK if j > joint)
        up = _upward(at, at[joint], beyond, length) if beyond else unit(at[15] - at[12])
        return up, across
    left = JOINT_NAMES[joint].startswith("left")
    hip, shoulder = (1, 16) if left else (2, 17)
    if joint in (13, 14):
        outward = at[shoulder] - at[joint]
        short = float(np.linalg.norm(outward, axis=-1).mean()) < SHORT * length
        return (shoulders if short else unit(outward)), _upward(at, at[joint], (12, 15), length)
    if joint >= 16:
        upper, lower = unit(at[shoulder + 2] - at[shoulder]), unit(at[shoulder + 4] - at[shoulder + 2])
        # The elbow of a T-pose bends about the vertical, the left one by a negative turn.
        bend = (-1.0 if left else 1.0) * np.cross(upper, lower)
        return (upper if joint == shoulder else lower), bend + STEADY * _upward(at, at[12], (15,), length)
    thigh, shank = unit(at[hip + 3] - at[hip]), unit(at[hip + 6] - at[hip + 3])
    bend = np.cross(thigh, shank) + STEADY * hips
    if joint == hip:
        return thigh, bend
    foot = at[hip + 9] - at[hip + 6] if hip + 9 in at else np.zeros(3)
    if joint == hip + 3 or float(np.linalg.norm(foot, axis=-1).mean()) < SHORT * length:
        return shank, bend
    return unit(foot), bend


def _upward(at: dict[int, Array], start: Array, joints: tuple[int, ...], length: float) -> Array:
    """Direction from a place to the first of some joints that is there and not at that place itself."""
    for joint in joints:
        if joint in at and float(np.linalg.norm(at[joint] - start, axis=-1).mean()) > SHORT * length:
            return unit(at[joint] - start)
    return unit(at[15] - (at[1] + at[2]) / 2)


def _local(rotations: Array, vectors: Array) -> Array:
    """Mean of world vectors [T, 3] in the axes of a joint with rotations [T, 3, 3], shape [3]."""
    return np.asarray(np.einsum("tji,tj->ti", rotations, vectors).mean(axis=0))


def _aligned(ours: list[Array], theirs: list[Array]) -> Array:
    """Rotation that takes one pair of directions to another, the first ones exactly, shape [3, 3]."""
    return _frame(*theirs) @ _frame(*ours).T


def _frame(first: Array, second: Array) -> Array:
    e1 = unit(first)
    across = np.cross(e1, second)
    if not np.linalg.norm(across) > 1e-9:
        across = np.cross(e1, np.eye(3)[int(np.abs(e1).argmin())])
    e3 = unit(across)
    return np.stack([e1, np.cross(e3, e1), e3], axis=-1)
