"""The way to a thinner body, whatever the betas of a model mean."""

import numpy as np
from numpy.typing import NDArray

from model.body import BodyModel
from model.body.size import size_directions


def thinner(model: BodyModel, betas: NDArray[np.float32], step: float, lowest: float = -3.0) -> NDArray[np.float32]:
    """The same person, less fat: the beta of overall fatness goes the way that reduces it (CLOTH3D, Resizing).

    Args:
        model: The body.
        betas: Shape coefficients, shape [B].
        step: How much thinner [standard deviations].
        lowest: No beta leaves [lowest, -lowest].

    Returns:
        Betas, shape [B]; the same if that one is at its end.
    """
    fatness = size_directions(model)[1]
    slim = np.clip(betas - step * fatness, lowest, -lowest)
    return np.where(fatness != 0, slim, betas).astype(np.float32)
