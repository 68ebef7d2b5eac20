"""The linear path of the networks: principal modes of the training garments, beside the graph layers."""

from __future__ import annotations

import torch
from torch import Tensor, nn

# Logits of a mask channel rebuilt from modes: gain x (value - 1/2), so that a rebuilt value over one half is garment.
MASK_GAIN = 8.0


class Modes(nn.Module):
    """Fixed orthonormal modes over vertices and channels, with the deviation of their scores in training.

    A graph network of this depth needs many samples until it rebuilds what a few principal components rebuild at
    once. With modes, z starts as their scores and the graph layers learn the rest; with none (K = 0) the network is
    the paper's.

    Attributes:
        centre: Mean of the training samples, shape (N, C).
        basis: Modes, orthonormal over N x C, shape (N, C, K).
        deviation: Standard deviation of each score in training, shape (K,).
    """

    centre: Tensor
    basis: Tensor
    deviation: Tensor

    def __init__(self, nodes: int, channels: int, count: int) -> None:
        super().__init__()
        self.register_buffer("centre", torch.zeros(nodes, channels))
        self.register_buffer("basis", torch.zeros(nodes, channels, count))
        self.register_buffer("deviation", torch.ones(count))

    def scores(self, values: Tensor) -> Tensor:
        """Scores (B, K) in units of their deviation of normalised offsets and mask (N, B, C)."""
        centred = (values - self.centre[:, None, :]).transpose(0, 1).flatten(1)
        return centred @ self.basis.flatten(0, 1) / self.deviation

    def fields(self, scores: Tensor) -> Tensor:
        """What scores (B, K) add to the mean: offsets and, in the fourth channel, logits of the mask (N, B, C)."""
        nodes, channels, _ = self.basis.shape
        flat = (scores * self.deviation) @ self.basis.flatten(0, 1).T
        fields = flat.view(-1, nodes, channels).transpose(0, 1)
        return fields * fields.new_tensor([1.0, 1.0, 1.0, MASK_GAIN][:channels])
