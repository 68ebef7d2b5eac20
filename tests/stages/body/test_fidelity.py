"""Every real clip at hand, on a body: limbs, feet, ground; the bars that a retargeted motion must clear."""

from pathlib import Path

import numpy as np
import pytest

from model.body import BodyModel
from stages.body.clips import perform
from stages.body.fidelity import compare, sole_points
from stages.body.figure import Figure
from stages.body.readers import read_motion
from stages.body.sequence import prepared, put_on
from tests.stages.body.test_clips import feet_of
from tests.stages.body.test_root_order import as_recording

Person = tuple[BodyModel, np.ndarray, Figure]

DIRECTION = 5.0  # [degrees], in the mean
SLIDE = 0.8  # [mm/frame], in the mean


def test_every_clip_clears_the_bars(captures: Path, woman: Person) -> None:
    """Directions and slides of all clips; who walks has a foot on the ground all the time, who runs or jumps hasn't."""
    _, _, figure = woman
    clips = sorted(captures.glob("*.bvh"))
    assert len(clips) == 22
    for path in clips:
        at_30, _ = prepared(read_motion(path), path.name)
        figures = compare(figure, put_on(figure, at_30, path.name), at_30, path.name)
        assert figures.direction < DIRECTION and figures.worst_bone < 1.5 * DIRECTION, path.name
        assert figures.slide < SLIDE and figures.sunk < 1.0, path.name
        if path.name.startswith(("walking", "basketball", "directing")):
            assert figures.planted > 0.98, path.name
        if path.name.startswith(("running", "jumping")):
            assert figures.planted < 0.9, path.name


def test_figures_show_what_is_wrong(woman: Person) -> None:
    """A motion compared with itself is true; turned limbs, sliding and sunk feet are seen and measured."""
    _, _, figure = woman
    motion, recording = perform(figure, "walk"), as_recording(figure, "walk")
    true = compare(figure, motion, recording, "walk")
    assert true.direction < 1e-3 and true.slide < 0.6 and true.sunk < 1.0
    bent = perform(figure, "walk")
    bent.pose[:, 18, 1] -= np.radians(27.0)
    assert compare(figure, bent, recording, "walk").direction == pytest.approx(27.0 / 9, rel=0.1)
    gliding = perform(figure, "walk")
    gliding.trans[:, 0] += 0.004 * np.arange(len(gliding))
    assert compare(figure, gliding, recording, "walk").slide == pytest.approx(4.0, abs=0.6)
    sunk = perform(figure, "walk")
    sunk.trans[:, 2] -= 0.03
    assert compare(figure, sunk, recording, "walk").sunk == pytest.approx(30.0, abs=1.0)


def test_soles_are_where_the_skin_is(woman: Person) -> None:
    model, betas, figure = woman
    motion = perform(figure, "run")
    for side in (0, 1):
        lowest = feet_of(model, betas, motion, side)[..., 2].min(axis=1)
        np.testing.assert_allclose(sole_points(figure, motion, side)[..., 2].min(axis=1), lowest, atol=4e-3)
