"""DeepMimic's clips: joints at known places, uneven frames, and what is no clip."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from model.body import BodyModel
from stages.body.figure import Figure
from stages.body.readers import read_motion
from stages.body.retarget import joint_positions, retarget
from stages.body.turns import unit
from stages.spec import DataError

IDENTITY = [1.0, 0.0, 0.0, 0.0]
C = float(np.sqrt(0.5))


def frame(duration: float = 1 / 30, root: list[float] | None = None, **turns: list[float]) -> list[float]:
    """One frame: the root at 0.9 m, all joints straight but those given."""
    limbs = [f"{side}_{joint}" for side in ("right", "left") for joint in ("hip", "knee", "ankle", "shoulder", "elbow")]
    order = ["pelvis", "chest", "neck", *limbs]
    out = [duration, *(root or [0.0, 0.9, 0.0])]
    for name in order:
        out += turns.get(name, [0.0] if name.endswith(("knee", "elbow")) else IDENTITY)
    return out


def save(folder: Path, frames: Any) -> Path:
    """Writes a clip."""
    path = folder / "humanoid3d_made.txt"
    path.write_text(json.dumps({"Loop": "none", "Frames": frames}))
    return path


def test_joints_are_at_known_places(tmp_path: Path) -> None:
    """The left thigh is raised forward about z, the knee bent back; the right arm stretched to the side about x."""
    turned = frame(left_hip=[C, 0, 0, C], left_knee=[-np.pi / 2], right_shoulder=[C, -C, 0, 0])
    recording = read_motion(save(tmp_path, [turned, turned]))
    at = dict(zip(recording.names, recording.forward()[1][0], strict=True))
    np.testing.assert_allclose(at["left_knee"], [0.421546, 0.9, -0.084887], atol=1e-9)
    np.testing.assert_allclose(at["left_ankle"], [0.421546, 0.9 - 0.40987, -0.084887], atol=1e-9)
    shoulder = np.array([-0.02405, 0.9 + 0.236151 + 0.2435, 0.18311])
    np.testing.assert_allclose(at["right_shoulder"], shoulder, atol=1e-9)
    np.testing.assert_allclose(at["right_wrist"], shoulder + np.array([0, 0, 0.533735]), atol=1e-9)


def test_hands_hang_from_hanging_arms(tmp_path: Path, woman: tuple[BodyModel, np.ndarray, Figure]) -> None:
    figure = woman[2]
    world, root = retarget(read_motion(save(tmp_path, [frame(), frame()])), figure, "made")
    at = joint_positions(figure, world, root)[0]
    for arm in ([16, 18], [18, 20], [20, 22], [17, 19], [19, 21], [21, 23]):
        assert unit(at[arm[1]] - at[arm[0]])[1] < -0.97
    assert (at[7, 2] < at[10, 2]) and at[1, 0] > at[2, 0] and at[15, 1] > at[12, 1]


def test_the_spine_shares_the_chest_s_turn(tmp_path: Path, woman: tuple[BodyModel, np.ndarray, Figure]) -> None:
    half = np.radians(30)
    world, _ = retarget(
        read_motion(save(tmp_path, [frame(chest=[np.cos(half), 0, 0, -np.sin(half)])])), woman[2], "made"
    )
    lean = [float(np.degrees(np.arccos(world[0, joint, 1, 1]))) for joint in (0, 3, 6, 9)]
    np.testing.assert_allclose(lean, [0, 20, 40, 60], atol=1e-6)


def test_uneven_frames_are_evened(tmp_path: Path) -> None:
    clip = [frame(d, [x, 0.9, 0.0]) for d, x in ((0.1, 0.0), (0.05, 1.0), (0.2, 1.5), (9.0, 3.5))]
    recording = read_motion(save(tmp_path, clip))
    assert recording.frame_time == pytest.approx(0.05)
    np.testing.assert_allclose(recording.translations[:, 0, 0], np.linspace(0, 3.5, 8), atol=1e-9)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is no clip of DeepMimic's"),
        ("walks and runs", "is no clip of DeepMimic's"),
        ("[" * 100000, "is no clip of DeepMimic's"),
        ("[1, 2]", "has no 'Frames'"),
        ('{"Frames": []}', "has no 'Frames'"),
        ('{"Frames": [[1, 2]]}', "frame 0 must have 44 numbers, got 2"),
        ('{"Frames": [3]}', "frame 0 must have 44 numbers, got int"),
        (json.dumps({"Frames": [frame(), [*frame()[:-1], float("nan")]]}), "frame 1 must have finite numbers, got nan"),
        (json.dumps({"Frames": [[*frame()[:-1], 1e300]]}), "must have finite numbers"),
        (json.dumps({"Frames": [[*frame()[:-1], "x"]]}), "must have finite numbers, got 'x'"),
        (json.dumps({"Frames": [[*frame()[:-1], None]]}), "must have finite numbers, got None"),
        (json.dumps({"Frames": [frame(neck=[0.0, 0, 0, 0])]}), "the quaternion of neck must have length 1, got 0"),
        (json.dumps({"Frames": [frame(0.0)] * 3}), "frames must last"),
        (json.dumps({"Frames": [frame(5000.0)] * 3}), "frames must last"),
        ("\xff\xfe{}", "is no clip of DeepMimic's"),
    ],
)
def test_what_is_no_clip_is_refused(content: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.txt"
    path.write_bytes(content.encode("latin-1"))
    with pytest.raises(DataError) as caught:
        read_motion(path)
    assert str(caught.value).startswith("bad.txt") and message in str(caught.value) and "\n" not in str(caught.value)
