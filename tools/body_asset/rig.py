"""Maps the CMU MotionBuilder rig of the source to SMPL's 24 joints."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.body.skeleton import JOINT_NAMES
from tools.body_asset.source import Source

BONES: dict[str, tuple[str, ...]] = {
    "pelvis": ("Hips", "LHipJoint", "RHipJoint"),
    "left_hip": ("LeftUpLeg",),
    "right_hip": ("RightUpLeg",),
    "spine1": ("LowerBack",),
    "left_knee": ("LeftLeg",),
    "right_knee": ("RightLeg",),
    "spine2": ("Spine",),
    "left_ankle": ("LeftFoot",),
    "right_ankle": ("RightFoot",),
    "spine3": ("Spine1",),
    "left_foot": ("LeftToeBase",),
    "right_foot": ("RightToeBase",),
    "neck": ("Neck",),
    "left_collar": ("LeftShoulder",),
    "right_collar": ("RightShoulder",),
    "head": ("Neck1", "Head"),
    "left_shoulder": ("LeftArm",),
    "right_shoulder": ("RightArm",),
    "left_elbow": ("LeftForeArm",),
    "right_elbow": ("RightForeArm",),
    "left_wrist": ("LeftHand", "LThumb"),
    "right_wrist": ("RightHand", "RThumb"),
    "left_hand": ("LeftFingerBase", "LeftHandFinger1", "LeftHandIndex1"),
    "right_hand": ("RightFingerBase", "RightHandFinger1", "RightHandIndex1"),
}
"""Bones whose weights make up each joint; the first one's head is the joint's position.

The rig and its weights disagree on one name: LeftHandFinger1 and LeftHandIndex1 are the same bone.
"""


def joint_regressor(source: Source) -> sp.csr_array:
    """Joint positions as means of the joint cubes' corners, shape [24, N]."""
    groups = source.base_mesh().groups
    rig = source.rig()
    matrix = sp.lil_array((len(JOINT_NAMES), len(source.base_mesh().vertices)))
    for k, joint in enumerate(JOINT_NAMES):
        head = rig[BONES[joint][0]]["head"]
        match head["strategy"]:
            case "CUBE":
                corners = np.unique(groups[head["cube_name"]])
            case "VERTEX":
                corners = np.array([head["vertex_index"]])
            case _:
                corners = np.array(head["vertex_indices"])
        matrix[[k], corners] = 1.0 / len(corners)
    return matrix.tocsr()


def skin_weights(source: Source) -> NDArray[np.float64]:
    """Skinning weights of every vertex of the base mesh, rows sum to 1, shape [N, 24].

    Raises:
        ValueError: A bone belongs to no joint, or a vertex of the base mesh to no bone.
    """
    joint_of = {bone: k for k, joint in enumerate(JOINT_NAMES) for bone in BONES[joint]}
    weights = np.zeros((len(source.base_mesh().vertices), len(JOINT_NAMES)))
    for bone, entries in source.rig_weights().items():
        if bone not in joint_of:
            raise ValueError(f"bone {bone!r} of the rig's weights belongs to no joint")
        table = np.array(entries, dtype=np.float64).reshape(-1, 2)
        np.add.at(weights[:, joint_of[bone]], table[:, 0].astype(np.int64), table[:, 1])
    total = weights.sum(axis=1, keepdims=True)
    if not (total > 0).all():
        raise ValueError(f"{int((total <= 0).sum())} vertices have no skinning weight")
    return weights / total
