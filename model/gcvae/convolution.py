"""Chebyshev graph convolution with K = 1 and the residual block built of it."""

from __future__ import annotations

import math
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from model.gcvae.graphs import MeshGraphs


class ChebyshevConvolution(nn.Module):
    """y = x W_0 + L^ x W_1 + b: the terms T_0 = I and T_1 = L^ of the Chebyshev expansion (CLOTH3D supplement, Eq. 1).

    K = 1 is the order of the polynomial, as in the paper. Libraries that count terms call the same filter K = 2.
    """

    def __init__(self, graphs: MeshGraphs, level: int, features_in: int, features_out: int) -> None:
        super().__init__()
        self.graphs, self.level = graphs, level
        bound = math.sqrt(3.0 / (2 * features_in))
        self.weight = nn.Parameter(torch.empty(2, features_in, features_out).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.zeros(features_out))

    def forward(self, x: Tensor, topology: str, below: bool = False) -> Tensor:
        """Filters x on the graph of `topology`, shape (N, B, F_out).

        Args:
            x: Features (N, B, F_in), or (M, B, F_in) of the next coarser level if `below`.
            topology: Which Laplacian to use.
            below: Whether to unpool x first. Copies and weights commute, so the weights are applied to the fewer rows.
        """
        graphs, (_, features_in, features_out) = self.graphs, self.weight.shape
        if features_out > features_in and not below:
            terms = torch.cat([x, graphs.laplace(x, topology, self.level)], dim=2)
            return terms @ self.weight.reshape(2 * features_in, features_out) + self.bias
        products = x @ self.weight.transpose(0, 1).reshape(features_in, 2 * features_out)
        if below:
            products = graphs.unpool(products, self.level)
        first, second = products.split(features_out, dim=2)
        return first + graphs.laplace(second, topology, self.level) + self.bias


class ResidualBlock(nn.Module):
    """Convolutions with leaky ReLU beside a skip connection.

    With `node_bias` every vertex adds a learned bias of its own to each convolution. Unpooling copies one feature
    vector to all members of a cluster, and a convolution with a 1-ring cannot tell them apart; the bias can.
    """

    def __init__(
        self, graphs: MeshGraphs, level: int, features_in: int, features_out: int, depth: int, node_bias: bool
    ) -> None:
        super().__init__()
        self.graphs, self.level = graphs, level
        widths = [features_in, *[features_out] * depth]
        self.convolutions = nn.ModuleList(ChebyshevConvolution(graphs, level, a, b) for a, b in pairwise(widths))
        nodes = graphs.sizes[level]
        self.node_biases = nn.ParameterList(
            nn.Parameter(torch.zeros(nodes, features_out)) for _ in range(depth if node_bias else 0)
        )
        self.skip = nn.Linear(features_in, features_out, bias=False) if features_in != features_out else nn.Identity()

    def forward(self, x: Tensor, topology: str, below: bool = False) -> Tensor:
        """Features (N, B, F_out) of x (N, B, F_in), or of x on the next coarser level if `below`."""
        hidden = x
        for k, convolution in enumerate(self.convolutions):
            hidden = convolution(hidden, topology, below and k == 0)
            if len(self.node_biases):
                hidden = hidden + self.node_biases[k][:, None, :]
            hidden = functional.leaky_relu(hidden, 0.1)
        skipped: Tensor = self.skip(x)
        return hidden + (self.graphs.unpool(skipped, self.level) if below else skipped)
