"""The conditioning network Gamma: an autoencoder whose middle layer, cvar^z, encoder and decoder share."""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional


class Conditioning(nn.Module):
    """cvar -> cvar^z -> cvar, trained first with L1 and then frozen (CLOTH3D, Architecture).

    Its one skip connection stays within the encoding half: a skip around the middle layer would let the conditions be
    reconstructed without passing through cvar^z.
    """

    def __init__(self, size: int, middle: int, hidden: int = 64) -> None:
        super().__init__()
        self.enter = nn.Linear(size, hidden)
        self.deepen = nn.Linear(hidden, hidden)
        self.middle = nn.Linear(hidden, middle)
        self.widen = nn.Linear(middle, hidden)
        self.leave = nn.Linear(hidden, size)

    def encode(self, cvar: Tensor) -> Tensor:
        """cvar^z (B, middle) of normalised conditions (B, size)."""
        first = functional.leaky_relu(self.enter(cvar), 0.1)
        second = functional.leaky_relu(self.deepen(first), 0.1) + first
        middle: Tensor = self.middle(second)
        return middle

    def forward(self, cvar: Tensor) -> tuple[Tensor, Tensor]:
        """Reconstructed conditions (B, size) and cvar^z (B, middle)."""
        middle = self.encode(cvar)
        return self.leave(functional.leaky_relu(self.widen(middle), 0.1)), middle
