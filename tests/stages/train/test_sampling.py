"""Latent codes: the fitted Gaussian has the codes' mean and covariance, and the nearest type is found."""

import numpy as np
import pytest

from stages.train.sampling import CodeSampler


@pytest.fixture
def sampler() -> tuple[CodeSampler, np.ndarray]:
    rng = np.random.default_rng(0)
    mixing = rng.standard_normal((3, 3))
    codes = (rng.standard_normal((200, 3)) @ mixing + [5, 0, -5]).astype(np.float32)
    other = codes[:50] - [10, 0, 0]
    types = ["dress"] * 200 + ["top"] * 50
    both = np.concatenate([codes, other]).astype(np.float32)
    return CodeSampler.fit(both, np.full_like(both, np.log(0.04)), types), codes


def test_draws_have_mean_and_covariance_of_the_codes_and_their_noise(
    sampler: tuple[CodeSampler, np.ndarray],
) -> None:
    fitted, codes = sampler
    rng = np.random.default_rng(1)
    drawn = np.stack([fitted.of_type("dress", 1.0, rng) for _ in range(8000)])
    expected = np.cov(codes.T, bias=True) + 0.04 * np.eye(3)
    assert np.allclose(drawn.mean(axis=0), codes.mean(axis=0), atol=0.15)
    assert np.allclose(np.cov(drawn.T), expected, atol=0.08 * np.abs(expected).max())


def test_no_temperature_gives_the_mean(sampler: tuple[CodeSampler, np.ndarray]) -> None:
    fitted, codes = sampler
    code = fitted.of_type("dress", 0.0, np.random.default_rng(2))
    assert np.allclose(code, codes.mean(axis=0), atol=1e-5)


def test_the_nearest_type(sampler: tuple[CodeSampler, np.ndarray]) -> None:
    fitted, codes = sampler
    assert fitted.nearest_type(codes.mean(axis=0)) == "dress"
    assert fitted.nearest_type(codes.mean(axis=0) - np.float32([9, 0, 0])) == "top"
