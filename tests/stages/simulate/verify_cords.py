"""A cord of a fastening bears what hangs on it, and does nothing while it is slack."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import EXACT, QUASI_STATIC, garment, scene, settle, sheet, stepper

from stages.simulate.scene import Garment
from stages.simulate.springs import CORD
from stages.spec import DataError

EDGE, GAP, LENGTH = 0.02, 0.01, 0.03


def halves(length: float) -> tuple[Garment, np.ndarray]:
    """Two sheets side by side, `GAP` apart, joined by a cord of `length` at every vertex; which are held."""
    vertices, faces = sheet(4, 4, EDGE)
    other = vertices + np.array([3 * EDGE + GAP, 0, 0])
    both = garment(np.concatenate([vertices, other]), np.concatenate([faces, faces + 16]).astype(np.int32))
    cords = np.column_stack([np.arange(16, 20), np.arange(12, 16)]).astype(np.int32)
    return replace(both, cords=cords, cord_length=np.full(4, length)), np.arange(4)


def test_a_taut_cord_bears_the_weight_that_hangs_on_it() -> None:
    cloth, held = halves(LENGTH)
    start = cloth.vertices[:, [1, 2, 0]] * [1, 1, -1]
    s = stepper(scene(cloth, start=start, pins=held), **QUASI_STATIC)
    assert len(s.springs.edges) == s.springs.woven + 4
    settle(s, speed=1e-4)
    ends = s.x[cloth.cords]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    weight = 9.81 * s.springs.mass[16:].sum()
    assert CORD * (length - LENGTH).sum() == pytest.approx(weight, rel=1e-3)
    assert (length > LENGTH).all() and (s.x[16:20, 2] < s.x[12:16, 2] - LENGTH).all()


def test_a_slack_cord_does_nothing() -> None:
    cloth, _ = halves(LENGTH)
    rng = np.random.default_rng(5)
    start = cloth.vertices + rng.normal(0, 1e-3, cloth.vertices.shape)
    free = replace(cloth, cords=cloth.cords[:0], cord_length=cloth.cord_length[:0])
    ends = []
    for one in (cloth, free):
        s = stepper(scene(one, start=start), self_collision=False, gravity=0.0, **EXACT)
        s.advance_to(0.1, 1 / 120)
        ends.append(s.x)
    # A slack cord still pushes, with 1e-8 of its stiffness.
    assert np.abs(ends[0] - ends[1]).max() < 1e-5
    assert np.abs(ends[1] - start).max() > 5e-4


def test_a_cord_to_nowhere_is_refused() -> None:
    cloth, _ = halves(LENGTH)
    for vertex in (40, -1):
        with pytest.raises(DataError, match=f"cloth: cords must join vertices 0 to 31, not {vertex}$"):
            stepper(scene(replace(cloth, cords=np.array([[0, vertex]], np.int32), cord_length=np.ones(1))))
    with pytest.raises(DataError, match=r"cloth: each of 4 cords must have a length above 0 m, not \[0.0, "):
        stepper(scene(replace(cloth, cord_length=np.zeros(4))))
