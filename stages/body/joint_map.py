"""Which joint of a recorded skeleton moves which joint of the body, by the names of CMU's MotionBuilder files."""

from collections.abc import Sequence

JOINT_OF = {
    "Hips": 0,
    "LeftUpLeg": 1,
    "RightUpLeg": 2,
    "LowerBack": 3,
    "LeftLeg": 4,
    "RightLeg": 5,
    "Spine": 6,
    "LeftFoot": 7,
    "RightFoot": 8,
    "Spine1": 9,
    "LeftToeBase": 10,
    "RightToeBase": 11,
    "Neck": 12,
    "LeftShoulder": 13,
    "RightShoulder": 14,
    "Head": 15,
    "LeftArm": 16,
    "RightArm": 17,
    "LeftForeArm": 18,
    "RightForeArm": 19,
    "LeftHand": 20,
    "RightHand": 21,
}
"""Name of the recorded joint -> joint of the body. Fingers and thumbs are noise and are left out."""

NEEDED: tuple[str, ...] = tuple(name for name, joint in JOINT_OF.items() if joint not in (3, 6, 9, 10, 11, 13, 14))
"""Without these a motion cannot be put on a body; the others may be missing and then follow their parent."""

BONES = {1: 4, 2: 5, 4: 7, 5: 8, 16: 18, 17: 19, 18: 20, 19: 21}
"""Joints of the limbs whose bone is aligned, and the joint at the bone's other end."""

FEET = {7: 10, 8: 11}
"""Ankles and the ball of the same foot: feet are aligned in heading only, since both skeletons stand on flat soles."""


def match(names: Sequence[str]) -> dict[int, int]:
    """Joint of the body -> index of the recorded joint that moves it.

    Args:
        names: Names of the recorded joints; a prefix such as `mixamorig:` is ignored.
    """
    plain = {name.rsplit(":", 1)[-1]: i for i, name in reversed(list(enumerate(names)))}
    return {joint: plain[name] for name, joint in JOINT_OF.items() if name in plain}


def missing(names: Sequence[str]) -> list[str]:
    """Names that a motion needs and that are not there."""
    plain = {name.rsplit(":", 1)[-1] for name in names}
    return [name for name in NEEDED if name not in plain]
