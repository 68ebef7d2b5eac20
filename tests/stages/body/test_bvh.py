"""The BVH reader against scalar formulas and against an independent library."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stages.body.readers.bvh import read_bvh
from tests.stages.body.skeletons import ORDERS, Made, person


@st.composite
def skeletons(draw: st.DrawFn) -> Made:
    """Any tree of up to seven joints, any channel order, any angles."""
    count, frames = draw(st.integers(1, 7)), draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return Made(
        names=[f"joint {i}" for i in range(count)],
        parents=[-1, *(draw(st.integers(0, i)) for i in range(count - 1))],
        offsets=rng.normal(size=(count, 3)) * 10,
        orders=[draw(st.sampled_from(ORDERS)) for _ in range(count)],
        angles=rng.uniform(-360, 360, size=(frames, count, 3)),
        root=rng.normal(size=(frames, 3)) * 100,
        frame_time=draw(st.sampled_from([1 / 30, 1 / 60, 1 / 120])),
    )


@given(made=skeletons())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_random_skeletons_come_back(made: Made, tmp_path: Path) -> None:
    path = tmp_path / "made.bvh"
    path.write_text(made.text())
    recording = read_bvh(path)
    _, positions = recording.forward()
    order = [recording.names.index(name) for name in made.names]
    assert sorted(recording.names) == sorted(made.names)
    assert recording.frame_time == pytest.approx(made.frame_time, abs=1e-6)
    np.testing.assert_allclose(positions[:, order], made.positions(), atol=1e-5)


def test_a_joint_with_positions_leaves_its_offset(tmp_path: Path) -> None:
    text = person(np.zeros((1, 24, 3)), np.zeros((1, 3)), 1 / 30).text()
    head = text.index("JOINT Head")
    text = text[:head] + text[head:].replace(
        "CHANNELS 3 Zrotation", "CHANNELS 6 Xposition Yposition Zposition Zrotation", 1
    )
    values = text.splitlines()[-1].split()
    at = 3 + 3 * 14  # root position, then three angles for each joint before the head
    text = text.rsplit("\n", 2)[0] + "\n" + " ".join([*values[:at], "5", "6", "7", *values[at:]]) + "\n"
    path = tmp_path / "made.bvh"
    path.write_text(text)
    recording = read_bvh(path)
    head_joint, neck = recording.names.index("Head"), recording.names.index("Neck")
    _, positions = recording.forward()
    np.testing.assert_allclose(positions[0, head_joint] - positions[0, neck], [5, 6, 7])


def test_agrees_with_pybvh_on_real_capture(captures: Path) -> None:
    pybvh = pytest.importorskip("pybvh")
    for name in ("walking_1.bvh", "jumping_1.bvh"):
        ours, theirs = read_bvh(captures / name), pybvh.read_bvh_file(str(captures / name))
        assert list(ours.names) == list(theirs.joint_names)
        np.testing.assert_allclose(ours.forward()[1], theirs.joint_positions(), atol=1e-9)
