"""The preview: a video and a sheet of any motion, in one command, and one line for whatever can't be shown."""

import subprocess
import sys
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from stages.preview import HEIGHT, SHEET_COLUMNS, WIDTH, main
from tests.stages.body.skeletons import person


@pytest.fixture
def clip(tmp_path: Path) -> Path:
    """Somebody who stands for a moment."""
    angles = np.zeros((16, 24, 3))
    angles[:, [16, 21], 0] = [-70, 70]
    path = tmp_path / "standing_1.bvh"
    path.write_text(person(angles, np.zeros((16, 3)), 1 / 120).text())
    return path


def test_a_file_becomes_a_video_and_a_sheet(clip: Path, tmp_path: Path) -> None:
    out = tmp_path / "out" / "seen.mp4"
    command = [sys.executable, "-m", "stages.body", "preview", str(clip), "--out", str(out)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert "16 frames at 120 fps, 4 at 30 fps" in ran.stdout and "slide" in ran.stdout and str(out) in ran.stdout
    reader = imageio_ffmpeg.read_frames(str(out))
    about = next(reader)
    assert about["size"] == (2 * WIDTH, HEIGHT) and about["fps"] == 30
    frames = [np.frombuffer(frame, np.uint8).reshape(HEIGHT, 2 * WIDTH, 3) for frame in reader]
    assert len(frames) == 4
    sheet = np.asarray(Image.open(out.with_suffix(".png")))
    assert sheet.shape == (HEIGHT, SHEET_COLUMNS * (2 * WIDTH + 4) - 4, 3)
    # The recorded skeleton stands in the left half, and the body, which covers more, in the right one.
    empty = np.asarray(frames[0], float)[:, :8].mean(axis=1, keepdims=True)
    seen = (np.abs(frames[0] - empty).max(axis=-1) > 60)[: HEIGHT // 2]
    assert 100 < seen[:, :WIDTH].sum() < seen[:, WIDTH:].sum() / 2


def test_an_embedded_clip_needs_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["walk", "--frames", "2", "--start", "30", "--sheet-only", "--gender", "male", "--betas", "2", "1.5"]
    assert main([*given, "--out", str(tmp_path / "walk.mp4")]) == 0
    assert Image.open(tmp_path / "walk.png").size[1] == HEIGHT and not (tmp_path / "walk.mp4").exists()
    told = capsys.readouterr().out
    assert "embedded" in told and "self-collision: solved, skin moved by" in told
    assert main([*given, "--raw", "--out", str(tmp_path / "raw.mp4")]) == 0
    assert "self-collision" not in capsys.readouterr().out
    assert (tmp_path / "raw.png").read_bytes() != (tmp_path / "walk.png").read_bytes()


def test_a_body_that_would_be_rejected_is_marked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A thigh through the belly of somebody fat: why, and a red bar over the pictures in which it is."""
    angles = np.zeros((32, 24, 3))
    angles[:, [16, 21], 0] = [-70, 70]
    angles[16:, 1, 1] = -155
    path = tmp_path / "kick.bvh"
    path.write_text(person(angles, np.zeros((32, 3)), 1 / 30).text())
    given = [str(path), "--betas", "3", "3", "--sheet-only", "--out", str(tmp_path / "kick.mp4")]
    assert main(given) == 0
    assert "would be rejected: kick: " in capsys.readouterr().out
    sheet = np.asarray(Image.open(tmp_path / "kick.png"), float)
    cells = [sheet[4, column * (2 * WIDTH + 4) + 20] for column in range(SHEET_COLUMNS)]
    red = [cell[0] > 2 * cell[1] for cell in cells]
    below = [sheet[HEIGHT + 8, column * (2 * WIDTH + 4) + 20] for column in range(SHEET_COLUMNS)]
    assert not any(red[:4]) and all(cell[0] > 2 * cell[1] for cell in below[2:])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["gone.bvh"], "gone.bvh: there is no such motion file"),
        (["wlak"], "motion must be one of walk, run"),
        (["walk.c3d"], "walk.c3d: is no motion file that can be read"),
        (["walk", "--start", "900"], "--start must be from 0 to 359, got 900"),
        (["walk", "--model", "gone.pkl"], "gone.pkl"),
        (["walk", "--betas", "nan"], "--betas must be at most 10 numbers"),
        (["CLIP", "--rate", "0"], "--rate must be from 1 to 10000 frames/s, got 0"),
        (["CLIP", "--joint", "left_knee"], "--joint must be such as left_knee=Calf_L"),
        (["CLIP", "--joint", "left_knee=Calf"], "which the file doesn't have"),
        (["CLIP", "--out", "film.avi"], "--out must end in .mp4"),
    ],
)
def test_what_cannot_be_shown_is_told(
    given: list[str], message: str, clip: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(clip) if word == "CLIP" else word for word in given]) == 1
    err = capsys.readouterr().err
    assert message in err and err.count("\n") == 1
