"""Larger and fatter are told from the model itself, whatever order and signs its betas have."""

from dataclasses import replace

import numpy as np
import pytest

from model.body import GENDERS, load_free_body
from model.body.size import size_directions


@pytest.mark.parametrize("gender", GENDERS)
def test_the_free_body_has_size_first_and_fatness_second(gender: str) -> None:
    found = size_directions(load_free_body(gender))
    np.testing.assert_array_equal(found, np.eye(2, 10))


@pytest.mark.parametrize("gender", GENDERS)
def test_order_and_signs_of_betas_do_not_matter(gender: str) -> None:
    free, rng = load_free_body(gender), np.random.default_rng(7)
    for _ in range(3):
        order, sign = rng.permutation(10), rng.choice([-1.0, 1.0], 10)
        other = replace(free, shapedirs=(free.shapedirs[..., order] * sign).astype(np.float32))
        found = size_directions(other)
        assert (np.abs(found).sum(axis=1) == 1).all()
        for beta, row in enumerate(found):
            assert order[np.abs(row).argmax()] == beta
            np.testing.assert_allclose(other.shape(row)[0], free.shape(np.eye(10)[beta])[0], atol=1e-6)
