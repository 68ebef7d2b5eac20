"""Two-bone legs: the ankle is where it was asked to be, and the knee bends forward only."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from model.body import load_free_body
from stages.body.figure import measure
from stages.body.legs import DEEPEST, STRAIGHTEST, reach, solve_leg
from stages.body.turns import rotate, turn

FIGURE = measure(load_free_body("female"), np.zeros(10))


@given(
    side=st.integers(0, 1),
    share=st.floats(0.45, 0.999),
    swing=st.floats(-1.2, 1.4),
    spread=st.floats(-0.5, 0.5),
    out=st.floats(-0.6, 0.6),
)
@settings(max_examples=200, deadline=None)
def test_the_ankle_reaches_its_target(side: int, share: float, swing: float, spread: float, out: float) -> None:
    leg = FIGURE.leg(side)
    down = rotate(turn("x", swing) @ turn("z", spread), [0.0, -1.0, 0.0])
    hip = np.array([[0.1, 0.9, -0.2]])
    ankle = hip + share * reach(leg) * down
    forward = rotate(turn("y", out), [0.0, 0.0, 1.0])[None]
    pose = solve_leg(leg, hip, ankle, forward)
    knee = hip + rotate(pose.thigh, leg[0])
    np.testing.assert_allclose(knee + rotate(pose.shank, leg[1]), ankle, atol=1e-9)
    assert pose.miss.max() < 1e-9
    # The knee lies in front of the line from hip to ankle, on the side it was pointed to.
    across = np.cross(-(ankle - hip), forward)
    middle = knee - hip - ((knee - hip) @ down) * down
    assert (np.cross(across, -(ankle - hip)) * middle).sum() > -1e-4
    assert STRAIGHTEST - 1e-9 <= pose.bend[0] <= DEEPEST + 1e-9


def test_out_of_reach_the_leg_points_at_the_target() -> None:
    leg = FIGURE.leg(0)
    hip, ankle = np.zeros((1, 3)), np.array([[0.0, -2.0, 0.0]])
    pose = solve_leg(leg, hip, ankle, np.array([[0.0, 0.0, 1.0]]))
    end = rotate(pose.thigh, leg[0]) + rotate(pose.shank, leg[1])
    assert pose.miss[0] == pytest.approx(2.0 - reach(leg))
    np.testing.assert_allclose(end, [[0.0, -reach(leg), 0.0]], atol=1e-9)
    assert pose.bend[0] == pytest.approx(STRAIGHTEST)
