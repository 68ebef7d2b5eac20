"""The guided shape basis: stature first, fatness second, then what varies most among the rest."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BETA_COUNT = 10


@dataclass(frozen=True, eq=False)
class ShapeBasis:
    """A linear shape space around the mean."""

    mean: NDArray[np.float64]
    """Mean positions [m], shape [N, 3]."""
    directions: NDArray[np.float64]
    """Displacement per standard deviation [m], shape [B, N, 3]."""


def signed_volume(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> float:
    """Volume that a closed surface encloses [m^3], positive for outward winding."""
    a, b, c = (vertices[faces[:, i]].astype(np.float64) for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def body_mass_index(vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> float:
    """Mass over squared stature [kg/m^2] at the density of water, 1000 kg/m^3, for a body that stands along y."""
    used = vertices[np.unique(faces)]
    return 1000.0 * signed_volume(vertices, faces) / float(np.ptp(used[:, 1])) ** 2


def guided_basis(samples: NDArray[np.float32], stature: NDArray[np.float64], bmi: NDArray[np.float64]) -> ShapeBasis:
    """Regresses stature and body mass index out of a population, then takes principal components of what is left.

    Plain principal components put fatness on their fourth axis; garments need it on the second, where SMPL's is.

    Args:
        samples: Bodies [m], shape [S, N, 3].
        stature: Stature of each [m], shape [S].
        bmi: Body mass index of each [kg/m^2], shape [S].

    Returns:
        The basis; each coefficient has unit standard deviation over the population.
    """
    count = len(samples)
    mean = samples.mean(axis=0, dtype=np.float64)
    deviations = (samples - mean).reshape(count, -1)
    guides = np.stack([(g - g.mean()) / g.std() for g in (stature, bmi)], axis=1)
    guided = np.linalg.lstsq(guides, deviations, rcond=None)[0]
    residual = deviations - guides @ guided

    # Principal components through the small Gram matrix: S is far below 3 N.
    values, vectors = np.linalg.eigh(residual @ residual.T)
    leading = np.argsort(values)[::-1][: BETA_COUNT - 2]
    components = vectors[:, leading].T @ residual / np.sqrt(count)
    components *= np.where(components.sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
    return ShapeBasis(mean, np.concatenate([guided, components]).reshape(BETA_COUNT, -1, 3))
