"""What a trained network must be compared with: the mean garment of each type, and principal components."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.train.samples import Samples

# A PCA of more samples than this sees an even selection of them: the Gram matrix grows with their square.
MOST_SAMPLES = 2000
# Components with less variance than this share of the first's are rounding, not shape.
SMALLEST_VARIANCE = 1e-7


@dataclass(frozen=True, kw_only=True)
class TypeMeans:
    """Mean offsets and mean mask of each garment type.

    Attributes:
        offsets: type -> mean of the continued offsets [m], shape (N, 3).
        mask: type -> share of the samples that cover each vertex, shape (N,).
        overall: Key of the mean of all samples, for a type that training never saw.
    """

    offsets: dict[str, NDArray[np.float32]]
    mask: dict[str, NDArray[np.float32]]
    overall: str = "all"

    @classmethod
    def fit(cls, samples: Samples) -> TypeMeans:
        """Means of the training samples."""
        kinds = {kind: np.array([t == kind for t in samples.types]) for kind in sorted(set(samples.types))}
        kinds["all"] = np.ones(len(samples), bool)
        return cls(
            offsets={kind: samples.target[rows].mean(axis=0) for kind, rows in kinds.items()},
            mask={
                kind: samples.mask[samples.garment[rows]].mean(axis=0, dtype=np.float32) for kind, rows in kinds.items()
            },
        )

    def __call__(self, kind: str) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Offsets [m] (N, 3) and mask (N,) that stand for any garment of type `kind`."""
        known = kind if kind in self.offsets else self.overall
        return self.offsets[known], self.mask[known] >= 0.5


@dataclass(frozen=True, kw_only=True)
class Components:
    """Principal components of offsets and mask together.

    Attributes:
        mean: Mean row [units of `scale`, then mask], shape (D,).
        basis: Orthonormal rows, largest variance first, shape (K, D).
        deviation: Standard deviation of the training samples' scores, shape (K,).
        scale: Length that the offsets are divided by [m].
        masked: Whether a row holds the mask after the offsets.
    """

    mean: NDArray[np.float32]
    basis: NDArray[np.float32]
    deviation: NDArray[np.float32]
    scale: float
    masked: bool

    @classmethod
    def fit(cls, samples: Samples, most: int, scale: float, masked: bool) -> Components:
        """At most `most` components of the training samples, and at most one less than there are samples."""
        chosen = np.unique(np.linspace(0, len(samples) - 1, min(len(samples), MOST_SAMPLES)).astype(np.int64))
        rows = feature_rows(samples, chosen, scale, masked)
        mean = rows.mean(axis=0)
        rows -= mean
        values, vectors = np.linalg.eigh((rows @ rows.T).astype(np.float64))
        order = np.argsort(values)[::-1][: min(most, len(chosen) - 1)]
        order = order[values[order] > SMALLEST_VARIANCE * values[-1]]
        basis = (vectors[:, order] / np.sqrt(values[order])).T.astype(np.float32) @ rows
        deviation = np.sqrt(values[order] / len(chosen)).astype(np.float32)
        return cls(mean=mean, basis=basis, deviation=deviation, scale=scale, masked=masked)

    def __call__(self, rows: NDArray[np.float32], size: int) -> tuple[NDArray[np.float32], NDArray[np.bool_] | None]:
        """Offsets [m] (B, N, 3) and masks (B, N) of rows (B, D) projected on the first `size` components."""
        basis = self.basis[:size]
        projected = self.mean + ((rows - self.mean) @ basis.T) @ basis
        count = projected.shape[1] // (4 if self.masked else 3)
        offsets = (projected[:, : 3 * count].reshape(len(rows), count, 3) * self.scale).astype(np.float32)
        return offsets, projected[:, 3 * count :] >= 0.5 if self.masked else None

    def per_vertex(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """Rows (K, D) as channels of vertices (K, N, 3 or 4): offsets and, if there is one, the mask."""
        count = rows.shape[1] // (4 if self.masked else 3)
        offsets = rows[:, : 3 * count].reshape(len(rows), count, 3)
        return np.concatenate([offsets, rows[:, 3 * count :, None]], axis=2) if self.masked else offsets


def feature_rows(samples: Samples, chosen: NDArray[np.int64], scale: float, masked: bool) -> NDArray[np.float32]:
    """Continued offsets in units of `scale` [m], then the mask, of the samples `chosen`; shape (B, D)."""
    parts = [(samples.target[chosen] / scale).astype(np.float32).reshape(len(chosen), -1)]
    if masked:
        parts.append(samples.mask[samples.garment[chosen]].astype(np.float32))
    return np.concatenate(parts, axis=1)
