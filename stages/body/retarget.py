"""Puts a recorded motion on a person: the same directions of the limbs, paths scaled by the length of the legs."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from model.body import JOINT_NAMES, PARENTS
from stages.body.calibrate import calibrate
from stages.body.figure import Figure
from stages.body.joint_map import BONES, FEET, match, refuse_missing
from stages.body.posture import COLLAR_SHARE, COLLARS, SHOULDERS, SPINE, WRISTS
from stages.body.recording import Recording
from stages.body.turns import unit
from stages.spec import DataError

Array = NDArray[np.float64]

UPRIGHT = 0.5
"""Legs of a rest pose point down if the cosine of their angle to the vertical is larger than this [1]."""

SHORTEST_BONE = 1e-3
"""Limbs shorter than this share of the legs have no direction [1]."""

LYING = 0.3
"""The file's y is up if the trunk points along it by more than this on average: who crawls turns about [1]."""


def retarget(recording: Recording, figure: Figure, name: str) -> tuple[Array, Array]:
    """The motion on the person's own skeleton, before the feet are put on the ground.

    A recorded joint with world rotation G moves the body's joint by R = A G B. A turns the recording's axes into the
    model's. B = A^T D, where D takes the bone of the body's T-pose to the bone of the recording's rest pose: R times
    the body's bone then has the direction of the recorded bone. Where the rest pose is no standing person, B is found
    from the motion; where the rotations are of SMPL's own joints, they are taken as they are, B = 1.

    Args:
        recording: The motion, at the wanted rate.
        figure: The person.
        name: Name of the motion, for errors.

    Returns:
        World rotations of the joints in the y-up frame of motion, shape [T, 24, 3, 3], and the path of the root joint
        [m], shape [T, 3].

    Raises:
        DataError: Joints are missing, or the skeleton has no legs or no trunk.
    """
    refuse_missing(recording.names, name)
    source = match(recording.names)
    rest = recording.rest()
    turned, positions = recording.forward()
    axes = axes_of(recording, name)
    if recording.bodily:
        own = {j: np.eye(3) for j in source}
    elif _axes_at_rest(rest, source) is not None:
        at_rest = {j: rest[index] @ axes.T for j, index in source.items()}
        own = {j: axes.T @ _difference(figure.joints, at_rest, j) for j in source}
    else:
        with np.errstate(invalid="ignore"):
            own = calibrate(axes @ turned, positions @ axes.T, source, figure.joints)
        if lost := [JOINT_NAMES[j] for j, turn in own.items() if not np.isfinite(turn).all()]:
            raise DataError(
                f"{name}: nothing tells how {lost[0]} lies; give a skeleton with offsets between its joints"
            )
    out = np.empty((len(turned), 24, 3, 3))
    for joint in range(24):
        if joint in source:
            out[:, joint] = axes @ turned[:, source[joint]] @ own[joint]
        else:
            out[:, joint] = out[:, PARENTS[joint]]
    _share_along_spine(out, source)
    if not recording.bodily:
        _share_with_collars(out)
    hips = (positions[:, source[1]] + positions[:, source[2]]) / 2 @ axes.T
    middle = (figure.joints[1] + figure.joints[2]) / 2 - figure.joints[0]
    root = hips * (figure.leg_length / leg_length(recording, source)) - out[:, 0] @ middle
    return out, root


def _share_along_spine(world: Array, source: dict[int, int]) -> None:
    """Gives joints of the spine that nothing recorded moves their share of the turn between their neighbours."""
    known = [joint for joint in (0, *SPINE) if joint == 0 or joint in source]
    for low, high in pairwise(known):
        between = [joint for joint in SPINE if low < joint < high]
        turn = Rotation.from_matrix(np.swapaxes(world[:, low], -1, -2) @ world[:, high]).as_rotvec()
        for k, joint in enumerate(between, start=1):
            share = k / (len(between) + 1)
            world[:, joint] = world[:, low] @ Rotation.from_rotvec(share * turn).as_matrix()


def _share_with_collars(world: Array) -> None:
    """Gives the collars their share of the arms' rotations; the arms keep their directions.

    Recorded shoulders hardly move the collar, and skin that follows the arm joint alone makes square shoulders.
    """
    for side in (0, 1):
        collar, arm = world[:, COLLARS[side]], world[:, SHOULDERS[side]]
        local = Rotation.from_matrix(np.swapaxes(collar, -1, -2) @ arm).as_rotvec()
        world[:, COLLARS[side]] = collar @ Rotation.from_rotvec(COLLAR_SHARE * local).as_matrix()


def local_rotations(world: Array) -> Array:
    """Rotations of the joints relative to their parents, shape [T, 24, 3, 3], from world rotations."""
    local = world.copy()
    local[:, 1:] = np.swapaxes(world[:, PARENTS[1:]], -1, -2) @ world[:, 1:]
    return local


