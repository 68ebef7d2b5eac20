"""Rotations about the axes of the model frame (x to the person's left, y up, z forward), many at a time."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

WORLD_FROM_MODEL = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Quarter turn about x from the y-up frame that motion is made in to the z-up world; forward +z becomes -y."""


def turn(axis: str, angle: ArrayLike) -> NDArray[np.float64]:
    """Rotation matrices about one axis.

    Args:
        axis: `x` (positive bends forward), `y` (positive turns to the left) or `z` (positive leans to the right).
        angle: Angles [rad], shape [...].

    Returns:
        Matrices, shape [..., 3, 3].
    """
    angles = np.asarray(angle, dtype=np.float64)
    fixed = "xyz".index(axis)
    i, j = (fixed + 1) % 3, (fixed + 2) % 3
    out = np.zeros((*angles.shape, 3, 3))
    out[..., fixed, fixed] = 1.0
    out[..., i, i] = out[..., j, j] = np.cos(angles)
    out[..., j, i] = np.sin(angles)
    out[..., i, j] = -out[..., j, i]
    return out


def axis_angle(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Axis-angle vectors [rad], shape [..., 3], of rotation matrices, shape [..., 3, 3]."""
    return Rotation.from_matrix(matrices.reshape(-1, 3, 3)).as_rotvec().reshape(*matrices.shape[:-1])


def rotate(matrices: NDArray[np.float64], vectors: ArrayLike) -> NDArray[np.float64]:
    """Applies matrices [..., 3, 3] to vectors [..., 3]; the leading axes broadcast."""
    return np.einsum("...ij,...j->...i", matrices, np.asarray(vectors, dtype=np.float64))


def unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """The vectors at length 1, shape [..., 3]."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
