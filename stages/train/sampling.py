"""Latent codes for new garments: from the prior, or from a Gaussian fitted to the codes of one type."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class CodeSampler:
    """Where the training garments lie in the latent space.

    With the little weight that the KL term has, their codes fill a small part of N(0, I), and a code from the prior is
    seldom a garment. A Gaussian for each type stays where the decoder has learned.

    Attributes:
        kinds: Garment types.
        means: Mean code of each type, shape (K, Z).
        factors: For each type its centred codes over the square root of their number, shape (S_k, Z): a random
            combination of them has the type's covariance.
        noises: Mean posterior variance of each type, shape (K, Z).
    """

    kinds: tuple[str, ...]
    means: NDArray[np.float32]
    factors: tuple[NDArray[np.float32], ...]
    noises: NDArray[np.float32]

    @classmethod
    def fit(cls, mean: NDArray[np.float32], log_variance: NDArray[np.float32], types: Sequence[str]) -> CodeSampler:
        """Gaussians of the aggregated posterior: codes (S, Z) with their log variances, by type."""
        kinds = tuple(sorted(set(types)))
        rows = [np.array([t == kind for t in types]) for kind in kinds]
        means = np.stack([mean[r].mean(axis=0) for r in rows])
        return cls(
            kinds=kinds,
            means=means,
            factors=tuple((mean[r] - m) / np.float32(np.sqrt(r.sum())) for r, m in zip(rows, means)),
            noises=np.stack([np.exp(log_variance[r]).mean(axis=0) for r in rows]),
        )

    def of_type(self, kind: str, temperature: float, rng: np.random.Generator) -> NDArray[np.float32]:
        """A code (Z,) of type `kind`, its deviation from the type's mean times `temperature`."""
        k = self.kinds.index(kind)
        factor = self.factors[k]
        spread = rng.standard_normal(len(factor)) @ factor
        noise = np.sqrt(self.noises[k]) * rng.standard_normal(len(spread))
        return np.asarray(self.means[k] + temperature * (spread + noise), np.float32)

    def nearest_type(self, code: NDArray[np.float32]) -> str:
        """The type whose mean code is closest to `code` (Z,): it tells which topology decodes a code of the prior."""
        return self.kinds[int(np.argmin(np.linalg.norm(self.means - code, axis=1)))]
