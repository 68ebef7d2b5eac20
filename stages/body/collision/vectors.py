"""Products of many short vectors, faster than NumPy's general ones."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = TypeVar("Array", NDArray[np.float32], NDArray[np.float64])


def cross(a: Array, b: Array) -> Array:
    """Cross products, shape [..., 3]."""
    out = np.empty_like(a)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[..., k] = a[..., i] * b[..., j] - a[..., j] * b[..., i]
    return out


def dot(a: Array, b: Array) -> Array:
    """Inner products, shape [...]."""
    out: Array = a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
    return out


def squares(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
    """Squared distances of all points a [N, 3] to all points b [M, 3], shape [N, M], good to 1e-7 of their extent's.

    One product of matrices, (-2 a, |a|^2, 1) (b, 1, |b|^2)^T, which for some hundred points is faster than any tree.
    """
    left, right = np.ones((len(a), 5), np.float32), np.ones((5, len(b)), np.float32)
    middle = b[len(b) // 2]
    a, b = a - middle, b - middle
    left[:, :3], left[:, 3] = -2 * a, dot(a, a)
    right[:3], right[4] = b.T, dot(b, b)
    out: NDArray[np.float32] = left @ right
    return out
