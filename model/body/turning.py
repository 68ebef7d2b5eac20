"""The rotations nearest to blended ones: how skinning turns the neighbourhood of each vertex."""

import numpy as np
from numpy.typing import NDArray

ROUNDS = 8
"""Newton rounds of the polar factor: enough for 1e-7 unless a blend is nearly singular."""

SINGULAR = 1e-3
"""Determinant below which a blend of rotations has no usable polar factor: opposite rotations cancelled out."""


def nearest_rotations(blends: NDArray[np.float64], fallback: NDArray[np.float64]) -> NDArray[np.float64]:
    """Polar factors of blended rotations, shape [N, 3, 3]; `fallback` where a blend is singular.

    The blend of two rotations phi apart shrinks lengths by cos(phi / 2), so that inverting it blows up noise where
    joints bend most. Its polar factor is isometric, and inverted by its transpose.

    Newton's iteration X <- (X + X^-T) / 2 (Higham 1986), all at once; the inverse transpose comes from cross products
    of the rows.
    """
    x = np.ascontiguousarray(blends.transpose(1, 2, 0))  # the N vertices last: every operation runs along them
    singular = np.sum(x[0] * _cofactors(x)[0], axis=0) < SINGULAR
    x[:, :, singular] = fallback[singular].transpose(1, 2, 0)
    for _ in range(ROUNDS):
        cofactors = _cofactors(x)
        x = 0.5 * (x + cofactors / np.sum(x[0] * cofactors[0], axis=0))
    return x.transpose(2, 0, 1)


def _cofactors(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Determinant times inverse transpose of the matrices x, shape [3, 3, N]."""
    out = np.empty_like(x)
    for i in range(3):
        p, q = x[(i + 1) % 3], x[(i + 2) % 3]
        for j in range(3):
            k, m = (j + 1) % 3, (j + 2) % 3
            out[i, j] = p[k] * q[m] - p[m] * q[k]
    return out
