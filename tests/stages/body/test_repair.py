"""From any rate to 30 fps; fake frames and flips."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stages.body.readers.bvh import read_bvh
from stages.body.recording import Recording
from stages.body.repair import drop_fake_start, mend_flips
from stages.body.resample import resample
from tests.stages.body.skeletons import person


def record(angles: np.ndarray, root: np.ndarray, frame_time: float, folder: Path) -> Recording:
    """The recording of a made motion."""
    path = folder / "made.bvh"
    path.write_text(person(angles, root, frame_time).text())
    return read_bvh(path)


def smooth(frames: int) -> np.ndarray:
    """Arms hang, everything swings a little [degrees], shape [F, 24, 3]."""
    angles = 10 * np.sin(np.arange(frames) / 25)[:, None, None] * np.ones((1, 24, 3))
    angles[:, [16, 21], 0] += [-80, 80]
    return angles


@pytest.mark.parametrize("rate", [24.0, 30.0, 59.94, 120.0])
def test_frames_are_picked_in_time(rate: float, tmp_path: Path) -> None:
    """A joint that turns at constant speed, and a root that moves so, are met exactly between frames."""
    count = int(rate) + 1
    t = np.arange(count) / rate
    angles = np.zeros((count, 24, 3))
    angles[:, 1, 2] = 100 * t
    root = np.stack([t, 2 * t, -t], axis=-1)
    out = resample(record(angles, root, 1 / rate, tmp_path))
    times = np.arange(len(out.rotations)) / 30
    assert len(out.rotations) == int(np.floor(t[-1] * 30 + 1e-3)) + 1
    turned = Rotation.from_matrix(out.rotations[:, 1]).as_rotvec()
    np.testing.assert_allclose(np.degrees(turned[:, 0]), 100 * times, atol=1e-3)
    np.testing.assert_allclose(out.translations[:, 0], np.stack([times, 2 * times, -times], axis=-1), atol=1e-4)


def test_rotations_go_the_short_way(tmp_path: Path) -> None:
    """From 170 to -170 degrees a joint turns by 20 degrees, through 180, not back through 0."""
    angles = np.zeros((2, 24, 3))
    angles[:, 1, 2] = [170, -170]
    out = resample(record(angles, np.zeros((2, 3)), 1 / 15, tmp_path))
    assert np.degrees(Rotation.from_matrix(out.rotations[1, 1]).magnitude()) == pytest.approx(180, abs=1e-3)


def test_a_single_frame_stays(tmp_path: Path) -> None:
    out = resample(record(np.zeros((1, 24, 3)), np.ones((1, 3)), 1 / 120, tmp_path))
    assert out.rotations.shape == (1, 24, 3, 3)


def test_a_fake_first_frame_is_dropped(tmp_path: Path) -> None:
    angles, root = smooth(80), np.zeros((80, 3))
    clean = record(angles, root, 1 / 120, tmp_path)
    assert len(drop_fake_start(clean).rotations) == 80
    angles[0] = 0
    faked = drop_fake_start(record(angles, root, 1 / 120, tmp_path))
    assert len(faked.rotations) == 79
    np.testing.assert_array_equal(faked.rotations, clean.rotations[1:])


def test_flips_of_the_root_are_bridged(tmp_path: Path) -> None:
    angles, root = smooth(240), np.zeros((240, 3))
    clean = record(angles, root, 1 / 120, tmp_path)
    assert mend_flips(clean)[1] == 0
    angles[100:104, 0, 1] += [60, 170, 160, 40]
    mended, count = mend_flips(record(angles, root, 1 / 120, tmp_path))
    assert 4 <= count <= 36
    off = Rotation.from_matrix(mended.rotations[:, 0]).inv() * Rotation.from_matrix(clean.rotations[:, 0])
    assert np.degrees(off.magnitude()).max() < 3.0
    np.testing.assert_array_equal(mended.rotations[:, 1:], clean.rotations[:, 1:])


def test_real_captures_lose_their_fake_frame(captures: Path) -> None:
    for path in sorted(captures.glob("*.bvh"))[::5]:
        recording = read_bvh(path)
        assert len(drop_fake_start(recording).rotations) == len(recording.rotations) - 1
