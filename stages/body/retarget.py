"""Puts a recorded motion on a person: the same directions of the limbs, paths scaled by the length of the legs."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from model.body import PARENTS
from stages.body.bvh import Recording
from stages.body.figure import Figure
from stages.body.joint_map import BONES, FEET, match, missing
from stages.body.posture import COLLAR_SHARE, COLLARS, SHOULDERS
from stages.body.turns import unit
from stages.spec import DataError

Array = NDArray[np.float64]


def retarget(recording: Recording, figure: Figure, name: str) -> tuple[Array, Array]:
    """The motion on the person's own skeleton, before the feet are put on the ground.

    A recorded joint with world rotation G moves the body's joint by R = A G A^T D, where A turns the recording's axes
    into the model's and D takes the bone of the body's T-pose to the bone of the recording's rest pose: R times the
    body's bone then has the direction of the recorded bone.

    Args:
        recording: The motion, at the wanted rate.
        figure: The person.
        name: Name of the motion, for errors.

    Returns:
        World rotations of the joints in the y-up frame of motion, shape [T, 24, 3, 3], and the path of the root joint
        [m], shape [T, 3].

    Raises:
        DataError: Joints are missing, or the skeleton has no legs or stands on no axis.
    """
    lost = missing(recording.names)
    if lost:
        raise DataError(f"{name}: no joint named {lost[0]!r} ({len(lost)} missing); rename the joints as CMU's are")
    source = match(recording.names)
    rest = recording.rest()
    axes = _axes(rest, source, name)
    turned, positions = recording.forward()
    rotations = axes @ turned @ axes.T
    rest = rest @ axes.T
    out = np.empty((len(turned), 24, 3, 3))
    for joint in range(24):
        if joint in source:
            difference = _difference(figure.joints, rest, source, joint)
            out[:, joint] = rotations[:, source[joint]] @ difference
        else:
            out[:, joint] = out[:, PARENTS[joint]]
    _share_with_collars(out)
    legs = np.mean([_length(rest, source, (hip, hip + 3, hip + 6)) for hip in (1, 2)])
    if not legs > 0:
        raise DataError(f"{name}: the legs have no length; give a skeleton with offsets")
    hips = (positions[:, source[1]] + positions[:, source[2]]) / 2 @ axes.T
    middle = (figure.joints[1] + figure.joints[2]) / 2 - figure.joints[0]
    root = hips * (figure.leg_length / legs) - out[:, 0] @ middle
    return out, root


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


def _axes(rest: Array, source: dict[int, int], name: str) -> Array:
    """Turns a recording's axes into x left, y up, z forward: signed axes, nearest to its rest pose, shape [3, 3]."""
    up = _nearest_axis(rest[source[15]] - (rest[source[1]] + rest[source[2]]) / 2)
    across = _nearest_axis(rest[source[1]] - rest[source[2]])
    if abs(up @ across) > 0.5 or not (up.any() and across.any()):
        raise DataError(f"{name}: the rest pose does not stand upright; give a skeleton whose head is above its hips")
    return np.stack([across, up, np.cross(across, up)])


def _nearest_axis(vector: Array) -> Array:
    """The signed coordinate axis nearest to a vector, shape [3]."""
    axis = np.zeros(3)
    largest = int(np.abs(vector).argmax())
    axis[largest] = np.sign(vector[largest])
    return axis


def _difference(joints: Array, rest: Array, source: dict[int, int], joint: int) -> Array:
    """Rotation from the body's T-pose to the recording's rest pose at one joint, shape [3, 3]."""
    if joint in BONES:
        ours, theirs = joints[BONES[joint]] - joints[joint], rest[source[BONES[joint]]] - rest[source[joint]]
    elif joint in FEET and FEET[joint] in source:
        flat = np.array([1.0, 0.0, 1.0])
        ours = flat * (joints[FEET[joint]] - joints[joint])
        theirs = flat * (rest[source[FEET[joint]]] - rest[source[joint]])
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
