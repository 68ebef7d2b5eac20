"""SMPL poses in .npz files: AMASS, SURREAL and plain, against the body's own forward kinematics."""

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model.body import PARENTS, BodyModel, load_free_body
from model.body.skinning import joint_positions
from stages.body.clips import perform
from stages.body.figure import Figure
from stages.body.readers import read_motion
from stages.body.readers.survey import motions_in
from stages.body.sequence import prepared, put_on
from stages.body.turns import WORLD_FROM_MODEL
from stages.spec import DataError

Person = tuple[BodyModel, np.ndarray, Figure]

RNG = np.random.default_rng(7)
POSE = RNG.normal(size=(5, 24, 3)) * 0.4
POSE[:, 0] = [np.pi / 2, 0.1, 0.05]
TRANS = RNG.normal(size=(5, 3))


def smplh(pose: np.ndarray) -> np.ndarray:
    """[F, 156] of [F, 24, 3]: fingers instead of hands, bent at random."""
    fingers = np.random.default_rng(1).normal(size=(len(pose), 30, 3))
    return np.concatenate([pose[:, :22], fingers], axis=1).reshape(len(pose), -1)


WAYS: dict[str, tuple[dict[str, Any], str, float]] = {
    "AMASS": ({"poses": smplh(POSE), "trans": TRANS, "mocap_framerate": 120.0, "gender": "male"}, "", 120),
    "AMASS, bytes": ({"poses": smplh(POSE), "trans": TRANS, "mocap_frame_rate": 60, "gender": b"male"}, "", 60),
    "SMPL-X": ({"poses": np.hstack([smplh(POSE), np.ones((5, 9))]), "trans": TRANS, "gender": "male"}, "", 30),
    "SMPL-X in parts": (
        {"root_orient": POSE[:, 0], "pose_body": POSE[:, 1:22].reshape(5, 63), "trans": TRANS, "gender": "male"},
        "",
        30,
    ),
    "SURREAL": ({"pose_01_01": POSE.reshape(5, 72), "trans_01_01": TRANS, "gender": "male"}, "", 30),
    "one of SURREAL's": (
        {"pose_a": np.zeros((2, 72)), "trans_a": np.zeros((2, 3)), "pose_b": POSE.reshape(5, 72), "trans_b": TRANS}
        | {"gender": "male"},
        ":b",
        30,
    ),
    "plain": ({"poses": POSE, "trans": TRANS.astype(np.float32), "fps": 24, "gender": "male"}, "", 24),
    "22 joints": ({"pose": POSE[:, :22], "trans": TRANS, "gender": "Male"}, "", 30),
}


@pytest.mark.parametrize("way", WAYS)
def test_joints_are_where_the_model_puts_them(way: str, tmp_path: Path) -> None:
    arrays, inside, fps = WAYS[way]
    np.savez(tmp_path / "motion.npz", **arrays)
    recording = read_motion(f"{tmp_path}/motion.npz{inside}", rate=30.0)
    joints = load_free_body("male").joint_template
    wanted = joint_positions(joints, PARENTS, POSE, TRANS) @ WORLD_FROM_MODEL
    np.testing.assert_allclose(recording.forward()[1][:, :22], wanted[:, :22], atol=1e-6)
    assert recording.frame_time == pytest.approx(1 / fps)


