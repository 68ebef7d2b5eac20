"""Training: the same bits at any number of threads, losses that fall, and a network better than the mean garment."""

from itertools import pairwise

import numpy as np
import pytest
import torch

from model.gcvae.conditioning import Conditioning
from stages.train.config import NetworkConfig, TrainConfig
from stages.train.evaluate import encode
from stages.train.experiment import Mesh, Trained, compare, train
from stages.train.fit import built, cosine_rate, fit_conditioning
from stages.train.packing import load_network, network_arrays, shape_attrs
from stages.train.samples import Samples, micro_batches

SETTINGS = NetworkConfig(
    widths=(6, 6, 8, 8, 8, 8), latent=8, middle=2, hidden=24, modes=4, epochs=12, learning_rate=5e-3
)
CONFIG = TrainConfig(static=SETTINGS, components=(2, 8), conditioning_steps=60)


def fitted(samples: Samples, mesh: Mesh, threads: int, seed: int = 0) -> Trained:
    chosen = samples.select(np.flatnonzero(samples.train))
    return train(chosen, mesh, SETTINGS, CONFIG, np.random.default_rng(seed), threads, lambda done, epochs: None)


@pytest.fixture(scope="module")
def trained(samples: Samples, mesh: Mesh) -> Trained:
    return fitted(samples, mesh, 1)


def test_bits_do_not_depend_on_threads_but_on_the_seed(samples: Samples, mesh: Mesh, trained: Trained) -> None:
    state = trained.network.state_dict()
    again, other = fitted(samples, mesh, 3).network.state_dict(), fitted(samples, mesh, 1, seed=1).network.state_dict()
    assert all(torch.equal(value, again[name]) for name, value in state.items())
    assert not torch.equal(state["decoder.base"], other["decoder.base"])


def test_losses_fall_and_the_mean_garment_is_beaten(samples: Samples, mesh: Mesh, trained: Trained) -> None:
    total = trained.history["total"]
    assert total.shape == (SETTINGS.epochs,)
    assert total[-1] < 0.8 * total[0]
    held_out = samples.select(np.flatnonzero(~samples.train))
    codes = encode(trained.network, held_out, trained.scales)
    scores = compare(trained, held_out, codes, CONFIG, mesh)
    assert list(scores) == ["zero offsets", "mean offsets", "PCA (2)", "PCA (8)", "SVAE"]
    svae, mean = scores["SVAE"]["samples"], scores["mean offsets"]["samples"]
    assert svae["surface_mm"] < 0.8 * mean["surface_mm"]
    assert svae["mask_iou"] > mean["mask_iou"]
    assert scores["zero offsets"]["samples"]["surface_mm"] > mean["surface_mm"]


def test_stored_arrays_give_the_network_back(samples: Samples, mesh: Mesh, trained: Trained) -> None:
    arrays = network_arrays("svae", trained)
    network, scales = load_network("svae", arrays, shape_attrs(trained), mesh.graphs)
    held_out = samples.select(np.flatnonzero(~samples.train))
    first, second = encode(trained.network, held_out, trained.scales), encode(network, held_out, scales)
    assert np.array_equal(first.mean, second.mean)
    arrays.pop("networks/svae/weights/decoder.base")
    with pytest.raises(ValueError, match=r"'decoder.base' is missing"):
        load_network("svae", arrays, shape_attrs(trained), mesh.graphs)


def test_gamma_learns_and_is_frozen() -> None:
    rng = np.random.default_rng(0)
    cvar = torch.from_numpy(rng.standard_normal((60, 2)) @ rng.standard_normal((2, 7))).float()
    gamma = built(lambda: Conditioning(7, 4), 3)
    before = float((gamma(cvar)[0] - cvar).abs().mean().detach())
    assert fit_conditioning(gamma, cvar, 300) < 0.1 * before
    assert not any(parameter.requires_grad for parameter in gamma.parameters())


def test_building_leaves_the_global_generator_alone() -> None:
    torch.manual_seed(5)
    expected = torch.rand(1)
    torch.manual_seed(5)
    built(lambda: Conditioning(3, 2), 11)
    assert torch.equal(torch.rand(1), expected)


def test_micro_batches_hold_every_sample_once_and_one_topology_each() -> None:
    skirt = np.random.default_rng(0).random(23) < 0.4
    batches = micro_batches(skirt, 4, np.random.default_rng(1))
    assert sorted(np.concatenate(batches)) == list(range(23))
    assert all(len(set(skirt[rows])) == 1 and len(rows) <= 4 for rows in batches)


def test_rate_rises_then_falls_to_zero() -> None:
    rates = [cosine_rate(step, 100, 1.0) for step in range(100)]
    assert rates[0] == pytest.approx(0.2)
    assert max(rates) == pytest.approx(1.0)
    assert rates[-1] < 1e-3
    assert all(a >= b for a, b in pairwise(rates[5:]))
