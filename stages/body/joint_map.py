"""Which joint of a recorded skeleton moves which joint of the body, by the names that common skeletons use."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from model.body import JOINT_NAMES
from stages.body.recording import Recording
from stages.spec import DataError


def _both_sides(centre: dict[str, int], limbs: dict[str, int], sides: tuple[str, str]) -> dict[str, int]:
    """Names of the trunk and of both limbs; in a limb's name `*` stands for the side, its joint is the left one."""
    out = dict(centre)
    for pattern, joint in limbs.items():
        out[pattern.replace("*", sides[0])] = joint
        out[pattern.replace("*", sides[1])] = joint + 1
    return out


_LIMBS = {
    "*UpLeg": 1,
    "*Leg": 4,
    "*Foot": 7,
    "*ToeBase": 10,
    "*Shoulder": 13,
    "*Arm": 16,
    "*ForeArm": 18,
    "*Hand": 20,
}

CONVENTIONS: dict[str, dict[str, int]] = {
    "SMPL": {name: joint for joint, name in enumerate(JOINT_NAMES)},
    "CMU's MotionBuilder files": _both_sides(
        {"Hips": 0, "LowerBack": 3, "Spine": 6, "Spine1": 9, "Neck": 12, "Head": 15}, _LIMBS, ("Left", "Right")
    ),
    "Mixamo and LAFAN1": _both_sides(
        {"Hips": 0, "Spine": 3, "Spine1": 6, "Spine2": 9, "Neck": 12, "Head": 15},
        {**_LIMBS, "*Toe": 10},
        ("Left", "Right"),
    ),
    "Bandai-Namco": _both_sides(
        {"Hips": 0, "Spine": 3, "Chest": 9, "Neck": 12, "Head": 15},
        {
            "UpperLeg_*": 1,
            "LowerLeg_*": 4,
            "Foot_*": 7,
            "Toes_*": 10,
            "Shoulder_*": 13,
            "UpperArm_*": 16,
            "LowerArm_*": 18,
            "Hand_*": 20,
        },
        ("L", "R"),
    ),
    "CMU's ASF": _both_sides(
        {"root": 0, "lowerback": 3, "upperback": 6, "thorax": 9, "lowerneck": 12, "head": 15},
        {
            "*femur": 1,
            "*tibia": 4,
            "*foot": 7,
            "*toes": 10,
            "*clavicle": 13,
            "*humerus": 16,
            "*radius": 18,
            "*hand": 20,
        },
        ("l", "r"),
    ),
    "Biovision": _both_sides(
        {"Hips": 0, "Chest": 3, "Chest2": 6, "Chest3": 9, "Neck": 12, "Head": 15},
        {
            "*Hip": 1,
            "*Knee": 4,
            "*Ankle": 7,
            "*Toe": 10,
            "*Collar": 13,
            "*Shoulder": 16,
            "*Elbow": 18,
            "*Wrist": 20,
        },
        ("Left", "Right"),
    ),
}
"""Skeletons -> name of the recorded joint -> joint of the body. Fingers and thumbs are noise and are left out."""

NEEDED: tuple[int, ...] = (0, 1, 2, 4, 5, 7, 8, 12, 15, 16, 17, 18, 19, 20, 21)
"""Without these a motion cannot be put on a body; the others may be missing and then follow their parent."""

BONES = {1: 4, 2: 5, 4: 7, 5: 8, 16: 18, 17: 19, 18: 20, 19: 21}
"""Joints of the limbs whose bone is aligned, and the joint at the bone's other end."""

FEET = {7: 10, 8: 11}
"""Ankles and the ball of the same foot: feet are aligned in heading only, since both skeletons stand on flat soles."""


def match(names: Sequence[str]) -> dict[int, int]:
    """Joint of the body -> index of the recorded joint that moves it, in the convention that names the most.

    SMPL's own names hold beside any convention. A prefix such as `mixamorig:` is ignored.

    Args:
        names: Names of the recorded joints.
    """
    plain = {_plain(name): i for i, name in reversed(list(enumerate(names)))}
    best = max(CONVENTIONS.values(), key=lambda known: len({j for name, j in known.items() if name in plain}))
    both = [*best.items(), *CONVENTIONS["SMPL"].items()]
    return {joint: plain[name] for name, joint in both if name in plain}


def missing(names: Sequence[str]) -> list[str]:
    """Joints of the body that a motion needs and that nothing in the file moves, by SMPL's names."""
    found = match(names)
    return [JOINT_NAMES[joint] for joint in NEEDED if joint not in found]


def refuse_missing(names: Sequence[str], where: str) -> None:
    """Checks that a motion can be put on a body.

    Raises:
        DataError: What moves nothing, what the file has, and how to say which is which.
    """
    lost = missing(names)
    if lost:
        spare = [name for i, name in enumerate(names) if i not in match(names).values()]
        has = ", ".join(spare[:30]) + ("..." if len(spare) > 30 else "")
        example = f'{lost[0]} = "{spare[0] if spare else "..."}"'
        raise DataError(
            f"{where}: no joint is known to move {', '.join(lost)}; the file also has {has or 'no other joints'}; say "
            f"in the recipe which is which: [body.joints] {example}"
        )


def rename(recording: Recording, table: Mapping[str, str], where: str) -> Recording:
    """The recording with the joints that a table names called as SMPL calls them.

    Args:
        recording: A recording.
        table: SMPL's name of a joint -> the file's.
        where: Name of the motion, for errors.

    Raises:
        DataError: A name in the table is none of SMPL's, or none of the file's, or stands there twice.
    """
    names = list(recording.names)
    for ours, theirs in table.items():
        if ours not in JOINT_NAMES:
            raise DataError(f"{where}: [body.joints] {ours!r} is no joint of the body; known: {', '.join(JOINT_NAMES)}")
        if list(table.values()).count(theirs) > 1:
            raise DataError(f"{where}: [body.joints] gives {theirs!r} to two joints; each moves one")
        if theirs not in recording.names:
            has = ", ".join(recording.names[:40])
            raise DataError(f"{where}: [body.joints] {ours} = {theirs!r}, which the file doesn't have; it has {has}")
        names[recording.names.index(theirs)] = ours
    tips = {names[recording.names.index(name)]: tip for name, tip in recording.tips.items()}
    return replace(recording, names=tuple(names), tips=tips)


def _plain(name: str) -> str:
    """A joint's name without the prefix that an exporter put before it."""
    bare = name.rsplit(":", 1)[-1]
    return bare.removeprefix("mixamorig_")
