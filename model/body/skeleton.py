"""The kinematic tree of SMPL: names, parents and the slightly opened rest pose."""

import numpy as np

JOINT_NAMES: tuple[str, ...] = (
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_hand",
    "right_hand",
)
"""The 24 joints of SMPL in SMPL's order; left and right are the person's own."""

PARENTS = np.array([-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21], dtype=np.int32)
"""Parent of each joint, -1 for the root; a parent always comes before its children."""
PARENTS.setflags(write=False)

LEG_OPENING = 0.15
"""Rotation of each hip about the model's z axis in the rest pose [rad] (CLOTH3D, section 3)."""

REST_POSE = np.zeros((24, 3))
"""The pose that garments are made in, axis-angle [rad], shape [24, 3].

The root turns the y-up model to the z-up world, so that the person stands facing -y; the legs are opened by
`LEG_OPENING` each, so that the thighs of a fat body and the cloth between them do not touch.
"""
REST_POSE[0, 0] = np.pi / 2
REST_POSE[1, 2] = LEG_OPENING
REST_POSE[2, 2] = -LEG_OPENING
REST_POSE.setflags(write=False)
