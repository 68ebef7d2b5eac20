"""Baselines against plain NumPy on the same samples."""

import numpy as np
import pytest

from stages.train.baselines import Components, TypeMeans, feature_rows
from stages.train.samples import Samples


def test_means_of_each_type(samples: Samples) -> None:
    means = TypeMeans.fit(samples)
    rows = np.flatnonzero(samples.skirt)
    offsets, mask = means("skirt")
    assert np.allclose(offsets, samples.target[rows].mean(axis=0))
    assert np.array_equal(mask, samples.mask[rows].mean(axis=0) >= 0.5)
    assert 0 < mask.sum() < len(mask)


def test_a_type_never_seen_gets_the_mean_of_all(samples: Samples) -> None:
    offsets, _ = TypeMeans.fit(samples)("cape")
    assert np.allclose(offsets, samples.target.mean(axis=0))


@pytest.mark.parametrize("size", [1, 3, 8])
def test_components_equal_a_singular_value_decomposition(samples: Samples, size: int) -> None:
    rows = feature_rows(samples, np.arange(len(samples)), 0.05, True).astype(np.float64)
    mean = rows.mean(axis=0)
    _, values, vectors = np.linalg.svd(rows - mean, full_matrices=False)
    expected = mean + (rows - mean) @ vectors[:size].T @ vectors[:size]
    components = Components.fit(samples, 8, 0.05, True)
    assert np.allclose(components.deviation, values[:8] / np.sqrt(len(rows)), rtol=1e-4)
    offsets, masks = components(rows.astype(np.float32), size)
    count = samples.mask.shape[1]
    assert np.allclose(offsets.reshape(len(rows), -1), 0.05 * expected[:, : 3 * count], atol=1e-5)
    assert masks is not None
    sure = np.abs(expected[:, 3 * count :] - 0.5) > 1e-4
    assert np.array_equal(masks[sure], (expected[:, 3 * count :] >= 0.5)[sure])


def test_components_are_orthonormal_and_never_more_than_the_samples_allow(samples: Samples) -> None:
    components = Components.fit(samples.select(np.arange(6)), 64, 0.05, True)
    assert len(components.basis) == 5
    assert np.allclose(components.basis @ components.basis.T, np.eye(5), atol=1e-4)


def test_vertex_channels_keep_offsets_and_mask_apart(samples: Samples) -> None:
    components = Components.fit(samples, 4, 0.05, True)
    rows = feature_rows(samples, np.array([3]), 0.05, True)
    channels = components.per_vertex(rows)[0]
    assert np.allclose(channels[:, :3] * 0.05, samples.target[3], atol=1e-7)
    assert np.array_equal(channels[:, 3] == 1.0, samples.mask[3])
