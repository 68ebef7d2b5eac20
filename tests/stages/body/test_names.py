"""Whose joints are whose: common skeletons by their names, any other by a table in the recipe."""

from pathlib import Path

import numpy as np
import pytest

from model.body import JOINT_NAMES, BodyModel
from stages.body.config import Config
from stages.body.figure import Figure
from stages.body.joint_map import match
from stages.body.readers import read_motion
from stages.body.retarget import retarget
from stages.settings import build
from stages.spec import DataError
from tests.stages.body.skeletons import PERSON, Made, person

MIXAMO = [name for _, name in sorted((j, n) for n, j in {
    "Hips": 0, "LeftUpLeg": 1, "RightUpLeg": 2, "Spine": 3, "LeftLeg": 4, "RightLeg": 5, "Spine1": 6, "LeftFoot": 7,
    "RightFoot": 8, "Spine2": 9, "LeftToeBase": 10, "RightToeBase": 11, "Neck": 12, "LeftShoulder": 13,
    "RightShoulder": 14, "Head": 15, "LeftArm": 16, "RightArm": 17, "LeftForeArm": 18, "RightForeArm": 19,
    "LeftHand": 20, "RightHand": 21,
}.items())]  # fmt: skip
BANDAI = ["Hips", "UpperLeg_L", "UpperLeg_R", "Spine", "LowerLeg_L", "LowerLeg_R", "", "Foot_L", "Foot_R", "Chest",
    "Toes_L", "Toes_R", "Neck", "Shoulder_L", "Shoulder_R", "Head", "UpperArm_L", "UpperArm_R", "LowerArm_L",
    "LowerArm_R", "Hand_L", "Hand_R"]  # fmt: skip
CMU_ASF = ["root", "lfemur", "rfemur", "lowerback", "ltibia", "rtibia", "upperback", "lfoot", "rfoot", "thorax",
    "ltoes", "rtoes", "lowerneck", "lclavicle", "rclavicle", "head", "lhumerus", "rhumerus", "lradius", "rradius",
    "lhand", "rhand"]  # fmt: skip
FILES = {
    "Mixamo": [f"mixamorig:{name}" for name in MIXAMO] + ["mixamorig:LeftHandThumb1"],
    "Mixamo, numbered": [f"mixamorig5:{name}" for name in MIXAMO],
    "Mixamo, underscores": [f"mixamorig_{name}" for name in MIXAMO],
    "LAFAN1": [name.replace("ToeBase", "Toe") for name in MIXAMO],
    "Bandai-Namco": ["joint_Root", *BANDAI],
    "CMU's ASF": [*CMU_ASF, "lwrist", "rwrist", "lthumb", "lfingers", "lhipjoint"],
    "SMPL": list(JOINT_NAMES[:22]),
}


@pytest.mark.parametrize("kind", FILES)
def test_names_of_common_skeletons_are_known(kind: str) -> None:
    names = FILES[kind]
    bare = [name.replace("mixamorig_", "").rsplit(":")[-1] for name in names]
    order = {"Bandai-Namco": BANDAI, "CMU's ASF": CMU_ASF, "SMPL": list(JOINT_NAMES[:22])}.get(kind, MIXAMO)
    if kind == "LAFAN1":
        order = FILES[kind]
    wanted = {joint: bare.index(name) for joint, name in enumerate(order) if name}
    assert match(names) == wanted


def test_cmu_s_spine_is_not_mixamo_s() -> None:
    names = [row[0] for row in PERSON]
    assert match(names)[6] == names.index("Spine") and match(names)[3] == names.index("LowerBack")


def odd(folder: Path) -> Path:
    """A file whose shins are called otherwise."""
    made = person(np.random.default_rng(2).uniform(-20, 20, (3, 24, 3)), np.zeros((3, 3)), 1 / 30)
    path = folder / "odd.bvh"
    path.write_text(made.text().replace("LeftLeg", "Calf_L").replace("RightLeg", "Calf_R"))
    return path


def test_a_table_says_the_rest(tmp_path: Path, woman: tuple[BodyModel, np.ndarray, Figure]) -> None:
    path = odd(tmp_path)
    with pytest.raises(
        DataError, match=r"odd\.bvh: .* left_knee, right_knee; the file also has .*Calf_L.*body\.joints"
    ):
        read_motion(path)
    table = build(Config, {"joints": {"left_knee": "Calf_L", "right_knee": "Calf_R"}}).joints
    named = read_motion(path, joints=table)
    path.write_text(path.read_text().replace("Calf_L", "LeftLeg").replace("Calf_R", "RightLeg"))
    for ours, wanted in zip(
        retarget(named, woman[2], "odd"), retarget(read_motion(path), woman[2], "odd"), strict=True
    ):
        np.testing.assert_array_equal(ours, wanted)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"left_nee": "Calf_L"}, "'left_nee' is no joint of the body; known: pelvis, left_hip"),
        ({"left_knee": "Calf"}, "left_knee = 'Calf', which the file doesn't have; it has Hips"),
        ({"left_knee": "Calf_L", "right_knee": "Calf_L"}, "gives 'Calf_L' to two joints"),
    ],
)
def test_a_wrong_table_is_refused(table: dict[str, str], message: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=message) as caught:
        read_motion(odd(tmp_path), joints=table)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["walk.c3d", "walk.fbx", "walk", "01.asf"])
def test_other_kinds_of_files_are_refused(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("x")
    with pytest.raises(DataError, match=rf"{name}: is no motion file that can be read"):
        read_motion(tmp_path / name)


def test_what_bvh_files_in_the_wild_do_is_read(tmp_path: Path) -> None:
    """Braces on a joint's line, spelling of channels, Windows' line ends, accents, no space after a colon."""
    made: Made = person(np.random.default_rng(4).uniform(-50, 50, (2, 24, 3)), np.ones((2, 3)), 1 / 60)
    plain, wild = tmp_path / "plain.bvh", tmp_path / "wild.bvh"
    plain.write_text(made.text())
    text = made.text().replace("\n\t{\n", " {\n").replace("Zrotation", "ZRotation").replace("Xposition", "XPOSITION")
    text = text.replace("Frames: ", "Frames:").replace("Frame Time: ", "Frame Time:").replace("LThumb", "Pouce_\u00e9")
    wild.write_bytes(text.replace("\n", "\r\n").encode("latin-1"))
    one, other = read_motion(plain), read_motion(wild)
    np.testing.assert_array_equal(one.rotations, other.rotations)
    assert one.frame_time == other.frame_time and "Pouce_\u00e9" in other.names
