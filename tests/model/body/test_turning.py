"""Nearest rotations: SciPy's polar factor, and never NaN."""

import numpy as np
import pytest
import scipy.linalg
from scipy.spatial.transform import Rotation

from model.body.turning import nearest_rotations


def test_blends_equal_the_polar_factor() -> None:
    rng = np.random.default_rng(3)
    pairs = Rotation.random(400, random_state=3).as_matrix().reshape(2, 200, 3, 3)
    weight = rng.uniform(0, 0.3, (200, 1, 1))
    blends = weight * pairs[0] + (1 - weight) * pairs[1]
    regular = np.linalg.det(blends) > 0.05
    assert regular.sum() > 150
    expected = np.array([scipy.linalg.polar(blend)[0] for blend in blends[regular]])
    assert np.abs(nearest_rotations(blends, pairs[1])[regular] - expected).max() < 1e-5


def test_opposite_rotations_fall_back_to_the_strongest_joint() -> None:
    half_turn = np.diag([-1.0, -1.0, 1.0])
    blend = 0.5 * (np.eye(3) + half_turn)
    assert np.linalg.det(blend) == pytest.approx(0.0)
    assert np.array_equal(nearest_rotations(blend[None], half_turn[None])[0], half_turn)