def joint_positions(figure: Figure, world: Array, root: Array) -> Array:
    """Positions of the joints [m], shape [T, 24, 3], from world rotations and the path of the root joint."""
    out = np.empty((len(root), 24, 3))
    out[:, 0] = root
    for joint in range(1, 24):
        parent = int(PARENTS[joint])
        out[:, joint] = out[:, parent] + world[:, parent] @ (figure.joints[joint] - figure.joints[parent])
    return out


def axes_of(recording: Recording, name: str) -> Array:
    """Turns a recording's axes into x left, y up, z forward, shape [3, 3].

    Args:
        recording: A recording that has all joints of a person.
        name: Name of the motion, for errors.

    Raises:
        DataError: The skeleton has no legs or no trunk.
    """
    if recording.bodily:
        return np.eye(3)
    rest, source = recording.rest(), match(recording.names)
    axes = _axes_at_rest(rest, source)
    if axes is None:
        axes = _axes_in_motion(recording.forward()[1], source)
    whole = leg_length(recording, source)
    for start, end in BONES.items():
        if not _length(rest, source, (start, end)) > SHORTEST_BONE * whole:
            between = f"{JOINT_NAMES[start]} and {JOINT_NAMES[end]}"
            raise DataError(f"{name}: {between} are in one place; give a skeleton with offsets between its joints")
    if axes is None:
        raise DataError(f"{name}: the skeleton has no trunk, or no hips; give one with offsets between its joints")
    return axes


def leg_length(recording: Recording, source: dict[int, int]) -> float:
    """Thigh and shank of the recorded skeleton together, mean of both sides [its units]."""
    rest = recording.rest()
    return float(np.mean([_length(rest, source, (hip, hip + 3, hip + 6)) for hip in (1, 2)]))


def _axes_at_rest(rest: Array, source: dict[int, int]) -> Array | None:
    """Turns a recording's axes into x left, y up, z forward: signed axes, nearest to its rest pose, shape [3, 3].

    None if the rest pose is no standing person's: legs beside the trunk, arms on the wrong side, feet backwards.
    """
    at = {joint: rest[index] for joint, index in source.items()}
    hips = (at[1] + at[2]) / 2
    up, across = _nearest_axis(at[15] - hips), _nearest_axis(at[1] - at[2])
    forward = np.cross(across, up)
    legs = (at[7] + at[8]) / 2 - hips
    stands = forward.any() and -(legs @ up) > UPRIGHT * np.linalg.norm(legs) > 0
    arms = (at[16] - at[17]) @ across > 0
    feet = all((at[FEET[foot]] - at[foot]) @ forward >= 0 for foot in FEET if FEET[foot] in at)
    return np.stack([across, up, forward]) if stands and arms and feet else None


def _axes_in_motion(positions: Array, source: dict[int, int]) -> Array | None:
    """The same from where the joints are over time [T, J, 3]; None if there is no trunk."""
    at = {joint: positions[:, index] for joint, index in source.items()}
    trunk, hips = at[15] - (at[1] + at[2]) / 2, at[1][0] - at[2][0]
    lengths = np.linalg.norm(trunk, axis=-1, keepdims=True)
    if not lengths.min() > 0 or not np.linalg.norm(hips) > 0:
        return None
    mean = (trunk / lengths).mean(axis=0)
    up = np.array([0.0, 1.0, 0.0]) if mean[1] > LYING else _nearest_axis(mean)
    across = _nearest_axis(hips - (hips @ up) * up)
    return np.stack([across, up, np.cross(across, up)]) if across.any() else None


def _nearest_axis(vector: Array) -> Array:
    """The signed coordinate axis nearest to a vector, shape [3]."""
    axis = np.zeros(3)
    largest = int(np.abs(vector).argmax())
    axis[largest] = np.sign(vector[largest])
    return axis


def _difference(joints: Array, rest: dict[int, Array], joint: int) -> Array:
    """Rotation from the body's T-pose to the recording's rest pose at one joint, shape [3, 3]."""
    if joint in WRISTS:  # hands go on from the forearm in every rest pose
        joint = int(PARENTS[joint])
    if joint in BONES:
        ours, theirs = joints[BONES[joint]] - joints[joint], rest[BONES[joint]] - rest[joint]
    elif joint in FEET and FEET[joint] in rest:
        flat = np.array([1.0, 0.0, 1.0])
        ours = flat * (joints[FEET[joint]] - joints[joint])
        theirs = flat * (rest[FEET[joint]] - rest[joint])
    else:
        return np.eye(3)
    if np.linalg.norm(theirs) < 1e-9:
        return np.eye(3)
    a, b = unit(ours), unit(theirs)
    axis, cosine = np.cross(a, b), float(a @ b)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-9:
        return np.eye(3)
    return np.asarray(Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine)).as_matrix())


def _length(rest: Array, source: dict[int, int], chain: tuple[int, ...]) -> float:
    """Length of a chain of bones of the recording [its units]."""
    points = rest[[source[joint] for joint in chain]]
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
