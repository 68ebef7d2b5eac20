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
