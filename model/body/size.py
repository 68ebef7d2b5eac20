"""Which betas of a body make it larger and fatter, and which way: every model has its own order and signs."""

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.body.model import BodyModel
from model.mesh.geometry import area_vectors

STEP = 1.0
"""Difference in a beta, to either side, from which its effect is told [standard deviations]."""

_DIRECTIONS: "WeakKeyDictionary[BodyModel, NDArray[np.float64]]" = WeakKeyDictionary()


def size_directions(model: BodyModel) -> NDArray[np.float64]:
    """The two directions of shape along which a body becomes larger, once per process and model.

    Size is the beta that changes the stature most; fatness, of the others, is the one that changes the girth most,
    which is volume over the cube of the stature. Each counts in the sense that the area of the skin grows: that of what
    is made for the body grows with it. In the embedded body the two are +beta_1 and +beta_2; SMPL's two models have the
    same betas with signs of their own (CLOTH3D, Resizing).

    Args:
        model: The body, with two betas at least.

    Returns:
        Betas that add one unit of size, and of fatness: all 0 but for a 1 or a -1, shape [2, B].
    """
    if model not in _DIRECTIONS:
        unit = STEP * np.eye(model.beta_count)
        larger, smaller = (np.log([_measures(model, sign * row) for row in unit]) for sign in (1, -1))
        stature, volume, area = (larger - smaller).T
        girth = np.abs(volume - 3 * stature)
        size = int(np.abs(stature).argmax())
        girth[size] = -1.0
        found = np.zeros((2, model.beta_count))
        for row, beta in enumerate((size, int(girth.argmax()))):
            found[row, beta] = 1.0 if area[beta] >= 0 else -1.0
        _DIRECTIONS[model] = found
    return _DIRECTIONS[model]


def _measures(model: BodyModel, betas: ArrayLike) -> tuple[float, float, float]:
    """Stature [m], volume [m^3] and area [m^2] of a shape."""
    points = model.shape(betas)[0].astype(np.float64)
    normals = area_vectors(points, model.faces)
    volume = np.einsum("fd,fd->", points[model.faces[:, 0]], normals) / 6
    return float(np.ptp(points[:, 1])), float(volume), float(np.linalg.norm(normals, axis=1).sum() / 2)
