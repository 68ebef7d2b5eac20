"""The networks: shapes under both topologies, a start that equals a PCA, one batch learned by heart."""

import numpy as np
import pytest
import torch

from model.gcvae.conditioning import Conditioning
from model.gcvae.graphs import MeshGraphs
from model.gcvae.network import Architecture, GarmentVae

SHAPE = Architecture(
    inputs=7, masked=True, conditions=5, middle=4, latent=6, hidden=32, widths=(8, 8, 12, 12, 16, 16), depth=1,
    node_bias=True, modes=3,
)  # fmt: skip


def network(graphs: MeshGraphs, shape: Architecture = SHAPE) -> GarmentVae:
    torch.manual_seed(0)
    return GarmentVae(graphs, shape)


@pytest.mark.parametrize("topology", ["body", "skirt"])
@pytest.mark.parametrize("masked", [True, False])
def test_shapes(graphs: MeshGraphs, topology: str, masked: bool) -> None:
    shape = Architecture(**{**vars(SHAPE), "masked": masked, "modes": 0, "depth": 2})
    x, cvar = torch.randn(graphs.sizes[0], 3, 7), torch.randn(3, 5)
    offsets, logits, encoded, middle = network(graphs, shape)(x, cvar, torch.randn(3, 6), topology)
    assert offsets.shape == (graphs.sizes[0], 3, 3)
    assert (logits.shape == (graphs.sizes[0], 3)) if logits is not None else not masked
    assert encoded.mean.shape == encoded.log_variance.shape == (3, 6)
    assert encoded.middle.shape == middle.shape == (3, 4)


def test_samples_of_a_batch_do_not_mix(graphs: MeshGraphs) -> None:
    model = network(graphs)
    x, cvar = torch.randn(graphs.sizes[0], 3, 7), torch.randn(3, 5)
    together = model(x, cvar, None, "body")[0]
    alone = model(x[:, 1:2].contiguous(), cvar[1:2], None, "body")[0]
    assert alone.std() > 0.05
    assert torch.allclose(together[:, 1:2], alone, atol=1e-5)


def test_conditions_reach_the_decoder_only_through_the_middle(graphs: MeshGraphs) -> None:
    model = network(graphs)
    x, cvar = torch.randn(graphs.sizes[0], 1, 7), torch.randn(1, 5)
    with torch.no_grad():
        first = model(x, cvar, None, "body")[0]
        assert not torch.allclose(first, model(x, cvar + 1.0, None, "body")[0], atol=1e-4)
        model.conditioning.middle.weight.zero_()
        assert torch.equal(model(x, cvar, None, "body")[0], model(x, cvar + 1.0, None, "body")[0])


def test_gamma_cannot_rebuild_conditions_without_its_middle() -> None:
    torch.manual_seed(0)
    gamma = Conditioning(9, 4)
    with torch.no_grad():
        gamma.middle.weight.zero_()
    first, second = gamma(torch.randn(1, 9))[0], gamma(torch.randn(1, 9))[0]
    assert torch.equal(first, second)


def test_a_fresh_network_is_nearly_the_projection_on_its_modes(graphs: MeshGraphs) -> None:
    model, count = network(graphs), graphs.sizes[0]
    rng = np.random.default_rng(0)
    basis = np.linalg.qr(rng.standard_normal((count * 4, 3)))[0].reshape(count, 4, 3)
    centre = rng.standard_normal((count, 4)) * 0.1
    model.start_from(*(torch.from_numpy(a).float() for a in (centre, basis, np.array([9.0, 4.0, 2.0]))))
    garment = centre + basis @ np.array([12.0, -5.0, 2.5])
    x = torch.cat([torch.from_numpy(garment).float(), torch.zeros(count, 3)], dim=1)[:, None, :]
    with torch.no_grad():
        for parameter in (model.encoder.mean.weight, model.encoder.mean.bias, model.decoder.last.weight):
            parameter.zero_()
        offsets, logits, encoded, _ = model(x, torch.zeros(1, 5), None, "body")
    assert torch.allclose(encoded.mean[0, :3], torch.tensor([12 / 9, -5 / 4, 2.5 / 2]), atol=1e-3)
    assert torch.allclose(offsets[:, 0], torch.from_numpy(garment[:, :3]).float(), atol=1e-3)
    assert logits is not None
    assert torch.allclose(logits[:, 0], torch.from_numpy(8.0 * (garment[:, 3] - 0.5)).float(), atol=1e-2)


def test_learns_one_batch_by_heart(graphs: MeshGraphs) -> None:
    shape = Architecture(**{**vars(SHAPE), "modes": 0})
    model = network(graphs, shape)
    rng = np.random.default_rng(1)
    nodes = torch.from_numpy(rng.standard_normal((graphs.sizes[2], 4, 3))).float()
    target = graphs.unpool(graphs.unpool(nodes, 1), 0)
    x = torch.cat([target, torch.zeros(*target.shape[:2], 4)], dim=2)
    cvar = torch.from_numpy(rng.standard_normal((4, 5))).float()
    optimiser = torch.optim.Adam(model.parameters(), lr=1e-2)
    errors = []
    for _ in range(120):
        loss = (model(x, cvar, None, "body")[0] - target).abs().mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        errors.append(float(loss.detach()))
    assert errors[0] > 0.7
    assert errors[-1] < 0.25 * errors[0]
