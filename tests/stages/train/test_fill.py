"""Continuation of offsets outside a garment, against the exact harmonic one."""

import numpy as np

from model.gcvae.hierarchy import Hierarchy
from model.mesh.operators import harmonic_fill
from stages.train.fill import Fill

Tube = tuple[np.ndarray, np.ndarray]


def test_known_values_stay_and_constants_continue(tube: Tube, hierarchy: Hierarchy) -> None:
    height = tube[0][:, 2]
    known = (height > 0.5) & (height < 0.9)
    values = np.tile([1.0, -2.0, 0.5], (len(height), 1))
    filled = Fill(hierarchy, "body")(np.where(known[:, None], values, 99.0), known)
    assert np.allclose(filled, values, atol=1e-5)


def test_close_to_the_harmonic_continuation(tube: Tube, hierarchy: Hierarchy) -> None:
    height = tube[0][:, 2]
    known = (height < 0.3) | (height > 1.2)
    values = np.stack([height, height**2, np.cos(3 * height)], axis=1)
    exact = harmonic_fill(hierarchy.edges["body"][0], values, ~known)
    filled = Fill(hierarchy, "body")(values, known)
    assert np.array_equal(filled[known], values[known].astype(np.float32))
    spread = exact[~known].std(axis=0)
    assert (spread > 0.1).all()
    assert (np.abs(filled - exact)[~known].mean(axis=0) < 0.3 * spread).all()


def test_nothing_known_gives_zero(tube: Tube, hierarchy: Hierarchy) -> None:
    values = np.ones((len(tube[0]), 3))
    assert not Fill(hierarchy, "body")(values, np.zeros(len(values), bool)).any()
