"""Draws the shape of a person."""

import numpy as np
from numpy.typing import NDArray

from stages.body.config import BETA_COUNT


def draw_betas(
    shape_range: tuple[float, float], pinned: tuple[float, ...], rng: np.random.Generator
) -> NDArray[np.float32]:
    """Shape coefficients of one person, uniform in a range (CLOTH3D, Human 3D Sequences).

    Args:
        shape_range: Lowest and highest value.
        pinned: Values of the first betas that are given.
        rng: Generator; it is advanced equally whatever is pinned.

    Returns:
        Betas, shape [10].
    """
    betas = rng.uniform(*shape_range, size=BETA_COUNT).astype(np.float32)
    betas[: len(pinned)] = pinned
    return betas
