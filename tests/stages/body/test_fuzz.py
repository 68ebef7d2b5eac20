"""Damage of any kind: a file is read, or refused in one line; nothing else is raised and nothing hangs."""

import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stages.body.readers import read_motion
from stages.spec import DataError
from tests.stages.body.acclaim import cmu_person
from tests.stages.body.skeletons import person

STRAYS = [
    b"",
    b"\n",
    b" ",
    b"-",
    b"nan",
    b"1e999",
    b"{",
    b"}",
    b"begin",
    b"end",
    b":root",
    b"\xff\xfe",
    b"\x00",
    b"9" * 40,
]


def write(kind: str, folder: Path) -> tuple[Path, Path]:
    """A sound motion of a kind; returns it and the file to damage."""
    if kind == "bvh":
        rng = np.random.default_rng(1)
        (folder / "a.bvh").write_text(person(rng.uniform(-9, 9, (3, 24, 3)), np.zeros((3, 3)), 1 / 60).text())
        return folder / "a.bvh", folder / "a.bvh"
    if kind == "npz":
        poses = {"poses": np.full((3, 72), 0.1), "trans": np.zeros((3, 3)), "fps": 30.0, "gender": "male"}
        np.savez(folder / "a.npz", **poses)
        return folder / "a.npz", folder / "a.npz"
    made = cmu_person(2, np.random.default_rng(1))
    (folder / "01.asf").write_text(made.asf())
    (folder / "01_01.amc").write_text(made.amc())
    return folder / "01_01.amc", folder / ("01.asf" if kind == "asf" else "01_01.amc")


@pytest.mark.parametrize("kind", ["bvh", "asf", "amc", "npz"])
@given(
    blows=st.lists(
        st.tuples(st.floats(0, 1), st.integers(0, 60), st.sampled_from(STRAYS), st.booleans()), min_size=1, max_size=4
    )
)
@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damage_is_read_or_refused(kind: str, blows: list[tuple[float, int, bytes, bool]], tmp_path: Path) -> None:
    motion, victim = write(kind, tmp_path)
    content = victim.read_bytes()
    for place, length, stray, twice in blows:
        at = int(place * len(content))
        piece = content[at : at + length]
        content = content[:at] + (piece + piece if twice else stray) + content[at + length :]
    victim.write_bytes(content)
    start = time.process_time()
    try:
        recording = read_motion(motion)
    except DataError as error:
        assert "\n" not in str(error) and len(str(error)) < 500
    else:
        assert np.isfinite(recording.rotations).all() and np.isfinite(recording.translations).all()
    assert time.process_time() - start < 2.0
