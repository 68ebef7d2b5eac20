"""A recorded skeleton as a solid that can be drawn beside the body: a long octahedron for each bone."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stages.body.figure import Figure
from stages.body.joint_map import match
from stages.body.motion import Motion
from stages.body.recording import Recording
from stages.body.retarget import axes_of, leg_length
from stages.body.turns import WORLD_FROM_MODEL, unit

Array = NDArray[np.float64]

THICKNESS = 0.02
"""Half the thickness of a bone [m]."""

WAIST = 0.2
"""Where along a bone it is thickest [1]."""

SHORTEST = 0.02
"""Bones shorter than this are not drawn [m]."""

FACES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [5, 2, 1], [5, 3, 2], [5, 4, 3], [5, 1, 4]], np.int32)
"""Triangles of one bone: its start, four corners round it, its end."""


def beside(recording: Recording, figure: Figure, motion: Motion, name: str) -> tuple[Array, NDArray[np.int64]]:
    """Where the recorded joints are, as large as the person and where the person is.

    Args:
        recording: The recording at 30 fps.
        figure: The person.
        motion: The motion on the person.
        name: Name of the motion, for errors.

    Returns:
        Positions of the joints and of the ends of the last bones in the world, z up [m], shape [T, N, 3], and the
        parent of each, shape [N].
    """
    scale = figure.leg_length / leg_length(recording, match(recording.names))
    rotations, positions = recording.forward()
    last = [recording.names.index(joint) for joint in recording.tips]
    ends = [positions[:, j] + rotations[:, j] @ tip for j, tip in zip(last, recording.tips.values(), strict=True)]
    points = np.concatenate([positions, *(end[:, None] for end in ends)], axis=1)
    world = points @ axes_of(recording, name).T @ WORLD_FROM_MODEL.T * scale
    # The root joint lies elsewhere in every skeleton: one shift for the whole motion brings the hips together.
    source = match(recording.names)
    middle = (figure.joints[1] + figure.joints[2]) / 2 - figure.joints[0]
    ours = motion.trans + Rotation.from_rotvec(motion.pose[:, 0]).apply(middle)
    away = ours - (world[:, source[1]] + world[:, source[2]]) / 2
    return np.asarray(world + np.median(away, axis=0)), np.concatenate([recording.parents, last]).astype(np.int64)


def bones(positions: Array, parents: NDArray[np.int64]) -> tuple[Array, NDArray[np.int32]]:
    """Solids for the bones of a skeleton.

    Args:
        positions: Joints in the world [m], shape [T, J, 3].
        parents: Parent of each joint, -1 for the root, shape [J].

    Returns:
        Vertices [m], shape [T, 6 B, 3], and triangles, shape [8 B, 3].
    """
    solids = []
    for joint, parent in enumerate(parents):
        if parent < 0:
            continue
        start, end = positions[:, parent], positions[:, joint]
        along = end - start
        if np.median(np.linalg.norm(along, axis=-1)) < SHORTEST:
            continue
        lengths = np.linalg.norm(along, axis=-1, keepdims=True)
        direction = along / np.maximum(lengths, 1e-9)
        least = np.eye(3)[np.abs(direction).argmin(axis=-1)]
        side = unit(np.cross(direction, least))
        other = np.cross(direction, side)
        waist = start + WAIST * along
        thick = np.minimum(THICKNESS, 0.25 * lengths)
        ring = [waist + thick * corner for corner in (side, other, -side, -other)]
        solids.append(np.stack([start, *ring, end], axis=1))
    if not solids:
        return np.zeros((len(positions), 0, 3)), np.zeros((0, 3), np.int32)
    faces = np.concatenate([FACES + 6 * b for b in range(len(solids))]).astype(np.int32)
    return np.concatenate(solids, axis=1), faces
