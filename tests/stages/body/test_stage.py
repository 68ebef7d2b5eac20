"""The stage as a program: shards of sequences and static people, and refusals."""

import dataclasses
import hashlib
import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from model.body import REST_POSE, load_free_body
from stages.body import SPEC
from stages.body.config import Config
from stages.body.sampling import draw_betas
from stages.body.stage import run
from stages.settings import SettingsError, build
from stages.spec import DataError, Task, seed_of
from store import read
from tests.stages.body.skeletons import person

KEY = "a" * 64


def task(folder: Path, kind: str, **params: Any) -> Task:
    """A task of the body stage."""
    defaults = {"gender": "female"}
    if kind == "sequence":
        defaults |= {"motion": "walk", "motion_sha256": "", "start": 0, "frames": 12}
    return Task(
        stage="body",
        item="someone",
        kind=kind,
        key=KEY,
        seed=seed_of(1, "body", "someone"),
        config={},
        params=defaults | params,
        output=str(folder / "someone.h5"),
    )


def ignore(done: float, total: float, label: str = "") -> None:
    """No progress is shown."""


def test_a_sequence_is_published(tmp_path: Path) -> None:
    calls: list[tuple[float, float]] = []
    job = task(tmp_path, "sequence", start=20)
    figures = run(job, lambda done, total, label="": calls.append((done, total)))
    shard = read(job.output, "body", KEY)
    assert shard.attrs["gender"] == "female" and shard.attrs["motion"] == "walk" and shard.attrs["fps"] == 30
    assert shard.attrs["action"] == "walking" and shard.attrs["kind"] == "sequence" and figures["frames"] == 12
    model = load_free_body("female")
    pose, trans, vertices = shard["pose"], shard["trans"], shard["vertices"]
    assert pose.shape == (12, 24, 3) and vertices.shape == (12, model.vertex_count, 3)
    world = model.pose(shard["betas"], pose, trans)
    # Only what the record tells of was moved, and no farther.
    apart = np.linalg.norm(vertices + trans[:, None] - world, axis=2)
    assert shard.attrs["collision"]["case"] == figures["collision"] == "solved"
    assert (apart.max(axis=1) <= shard["collision/moved"].sum(axis=1) + 2e-4).all() and apart.max() > 0.002
    assert np.count_nonzero(apart.max(axis=0) > 2e-4) <= shard["collision/vertices"].max(axis=0).sum() * 2
    assert shard["face_kept"].all() and shard["collision/depth"].shape == (12, len(shard.attrs["collision"]["pairs"]))
    assert world[..., 2].min() == pytest.approx(0, abs=1e-3)
    np.testing.assert_allclose(trans[0, :2], 0, atol=1e-7)
    np.testing.assert_array_equal(shard["rest_pose"], REST_POSE.astype(np.float32))
    assert shard.attrs["opening"]["arm_distance"] >= 0.009
    assert calls[-1][0] == calls[-1][1] and len(calls) >= 3
    assert all(a <= b for (a, _), (b, _) in itertools.pairwise(calls))


def test_the_same_task_gives_the_same_bytes(tmp_path: Path) -> None:
    first, second = task(tmp_path / "a", "sequence"), task(tmp_path / "b", "sequence")
    run(first, ignore)
    run(second, ignore)
    assert Path(first.output).read_bytes() == Path(second.output).read_bytes()


def test_a_static_person_stands_at_rest(tmp_path: Path) -> None:
    job = task(tmp_path, "static", gender="male")
    run(job, ignore)
    shard = read(job.output, "body", KEY)
    assert shard.attrs["motion"] == "rest" and shard.attrs["kind"] == "static"
    assert shard["pose"].shape == (1, 24, 3) and not shard["trans"].any()
    np.testing.assert_allclose(shard["vertices"][0], shard["rest_vertices"], atol=6e-5)
    high, low = shard["rest_vertices"][:, 2].max(), shard["rest_vertices"][:, 2].min()
    assert 1.3 < high - low < 2.2 and low < -0.6


