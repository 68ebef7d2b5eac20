"""SVAE and DVAE: encoder Psi, conditioning Gamma and decoder Phi on the layer's mesh hierarchy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from model.gcvae.conditioning import Conditioning
from model.gcvae.convolution import ChebyshevConvolution, ResidualBlock
from model.gcvae.graphs import MeshGraphs


@dataclass(frozen=True, kw_only=True)
class Architecture:
    """Sizes of one network; enough to build it again before its weights are loaded.

    Attributes:
        inputs: Channels of a vertex at the encoder's entry.
        masked: Whether the decoder also predicts the mask (SVAE does, DVAE does not).
        conditions: Numbers in cvar.
        middle: Numbers in cvar^z.
        latent: Numbers in z.
        hidden: Width of the encoder's first fully connected layer.
        widths: Features of each level, finest first.
        depth: Convolutions of each block.
        node_bias: Whether the decoder's vertices have biases of their own.
    """

    inputs: int
    masked: bool
    conditions: int
    middle: int
    latent: int
    hidden: int
    widths: tuple[int, ...]
    depth: int
    node_bias: bool


class Encoded(NamedTuple):
    """What the encoder says of a batch.

    Attributes:
        mean: Mean of q(z | X, cvar), shape (B, Z).
        log_variance: Logarithm of its variance, shape (B, Z).
        middle: Regressed cvar^z, shape (B, C).
    """

    mean: Tensor
    log_variance: Tensor
    middle: Tensor


class Encoder(nn.Module):
    """Psi: garment and body on the mesh -> q(z) and a regressed cvar^z."""

    def __init__(self, graphs: MeshGraphs, shape: Architecture) -> None:
        super().__init__()
        self.graphs = graphs
        widths = (shape.inputs, *shape.widths)
        self.blocks = nn.ModuleList(
            ResidualBlock(graphs, level, widths[level], widths[level + 1], shape.depth, False)
            for level in range(len(shape.widths))
        )
        self.first = nn.Linear(graphs.sizes[-1] * shape.widths[-1], shape.hidden)
        self.condition = nn.Sequential(nn.Linear(shape.hidden, 64), nn.LeakyReLU(0.1), nn.Linear(64, shape.middle))
        self.mean = nn.Linear(shape.hidden, shape.latent)
        self.log_variance = nn.Linear(shape.hidden, shape.latent)
        # A narrow posterior at the start lets the decoder learn from z before the KL term widens it.
        nn.init.zeros_(self.log_variance.weight)
        nn.init.constant_(self.log_variance.bias, -3.0)

    def forward(self, x: Tensor, topology: str) -> Encoded:
        """Encodes x (N, B, inputs) on the graph of `topology`."""
        for level, block in enumerate(self.blocks):
            if level:
                x = self.graphs.pool(x, level - 1)
            x = block(x, topology)
        flat = x.transpose(0, 1).reshape(x.shape[1], -1)
        first = functional.leaky_relu(self.first(flat), 0.1)
        return Encoded(self.mean(first), self.log_variance(first).clamp(-12.0, 6.0), self.condition(first))


class Decoder(nn.Module):
    """Phi: z and cvar^z -> normalised offsets and the mask's logits, in two branches of the last layer.

    The last layer adds `base` to each vertex: learned, and started from the mean of the training set by `start_from`,
    so that the network learns how a garment differs from the mean one.
    """

    def __init__(self, graphs: MeshGraphs, shape: Architecture) -> None:
        super().__init__()
        self.graphs, self.masked = graphs, shape.masked
        widths = shape.widths
        self.first = nn.Linear(shape.latent + shape.middle, shape.hidden)
        self.second = nn.Linear(shape.hidden, graphs.sizes[-1] * widths[-1])
        levels = range(len(widths) - 1, -1, -1)
        self.blocks = nn.ModuleList(
            ResidualBlock(
                graphs, level, widths[min(level + 1, len(widths) - 1)], widths[level], shape.depth, shape.node_bias
            )
            for level in levels
        )
        self.offsets = ChebyshevConvolution(graphs, 0, widths[0], 3)
        self.mask = ChebyshevConvolution(graphs, 0, widths[0], 1) if shape.masked else None
        self.base = nn.Parameter(torch.zeros(graphs.sizes[0], 4 if shape.masked else 3))

    def start_from(self, offsets: Tensor, mask: Tensor | None) -> None:
        """Sets the last bias to the mean normalised offsets (N, 3) and the log odds of the mean mask (N,)."""
        with torch.no_grad():
            self.base[:, :3] = offsets
            if mask is not None:
                self.base[:, 3] = torch.logit(mask, eps=0.02)

    def forward(self, code: Tensor, middle: Tensor, topology: str) -> tuple[Tensor, Tensor | None]:
        """Offsets (N, B, 3) and logits (N, B), or None, of z (B, Z) and cvar^z (B, C)."""
        hidden = functional.leaky_relu(self.first(torch.cat([code, middle], dim=1)), 0.1)
        x = self.second(hidden).view(len(code), self.graphs.sizes[-1], -1).transpose(0, 1)
        for k, block in enumerate(self.blocks):
            if k:
                x = self.graphs.unpool(x, len(self.blocks) - 1 - k)
            x = block(x, topology)
        offsets = self.offsets(x, topology) + self.base[:, None, :3]
        if self.mask is None:
            return offsets, None
        return offsets, self.mask(x, topology).squeeze(2) + self.base[:, 3, None]


class GarmentVae(nn.Module):
    """One of the two networks: {z, cvar^z} = Psi(X, T), cvar^z = Gamma(cvar), {X, M} = Phi(z, cvar^z)."""

    def __init__(self, graphs: MeshGraphs, shape: Architecture) -> None:
        super().__init__()
        self.shape = shape
        self.conditioning = Conditioning(shape.conditions, shape.middle)
        self.encoder = Encoder(graphs, shape)
        self.decoder = Decoder(graphs, shape)

    def forward(
        self, x: Tensor, cvar: Tensor, noise: Tensor | None, topology: str
    ) -> tuple[Tensor, Tensor | None, Encoded, Tensor]:
        """Offsets, mask logits, posterior and Gamma's cvar^z of a batch; `noise` (B, Z) samples z, None takes its mean.

        The decoder sees Gamma's cvar^z, not the regressed one: at generation there is no garment to encode.
        """
        with torch.no_grad():
            middle = self.conditioning.encode(cvar)
        encoded = self.encoder(x, topology)
        code = encoded.mean
        if noise is not None:
            code = code + noise * torch.exp(0.5 * encoded.log_variance)
        offsets, mask = self.decoder(code, middle, topology)
        return offsets, mask, encoded, middle