@pytest.mark.parametrize("up", ["z", "y", "-y"])
def test_a_motion_of_this_body_comes_back(up: str, woman: Person, tmp_path: Path) -> None:
    """The embedded walk, written as AMASS does, is the embedded walk, whichever axis is up in the file."""
    _, _, figure = woman
    walk = perform(figure, "walk")
    turn = {"z": np.eye(3), "y": WORLD_FROM_MODEL.T, "-y": np.diag([1, -1, -1]) @ WORLD_FROM_MODEL.T}[up]
    pose = walk.pose.copy()
    pose[:, 0] = (Rotation.from_matrix(turn) * Rotation.from_rotvec(pose[:, 0])).as_rotvec()
    trans = (walk.trans + np.array([0.3, -0.2, 0.7])) @ turn.T
    np.savez(tmp_path / "walk.npz", poses=smplh(pose), trans=trans, mocap_framerate=30.0, gender="female")
    back = put_on(figure, prepared(read_motion(tmp_path / "walk.npz"), "walk")[0], "walk")
    turned = Rotation.from_rotvec(back.pose[:, :22].reshape(-1, 3)).inv()
    off = (turned * Rotation.from_rotvec(walk.pose[:, :22].reshape(-1, 3))).magnitude().reshape(-1, 22)
    legs = [1, 2, 4, 5, 7, 8, 10, 11]
    assert np.degrees(np.delete(off, legs, axis=1)).max() < 1e-4, "the trunk and the arms are as they were"
    assert np.degrees(off[:, legs]).mean(axis=0).max() < 3.5, "feet are made to stand, and the legs follow"
    path = back.trans - walk.trans
    assert np.abs(path[:, 2]).max() < 0.02, "the ground is found"
    assert np.abs(path[:, :2] - path[0, :2]).max() < 1e-6
    assert (back.planted == walk.planted).mean() > 0.85


def test_the_motions_of_a_file_are_listed(tmp_path: Path) -> None:
    np.savez(tmp_path / "many.npz", **WAYS["one of SURREAL's"][0])
    np.savez(tmp_path / "one.npz", **WAYS["plain"][0])
    np.savez(tmp_path / "none.npz", betas=np.zeros(10))
    listed = [Path(name).name for file in ("many", "one", "none") for name in motions_in(tmp_path / f"{file}.npz")]
    assert listed == ["many.npz:a", "many.npz:b", "one.npz"]


def _with(**changed: Any) -> dict[str, Any]:
    return {"poses": smplh(POSE), "trans": TRANS, "mocap_framerate": 120.0} | changed


def _at(array: np.ndarray, value: float) -> np.ndarray:
    out = array.copy()
    out[3, 2] = value
    return out


ARRAYS: dict[str, tuple[dict[str, Any], str]] = {
    "no arrays": ({}, "has no array 'pose'"),
    "no poses": ({"trans": TRANS}, "has no array 'pose'"),
    "no trans": ({"poses": smplh(POSE)}, "has no array 'trans'"),
    "pickled poses": (_with(poses=np.array([{"a": 1}, None], dtype=object)), "pickled objects"),
    "pickled trans": (_with(trans=np.array([[1, 2, None]], dtype=object)), "pickled objects"),
    "words": (_with(poses=np.full((5, 156), "a")), "must hold numbers"),
    "complex": (_with(trans=TRANS.astype(complex)), "must hold numbers"),
    "nan": (_with(poses=_at(smplh(POSE), np.nan)), "poses must be finite and within .* got nan at \\[3, 2\\]"),
    "infinity": (_with(trans=_at(TRANS, np.inf)), "trans must be finite"),
    "huge": (_with(trans=_at(TRANS, 1e30)), "trans must be finite and within"),
    "degrees": (_with(poses=_at(smplh(POSE), 360.0)), "rotation vectors in radians"),
    "zero frames": (_with(poses=np.zeros((0, 156)), trans=np.zeros((0, 3))), "0 frames"),
    "other columns": (_with(poses=np.zeros((5, 100))), r"156 \(SMPL-H\), 165 \(SMPL-X\) numbers a frame, got shape"),
    "one axis": (_with(poses=np.zeros(156)), "numbers a frame"),
    "four axes": (_with(poses=np.zeros((5, 24, 3, 1))), "numbers a frame"),
    "quaternions": (_with(poses=np.zeros((5, 24, 4))), "numbers a frame"),
    "a scalar": (_with(poses=np.float64(3)), "numbers a frame"),
    "another length": (_with(trans=np.zeros((6, 3))), r"trans must have shape \[5, 3\] as poses does, got \[6, 3\]"),
    "flat trans": (_with(trans=np.zeros((5, 2))), "trans must have shape"),
    "parts that disagree": (
        {"root_orient": np.zeros((4, 3)), "pose_body": np.zeros((5, 63)), "trans": TRANS},
        "root_orient and pose_body must be",
    ),
    "rate zero": (_with(mocap_framerate=0.0), "mocap_framerate must be from 1"),
    "rate nan": (_with(mocap_framerate=np.nan), "mocap_framerate must be finite"),
    "many rates": (_with(mocap_framerate=np.array([30.0, 60.0])), "mocap_framerate must be from 1"),
    "rate in words": (_with(mocap_framerate="fast"), "must hold numbers"),
    "many sequences": (WAYS["one of SURREAL's"][0], "holds 2 sequences .*name one, such as bad.npz:a"),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_arrays_that_are_no_motion_are_refused(name: str, tmp_path: Path) -> None:
    arrays, wanted = ARRAYS[name]
    np.savez(tmp_path / "bad.npz", **arrays)
    with pytest.raises(DataError, match=wanted) as caught:
        read_motion(tmp_path / "bad.npz")
    message = str(caught.value)
    assert message.startswith("bad.npz") and "\n" not in message and len(message) < 250


def test_an_unknown_sequence_is_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "bad.npz", **WAYS["one of SURREAL's"][0])
    with pytest.raises(DataError, match=r"bad\.npz: there is no sequence 'c'; it has a, b"):
        read_motion(f"{tmp_path}/bad.npz:c")


