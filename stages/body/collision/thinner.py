"""The way to a thinner body, whatever the betas of a model mean."""

import numpy as np
from numpy.typing import NDArray

from model.body import BodyModel

STEP = 0.5
"""Difference in a beta from which its effect is told [standard deviations]."""


def thinner(model: BodyModel, betas: NDArray[np.float32], step: float, lowest: float = -3.0) -> NDArray[np.float32]:
    """The same person, less fat.

    The beta that changes girth most - volume over the cube of the stature - goes the way that reduces it; where it is
    at its end, the next one does. In SMPL and in the embedded body that is the second, overall fatness (CLOTH3D,
    Resizing); its sign is the model's own.

    Args:
        model: The body.
        betas: Shape coefficients, shape [B].
        step: How much thinner [standard deviations].
        lowest: No beta leaves [lowest, -lowest].

    Returns:
        Betas, shape [B]; the same if all are at their ends.
    """
    change = np.zeros(len(betas))
    for k in range(len(betas)):
        offset = np.zeros(len(betas))
        offset[k] = STEP
        change[k] = np.log(_girth(model, betas + offset)) - np.log(_girth(model, betas - offset))
    out = betas.astype(np.float64)
    for k in np.argsort(-np.abs(change), kind="stable"):
        goal = float(np.clip(out[k] - np.sign(change[k]) * step, lowest, -lowest))
        if abs(goal - out[k]) > 1e-6:
            out[k] = goal
            break
    return out.astype(np.float32)


def _girth(model: BodyModel, betas: NDArray[np.float64]) -> float:
    """Volume over the cube of the stature."""
    vertices, _ = model.shape(betas)
    a, b, c = (vertices[model.faces[:, k]].astype(np.float64) for k in range(3))
    volume = np.einsum("ni,ni->", a, np.cross(b, c)) / 6
    return float(volume / np.ptp(vertices[:, 1]) ** 3)
