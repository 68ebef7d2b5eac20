"""A rolling foot: its point of contact is at rest and on the ground."""

import numpy as np
import pytest

from model.body import load_free_body
from stages.body.figure import measure
from stages.body.sole import measure_sole
from stages.body.turns import rotate, turn


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("pitches", [(-0.6, 0.0), (0.0, 0.9)])
def test_the_contact_neither_slides_nor_sinks(side: int, pitches: tuple[float, float]) -> None:
    sole = measure_sole(measure(load_free_body("male"), np.zeros(10)), side)
    pitch = np.linspace(*pitches, 2000)
    toe = -np.maximum(pitch, 0.0)
    ankle = sole.standing(pitch)
    height = ankle[:, 1] + sole.lowest(pitch, toe)
    # On the heel: exact but for the table's steps. On the ball: the skin shared by foot and toes gives way a little.
    assert np.abs(height).max() < (2e-5 if pitches[0] < 0 else 3e-3)
    points = sole.points
    if pitches[0] < 0:
        world = ankle[:, None] + rotate(turn("x", pitch)[:, None], points)
        lowest = world[:-1, :, 1].argmin(axis=1)
        step = world[1:][np.arange(1999), lowest] - world[:-1][np.arange(1999), lowest]
        assert np.abs(step.sum(axis=0)[2]) < 1e-4
        assert np.abs(step[:, 2]).max() < 1e-6 + np.abs(np.diff(pitch)).max() * 0.02
    else:
        toes = points[sole.toe_weights == 1]
        world = ankle[:, None] + rotate(turn("x", pitch), sole.ball)[:, None] + (toes - sole.ball)
        assert np.ptp(world, axis=0).max() < 1e-9
