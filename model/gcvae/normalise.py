"""Units of the networks: one global scale for offsets, and standardised conditions; fitted on training samples only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Conditions that hardly vary in the training set are not blown up to unit variance.
SMALLEST_DEVIATION = 0.1
# The same for bodies: the training set may hold one person only [m].
SMALLEST_BODY_DEVIATION = 0.02
# Conditions beyond the training set's are brought to its edge [standard deviations]: a network cannot extrapolate.
WIDEST = 3.0


@dataclass(frozen=True, kw_only=True)
class Normaliser:
    """Scales of one network's numbers.

    Offsets are only divided: without a shift zero stays the skin, and the sign of an offset against the body's normal
    keeps its meaning.

    Attributes:
        offset_scale: Root mean square of the training offsets inside the garments [m].
        body_mean: Mean rest body of the training samples [m], shape (N, 3).
        body_scale: Root mean square deviation of rest bodies from it [m].
        cvar_mean: Mean conditions, shape (C,).
        cvar_scale: Their deviation, at least `SMALLEST_DEVIATION`, shape (C,).
    """

    offset_scale: float
    body_mean: NDArray[np.float32]
    body_scale: float
    cvar_mean: NDArray[np.float32]
    cvar_scale: NDArray[np.float32]

    @classmethod
    def fit(
        cls,
        offsets: NDArray[np.float32],
        mask: NDArray[np.bool_],
        bodies: NDArray[np.float32],
        cvar: NDArray[np.float32],
    ) -> Normaliser:
        """Scales of offsets (S, N, 3) inside masks (S, N), bodies (W, N, 3) and conditions (S, C)."""
        body_mean = bodies.mean(axis=0)
        square = sum(float(np.square(o[m], dtype=np.float64).sum()) for o, m in zip(offsets, mask))
        return cls(
            offset_scale=max(float(np.sqrt(square / max(int(mask.sum()) * 3, 1))), 1e-4),
            body_mean=body_mean,
            body_scale=max(float(np.sqrt(np.mean((bodies - body_mean) ** 2))), SMALLEST_BODY_DEVIATION),
            cvar_mean=cvar.mean(axis=0),
            cvar_scale=np.maximum(cvar.std(axis=0), SMALLEST_DEVIATION).astype(np.float32),
        )

    def conditions(self, cvar: NDArray[np.float32]) -> NDArray[np.float32]:
        """Standardised conditions (B, C), within `WIDEST` deviations."""
        return np.clip((cvar - self.cvar_mean) / self.cvar_scale, -WIDEST, WIDEST).astype(np.float32)

    def arrays(self) -> dict[str, NDArray]:
        """What a shard stores."""
        return {
            "offset_scale": np.array(self.offset_scale),
            "body_mean": self.body_mean,
            "body_scale": np.array(self.body_scale),
            "cvar_mean": self.cvar_mean,
            "cvar_scale": self.cvar_scale,
        }

    @classmethod
    def from_arrays(cls, stored: Mapping[str, NDArray]) -> Normaliser:
        """The scales that `arrays` described."""
        return cls(
            offset_scale=float(stored["offset_scale"]),
            body_mean=stored["body_mean"],
            body_scale=float(stored["body_scale"]),
            cvar_mean=stored["cvar_mean"],
            cvar_scale=stored["cvar_scale"],
        )
