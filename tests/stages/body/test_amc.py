"""The reader of ASF and AMC against scalar formulas, by hand and at random."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from model.body import BodyModel
from stages.body.figure import Figure
from stages.body.readers import fingerprint, read_motion
from stages.body.readers.amc import read_amc
from stages.body.retarget import joint_positions, retarget
from stages.spec import DataError
from tests.stages.body.acclaim import Bone, Made, cmu_person

METRE = 0.0254 / 0.45


def save(made: Made, folder: Path, name: str = "01_01", skeleton: str = "01") -> Path:
    """Writes both files; returns the motion's."""
    (folder / f"{skeleton}.asf").write_text(made.asf())
    path = folder / f"{name}.amc"
    path.write_text(made.amc())
    return path


def test_a_thigh_is_lifted_about_its_own_axis(tmp_path: Path) -> None:
    """By -90 degrees about the x axis of a thigh that is splayed by 20 degrees: it points forward, the shin with it."""
    c, s = float(np.cos(np.radians(20))), float(np.sin(np.radians(20)))
    bones = [
        Bone("lhipjoint", "root", (1, 0, 0), 2.0),
        Bone("lfemur", "lhipjoint", (s, -c, 0), 7.0, (0, 0, 20), dof=("rx", "ry", "rz")),
        Bone("ltibia", "lfemur", (s, -c, 0), 6.0, (0, 0, 20), dof=("rx",)),
        Bone("lfoot", "ltibia", (0, 0, 1), 2.0, (0, 0, 20)),
    ]
    frames = [
        {"root": [1.0, 17.0, 3.0, 0.0, 0.0, 0.0], "lfemur": [-90.0, 0.0, 0.0], "ltibia": [0.0]},
        {"root": [1.0, 17.0, 3.0, 0.0, 90.0, 0.0], "lfemur": [-90.0, 0.0, 0.0], "ltibia": [90.0]},
    ]
    recording = read_amc(save(Made(bones, frames), tmp_path), 120.0)
    at = recording.forward()[1] / METRE
    names = recording.names
    np.testing.assert_allclose(at[0, names.index("lfemur")], [3, 17, 3], atol=1e-9)
    np.testing.assert_allclose(at[0, names.index("ltibia")], [3, 17, 10], atol=1e-9)
    np.testing.assert_allclose(at[0, names.index("lfoot")], [3, 17, 16], atol=1e-9)
    # The person has turned to the left, x to -z and z to x; the shin hangs down again, splayed.
    np.testing.assert_allclose(at[1, names.index("ltibia")], [8, 17, 1], atol=1e-9)
    np.testing.assert_allclose(at[1, names.index("lfoot")], [8, 17 - 6 * c, 1 - 6 * s], atol=1e-9)
    assert recording.frame_time == pytest.approx(1 / 120)


@st.composite
def skeletons(draw: st.DrawFn) -> Made:
    """Any tree of up to seven bones, any axes, any degrees of freedom in any order, degrees or radians."""
    count, frames = draw(st.integers(1, 7)), draw(st.integers(1, 3))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    names = ["root", *(f"bone{i}" for i in range(count))]
    bones = []
    for i in range(count):
        turns = draw(st.permutations(["rx", "ry", "rz"]))[: draw(st.integers(0, 3))]
        bones.append(
            Bone(
                names[i + 1],
                names[draw(st.integers(0, i))],
                tuple(float(v) for v in rng.normal(size=3)),
                float(rng.uniform(0.1, 9)),
                tuple(float(v) for v in rng.uniform(-180, 180, 3)),
                "".join(draw(st.permutations("XYZ"))),
                tuple(turns),
            )
        )
    order = tuple(draw(st.permutations(["TX", "TY", "TZ", "RX", "RY", "RZ"])))
    values = [
        {"root": list(rng.uniform(-50, 50, 6)), **{b.name: list(rng.uniform(-360, 360, len(b.dof))) for b in bones}}
        for _ in range(frames)
    ]
    values = [{k: [float(x) for x in v] for k, v in frame.items() if v} for frame in values]
    unit, position = draw(st.sampled_from([0.45, 1.0, 2.54])), tuple(float(v) for v in rng.normal(size=3))
    return Made(bones, values, unit, draw(st.booleans()), order, position)


@given(made=skeletons())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_random_skeletons_come_back(made: Made, tmp_path: Path) -> None:
    recording = read_amc(save(made, tmp_path), 60.0)
    assert sorted(recording.names) == sorted(["root", *(bone.name for bone in made.bones)])
    at = recording.forward()[1]
    for frame, wanted in zip(at, made.starts(), strict=True):
        for name, place in wanted.items():
            np.testing.assert_allclose(frame[recording.names.index(name)], place, atol=1e-8)


def test_all_of_cmu_s_bones_move_the_body(tmp_path: Path, woman: tuple[BodyModel, np.ndarray, Figure]) -> None:
    """Limbs of the body point where the bones of the file do, by the scalar formulas."""
    figure = woman[2]
    made = cmu_person(9, np.random.default_rng(3), swing=40.0)
    recording = read_motion(save(made, tmp_path))
    ours = joint_positions(figure, *retarget(recording, figure, "made"))
    pairs = {
        1: ("femur", 4, "tibia"),
        4: ("tibia", 7, "foot"),
        16: ("humerus", 18, "radius"),
        18: ("radius", 20, "hand"),
    }
    for frame, wanted in zip(ours, made.starts(), strict=True):
        for start, (first, end, second) in pairs.items():
            for side, letter in ((0, "l"), (1, "r")):
                theirs = wanted[f"{letter}{second}"] - wanted[f"{letter}{first}"]
                bone = frame[end + side] - frame[start + side]
                np.testing.assert_allclose(bone / np.linalg.norm(bone), theirs / np.linalg.norm(theirs), atol=1e-6)


def test_the_skeleton_is_looked_for_beside_the_motion(tmp_path: Path) -> None:
    made = cmu_person(2, np.random.default_rng(1))
    path = save(made, tmp_path, "07_12", "07_12")
    assert read_motion(path).names[0] == "root"
    before = fingerprint(path)
    (tmp_path / "07_12.asf").rename(tmp_path / "07.asf")
    assert read_motion(path).names[0] == "root" and fingerprint(path) == before
    (tmp_path / "07.asf").write_text(made.asf().replace("length 7.2", "length 7.3"))
    assert fingerprint(path) != before
    (tmp_path / "07.asf").unlink()
    with pytest.raises(DataError, match=r"07_12\.amc: there is no skeleton 07\.asf or 07_12\.asf beside it"):
        read_motion(path)
