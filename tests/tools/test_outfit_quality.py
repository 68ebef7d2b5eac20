"""The report on outfits: its measures find what is wrong, and its page holds what it claims."""

import numpy as np
import pytest

from tests.stages.outfit.measures import ball, tube
from tools.outfit.measures import measure
from tools.outfit.quality_cast import cast

BODY, BODY_FACES = ball(0.05)
POINTS, FACES = tube(0.1, 0.1, 0.01)


def faults(points: np.ndarray, faces: np.ndarray) -> list[str]:
    return measure(points, faces, 0.01, BODY, BODY_FACES).faults()


def test_a_clean_tube_has_no_fault() -> None:
    found = measure(POINTS, FACES, 0.01, BODY, BODY_FACES)
    assert found.faults() == []
    assert found.smallest_angle > 50
    assert found.mean_edge == pytest.approx(1.0, abs=0.02)
    assert found.body_distance == pytest.approx(0.05, abs=2e-3)


def test_each_fault_is_found() -> None:
    assert faults(POINTS, FACES[:, ::-1]) == ["not oriented"]
    turned = FACES.copy()
    turned[5] = turned[5, ::-1]
    assert "not oriented" in faults(POINTS, turned)
    assert "not manifold" in faults(POINTS, np.vstack([FACES, [[FACES[3, 0], FACES[3, 1], 300]]]))
    two = np.vstack([POINTS, POINTS + np.array([1, 0, 0])]), np.vstack([FACES, FACES + len(POINTS)])
    assert "more than one component" in faults(*two)
    folded = POINTS.copy()
    folded[POINTS[:, 2] > 0.05, 0] *= -1
    assert "passes through itself" in faults(folded, FACES)
    small = POINTS * [0.04 / 0.1, 0.04 / 0.1, 1]
    assert "meets the body" in faults(small, FACES)
    assert "vertices inside the body" in faults(POINTS * 0.1, FACES)
    assert "over 0.1 % of faces sharp" in faults(POINTS * [1, 1, 0.1], FACES)
    pulled = POINTS.copy()
    pulled[200] += [0.0, 0.0, 0.02]
    assert "edges out of 0.5-2 of the target" in faults(pulled, FACES)


def test_the_cast_takes_every_kind_gender_and_corner() -> None:
    members = cast(96)
    assert len({(m.gender, m.kind, m.betas[0], m.betas[1]) for m in members}) == 48
    assert {abs(b) for m in members for b in m.betas} == {3.0}
    assert members[:10] == cast(10)
