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
from model.gcvae.modes import MASK_GAIN, Modes


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
        modes: Principal modes of the linear path, at most `latent`; 0 for none.
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
    modes: int

    @property
    def outputs(self) -> int:
        """Channels of a vertex at the decoder's exit."""
        return 4 if self.masked else 3


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

    def __init__(self, graphs: MeshGraphs, shape: Architecture, modes: Modes) -> None:
        super().__init__()
        self.graphs, self.modes = graphs, modes
        self.garment_channels = list(range(shape.outputs))
        widths = (shape.inputs, *shape.widths)
        self.blocks = nn.ModuleList(
            ResidualBlock(graphs, level, widths[level], widths[level + 1], shape.depth, False)
            for level in range(len(shape.widths))
        )
        self.first = nn.Linear(graphs.sizes[-1] * shape.widths[-1] + shape.modes, shape.hidden)
        self.condition = nn.Sequential(nn.Linear(shape.hidden, 64), nn.LeakyReLU(0.1), nn.Linear(64, shape.middle))
        self.mean = nn.Linear(shape.hidden, shape.latent)
        self.log_variance = nn.Linear(shape.hidden, shape.latent)
        # A narrow posterior at the start lets the decoder learn from z before the KL term widens it.
        nn.init.zeros_(self.log_variance.weight)
        nn.init.constant_(self.log_variance.bias, -5.0)
        self.carry = nn.Parameter(torch.eye(shape.modes, shape.latent))

    def forward(self, x: Tensor, topology: str) -> Encoded:
        """Encodes x (N, B, inputs), offsets and mask in the first channels, on the graph of `topology`."""
        scores = self.modes.scores(x[..., self.garment_channels])
        for level, block in enumerate(self.blocks):
            if level:
                x = self.graphs.pool(x, level - 1)
            x = block(x, topology)
        flat = x.transpose(0, 1).reshape(x.shape[1], -1)
        first = functional.leaky_relu(self.first(torch.cat([flat, scores], dim=1)), 0.1)
        mean = self.mean(first) + scores @ self.carry
        return Encoded(mean, self.log_variance(first).clamp(-12.0, 6.0), self.condition(first))


class Decoder(nn.Module):
    """Phi: z and cvar^z -> normalised offsets and the mask's logits, as the channels of the last layer.

    The last layer adds `base` to each vertex: learned, and started from the mean of the training set, so that the
    network learns how a garment differs from the mean one.
    """

    def __init__(self, graphs: MeshGraphs, shape: Architecture, modes: Modes) -> None:
        super().__init__()
        self.graphs, self.masked, self.modes = graphs, shape.masked, modes
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
        self.last = ChebyshevConvolution(graphs, 0, widths[0], shape.outputs)
        self.base = nn.Parameter(torch.zeros(graphs.sizes[0], shape.outputs))
        # At the start the graph layers are nearly silent and z is the scores: the network begins as a PCA.
        self.scores = nn.Parameter(torch.eye(shape.latent + shape.middle, shape.modes))
        with torch.no_grad():
            self.last.weight.mul_(0.1)

    def forward(self, code: Tensor, middle: Tensor, topology: str) -> tuple[Tensor, Tensor | None]:
        """Offsets (N, B, 3) and logits (N, B), or None, of z (B, Z) and cvar^z (B, C)."""
        both = torch.cat([code, middle], dim=1)
        hidden = functional.leaky_relu(self.first(both), 0.1)
        x = self.second(hidden).view(len(code), self.graphs.sizes[-1], -1).transpose(0, 1)
        for k, block in enumerate(self.blocks):
            x = block(x, topology, below=k > 0)
        result = self.last(x, topology) + self.modes.fields(both @ self.scores) + self.base[:, None, :]
        return result[..., :3], result[..., 3] if self.masked else None


class GarmentVae(nn.Module):
    """One of the two networks: {z, cvar^z} = Psi(X, T), cvar^z = Gamma(cvar), {X, M} = Phi(z, cvar^z)."""

    def __init__(self, graphs: MeshGraphs, shape: Architecture) -> None:
        super().__init__()
        self.shape = shape
        self.conditioning = Conditioning(shape.conditions, shape.middle)
        self.modes = Modes(graphs.sizes[0], shape.outputs, shape.modes)
        self.encoder = Encoder(graphs, shape, self.modes)
        self.decoder = Decoder(graphs, shape, self.modes)

    def start_from(self, centre: Tensor, basis: Tensor, deviation: Tensor) -> None:
        """Sets the mean garment (N, C) and the linear path's modes (N, C, K) and deviations (K,), in normalised units.

        The channels are the offsets and, where the network predicts it, the mask as 0 or 1.
        """
        with torch.no_grad():
            self.modes.centre.copy_(centre)
            self.modes.basis.copy_(basis)
            self.modes.deviation.copy_(deviation)
            self.decoder.base.copy_(centre)
            if self.shape.masked:
                self.decoder.base[:, 3] = MASK_GAIN * (centre[:, 3] - 0.5)

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
