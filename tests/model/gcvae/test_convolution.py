"""Chebyshev convolution, pooling and unpooling against plain dense algebra, forward and backward."""

import numpy as np
import pytest
import torch
from torch import Tensor

from model.gcvae.convolution import ChebyshevConvolution, ResidualBlock
from model.gcvae.graphs import MeshGraphs
from model.gcvae.hierarchy import Hierarchy

LEVEL = 2


def dense_convolution(convolution: ChebyshevConvolution, laplacian: Tensor, x: Tensor) -> Tensor:
    first, second = convolution.weight
    return torch.einsum("nbf,fg->nbg", x, first) + torch.einsum("nm,mbf,fg->nbg", laplacian, x, second)


@pytest.mark.parametrize("topology", ["body", "skirt"])
@pytest.mark.parametrize(("features_in", "features_out"), [(3, 8), (8, 3), (5, 5)])
def test_convolution_equals_dense(
    graphs: MeshGraphs, hierarchy: Hierarchy, topology: str, features_in: int, features_out: int
) -> None:
    torch.manual_seed(0)
    convolution = ChebyshevConvolution(graphs, LEVEL, features_in, features_out)
    laplacian = torch.from_numpy(hierarchy.laplacian(topology, LEVEL).toarray()).float()
    x = torch.randn(graphs.sizes[LEVEL], 2, features_in, requires_grad=True)
    expected = dense_convolution(convolution, laplacian, x)
    actual = convolution(x, topology)
    assert expected.detach().std() > 0.3
    assert torch.allclose(actual, expected, atol=1e-5)
    weight = torch.randn_like(expected)
    parameters = [x, convolution.weight]
    for a, b in zip(
        torch.autograd.grad((actual * weight).sum(), parameters),
        torch.autograd.grad((expected * weight).sum(), parameters),
    ):
        assert b.abs().max() > 1.0
        assert torch.allclose(a, b, atol=1e-4)


def test_topologies_filter_differently(graphs: MeshGraphs) -> None:
    convolution = ChebyshevConvolution(graphs, 0, 2, 2)
    x = torch.randn(graphs.sizes[0], 1, 2)
    change = (convolution(x, "body") - convolution(x, "skirt")).detach().abs().amax(dim=(1, 2))
    ring, side = np.divmod(np.arange(graphs.sizes[0]), 32)
    at_slit = torch.from_numpy(((side == 3) | (side == 4)) & (ring < 10))
    assert change[at_slit].mean() > 0.01
    assert change[at_slit].mean() > 10 * change[~at_slit].mean()


@pytest.mark.parametrize(("features_in", "features_out"), [(4, 2), (2, 4)])
def test_filtering_below_equals_unpooling_first(graphs: MeshGraphs, features_in: int, features_out: int) -> None:
    torch.manual_seed(1)
    block = ResidualBlock(graphs, 1, features_in, features_out, 1, True)
    with torch.no_grad():
        block.node_biases[0].normal_()
    x = torch.randn(graphs.sizes[2], 3, features_in)
    assert torch.allclose(block(x, "skirt", below=True), block(graphs.unpool(x, 1), "skirt"), atol=1e-5)


def test_pooling_takes_the_maximum_of_each_cluster(graphs: MeshGraphs, hierarchy: Hierarchy) -> None:
    x = torch.randn(graphs.sizes[1], 2, 3)
    pooled = graphs.pool(x, 1)
    for cluster in range(graphs.sizes[2]):
        members = torch.from_numpy(np.flatnonzero(hierarchy.maps[1] == cluster))
        assert torch.equal(pooled[cluster], x[members].amax(dim=0))


def test_gradient_of_pooling_reaches_the_maximum_and_ties_share(graphs: MeshGraphs) -> None:
    x = torch.randn(graphs.sizes[0], 1, 2, requires_grad=True)
    (gradient,) = torch.autograd.grad(graphs.pool(x, 0).sum(), x)
    assert gradient.sum() == 2 * graphs.sizes[1]
    assert set(gradient.unique().tolist()) == {0.0, 1.0}
    flat = torch.zeros(graphs.sizes[0], 1, 1, requires_grad=True)
    (shared,) = torch.autograd.grad(graphs.pool(flat, 0).sum(), flat)
    sizes = torch.bincount(graphs.clusters[0])[graphs.clusters[0]]
    assert torch.allclose(shared.flatten(), 1.0 / sizes)


def test_unpooling_copies_and_its_gradient_adds_up(graphs: MeshGraphs) -> None:
    x = torch.randn(graphs.sizes[3], 2, 2, requires_grad=True)
    copied = graphs.unpool(x, 2)
    assert torch.equal(copied, x[graphs.clusters[2]])
    weight = torch.randn_like(copied)
    (gradient,) = torch.autograd.grad((copied * weight).sum(), x)
    expected = torch.zeros_like(x).index_add_(0, graphs.clusters[2], weight)
    assert torch.allclose(gradient, expected, atol=1e-5)