def test_a_rejected_body_leaves_a_failure(tmp_path: Path) -> None:
    """Cause, frame, seed, shape and a picture, beside what would have been published."""
    job = dataclasses.replace(
        task(tmp_path, "sequence"),
        config={"largest_move": 0.001, "thinner_tries": 0, "leave_out": "nothing"},
    )
    with pytest.raises(DataError, match=r"someone: .* are parted only by moving skin .* mm in frame \d+, more than"):
        run(job, ignore)
    assert not Path(job.output).exists()
    known = json.loads((tmp_path / "failures" / "someone.json").read_text())
    assert known["seed"] == job.seed and len(known["betas"]) == 10 and 0 <= known["frame"] < 12
    assert known["motion"] == "walk" and "largest_move = 1 mm" in known["cause"]
    shown = np.asarray(Image.open(tmp_path / "failures" / "someone.png")).astype(int)
    assert np.count_nonzero(shown[..., 0] - shown[..., 1] > 60) > 100


def test_a_recording_is_put_on(tmp_path: Path) -> None:
    t = np.arange(60)
    angles = np.zeros((60, 24, 3))
    angles[:, 16, 0], angles[:, 21, 0] = -60, 60
    angles[:, 18, 1] = 20 * np.sin(t / 10)
    path = tmp_path / "waving_2.bvh"
    path.write_text(person(angles, np.full((60, 3), 17.0), 1 / 60).text())
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    job = task(tmp_path, "sequence", motion=str(path), motion_sha256=digest, frames=100)
    run(job, ignore)
    shard = read(job.output, "body", KEY)
    assert shard.attrs["motion"] == "waving_2" and shard.attrs["action"] == "waving"
    assert len(shard["pose"]) == 30
    lowest = (shard["vertices"] + shard["trans"][:, None])[..., 2].min(axis=1)
    np.testing.assert_allclose(lowest, 0, atol=2e-3)


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ({"motion": "wlak"}, "motion must be one of walk, run, jump, squat, turn, dance or a motion file, got 'wlak'"),
        ({"start": 355}, "walk: frames 355 to 366 wanted, it has 360"),
        ({"frames": 0}, "walk: frames 0 to -1 wanted"),
        ({"motion": "gone/away.bvh"}, "there is no such motion file"),
    ],
)
def test_bad_parameters_are_refused(params: dict[str, Any], message: str, tmp_path: Path) -> None:
    job = task(tmp_path, "sequence", **params)
    with pytest.raises(DataError) as caught:
        run(job, ignore)
    assert message in str(caught.value) and "\n" not in str(caught.value)
    assert not Path(job.output).exists()


def test_a_changed_recording_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "made.bvh"
    path.write_text(person(np.zeros((3, 24, 3)), np.zeros((3, 3)), 1 / 30).text())
    job = task(tmp_path, "sequence", motion=str(path), motion_sha256="b" * 64)
    with pytest.raises(DataError, match=r"made\.bvh: the file has changed since the run was planned"):
        run(job, ignore)


def test_shapes_are_uniform_and_can_be_pinned() -> None:
    drawn = np.array([draw_betas((-3, 3), (), np.random.default_rng(i)) for i in range(400)])
    assert drawn.min() >= -3 and drawn.max() <= 3 and np.abs(drawn.mean(axis=0)).max() < 0.35
    assert np.abs(drawn.std(axis=0) - np.sqrt(3)).max() < 0.15
    pinned = draw_betas((-3, 3), (1.5, -2.0), np.random.default_rng(7))
    free = draw_betas((-3, 3), (), np.random.default_rng(7))
    np.testing.assert_array_equal(pinned[:2], [1.5, -2.0])
    np.testing.assert_array_equal(pinned[2:], free[2:])


def test_settings_out_of_range_are_refused() -> None:
    for given in (
        {"shape_range": [2, -2]},
        {"shape_range": [-9, 3]},
        {"betas": [0.0] * 11},
        {"arm_gap": 0.001},
        {"separation": 0.003},
    ):
        with pytest.raises(SettingsError):
            build(Config, given)
    assert dataclasses.asdict(build(Config, {"betas": [1, -1]}))["betas"] == (1.0, -1.0)
    assert SPEC.needs == () and SPEC.schema == "body"