def _header(text: bytes) -> Callable[[bytes], bytes]:
    """Another header of the array `poses`, of the same length, in an archive that isn't compressed."""
    return lambda content: content.replace(b"(5, 156)", text.ljust(8), 1)


BYTES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda content: b"",
    "half": lambda content: content[: len(content) // 2],
    "cut by a byte": lambda content: content[:-1],
    "no directory": lambda content: content[:-200],
    "noise": lambda content: bytes(range(256)) * 8,
    "text": lambda content: b"HIERARCHY\nROOT Hips\n",
    "a lone array": lambda content: content[content.index(b"\x93NUMPY") :],
    "a changed number": lambda content: content[:1000] + b"\xff\x00\xff" + content[1003:],
    "a shape that lies": _header(b"(6, 156)"),
    "a shape without end": _header(b"(9**9,9)"),
    "a shape that is code": _header(b"exit(77)"),
    "no shape": _header(b""),
    "no magic": lambda content: content.replace(b"\x93NUMPY", b"\x93NUMPX"),
}


@pytest.mark.parametrize("name", BYTES)
def test_damaged_files_are_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.npz"
    np.savez(path, **_with())
    path.write_bytes(BYTES[name](path.read_bytes()))
    with pytest.raises(DataError, match=r"bad\.npz") as caught:
        read_motion(path)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 250


def test_nothing_in_a_pickle_is_run(tmp_path: Path) -> None:
    class Trap:
        def __reduce__(self) -> tuple[Any, ...]:
            return (Path.touch, (tmp_path / "sprung",))

    np.savez(tmp_path / "bad.npz", poses=np.array([Trap()], dtype=object), trans=TRANS)
    with pytest.raises(DataError, match="pickled objects, which could run code"):
        read_motion(tmp_path / "bad.npz")
    assert not (tmp_path / "sprung").exists()


def test_a_bomb_is_not_unpacked(tmp_path: Path) -> None:
    """A small file whose arrays would take 3 GB."""
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("poses.npy", b"\x93NUMPY" + b"\0" * 1000)
    content = bytearray((tmp_path / "bomb.npz").read_bytes())
    entry = content.index(b"PK\x01\x02")
    content[entry + 24 : entry + 28] = (3_000_000_000).to_bytes(4, "little")
    (tmp_path / "bomb.npz").write_bytes(content)
    with pytest.raises(DataError, match=r"its arrays take 3000000000 bytes"):
        read_motion(tmp_path / "bomb.npz")
