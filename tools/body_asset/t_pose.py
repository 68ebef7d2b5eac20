"""Re-rests MakeHuman's A-pose to SMPL's T-pose, exactly linearly in the vertices."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from model.body.skeleton import JOINT_NAMES, PARENTS

CLAVICLE_LIFT = 10.0
"""How far the collar bones rise when the arms rise from the A-pose to the T-pose [deg].

Anatomy shares the elevation between the clavicle and the arm; left to the shoulder joint alone, linear blend skinning
would fold the deltoid.
"""

LEG_SLOPE = 2.0
"""How far the line from hip to ankle leans outwards in the T-pose [deg], as in SMPL's template.

The source stands with its legs at 5.4 degrees; motions fitted to SMPL would make it straddle.
"""

_LIMBS = {
    "left_shoulder": ("left_elbow", (1.0, 0.0, 0.0)),
    "right_shoulder": ("right_elbow", (-1.0, 0.0, 0.0)),
    "left_elbow": ("left_wrist", (1.0, 0.0, 0.0)),
    "right_elbow": ("right_wrist", (-1.0, 0.0, 0.0)),
    "left_wrist": ("left_hand", (1.0, 0.0, 0.0)),
    "right_wrist": ("right_hand", (-1.0, 0.0, 0.0)),
}
"""Joints whose bone, towards the child named, must point along the direction given."""


@dataclass(frozen=True, eq=False)
class Rerest:
    """The linear map from the source's rest pose to the T-pose.

    x' = sum_k w_k (Q_k (x - J_k) + J'_k), with fixed rotations Q_k and with J and J' linear in the vertices: it applies
    to a template and to each shape direction alike.
    """

    rotations: NDArray[np.float64]
    """Global rotation of each joint Q, shape [24, 3, 3]."""
    weights: NDArray[np.float64]
    """Skinning weights, shape [N, 24]."""
    regressor: sp.csr_array
    """Joint regressor in the source's rest pose, shape [24, N]."""

    def joints(self, field: NDArray[np.float64]) -> NDArray[np.float64]:
        """Joints in the T-pose [m], shape [24, 3], of a vertex field [N, 3]."""
        before = self.regressor @ field
        after = before.copy()
        for k, parent in enumerate(PARENTS):
            if parent >= 0:
                after[k] = after[parent] + self.rotations[parent] @ (before[k] - before[parent])
        return after

    def vertices(self, field: NDArray[np.float64]) -> NDArray[np.float64]:
        """Vertices in the T-pose [m], shape [N, 3], of a vertex field [N, 3]."""
        before = self.regressor @ field
        shift = self.joints(field) - np.einsum("kij,kj->ki", self.rotations, before)
        blended = (self.weights @ self.rotations.reshape(-1, 9)).reshape(-1, 3, 3)
        return np.einsum("vij,vj->vi", blended, field) + self.weights @ shift


def rerest_to_t_pose(mean: NDArray[np.float64], weights: NDArray[np.float64], regressor: sp.csr_array) -> Rerest:
    """Finds the rotations that take the mean body to the T-pose.

    Each arm bone turns by the shortest way onto the x axis, so that the palms face down. The legs close in the frontal
    plane to `LEG_SLOPE`; the feet stay flat on the ground.

    Args:
        mean: Mean body in the source's rest pose [m], shape [N, 3].
        weights: Skinning weights, shape [N, 24].
        regressor: Joint regressor, shape [24, N].

    Returns:
        The linear map.
    """
    joints = regressor @ mean
    index = {name: k for k, name in enumerate(JOINT_NAMES)}
    rotations = np.tile(np.eye(3), (len(JOINT_NAMES), 1, 1))
    for k, name in enumerate(JOINT_NAMES):
        side = 1.0 if name.startswith("left") else -1.0
        if name.endswith("_collar"):
            rotations[k] = _turn_about_z(side * CLAVICLE_LIFT)
        elif name.endswith("_hip"):
            leg = joints[index[name.replace("hip", "ankle")]] - joints[k]
            slope = np.degrees(np.arctan2(side * leg[0], -leg[1]))
            rotations[k] = _turn_about_z(side * (LEG_SLOPE - slope))
        elif name.endswith(("_ankle", "_foot")):
            rotations[k] = np.eye(3)
        elif name in _LIMBS:
            child, direction = _LIMBS[name]
            rotations[k] = _shortest_turn(joints[index[child]] - joints[k], np.array(direction))
        elif PARENTS[k] >= 0:
            rotations[k] = rotations[PARENTS[k]]
    return Rerest(rotations, weights, regressor)


def _turn_about_z(degrees: float) -> NDArray[np.float64]:
    """The rotation [3, 3] about the model's z axis, towards the left arm's rising for a positive angle."""
    return Rotation.from_rotvec([0.0, 0.0, degrees], degrees=True).as_matrix()


def _shortest_turn(source: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation [3, 3] by the smallest angle that takes one direction to another (they are not opposite)."""
    a, b = source / np.linalg.norm(source), target / np.linalg.norm(target)
    axis = np.cross(a, b)
    sine = np.linalg.norm(axis)
    if sine < 1e-12:
        return np.eye(3)
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, a @ b)).as_matrix()
