"""How skinning turns the neighbourhood of each vertex between two poses."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.body.model import BodyModel
from model.body.skinning import joint_transforms

ROUNDS = 8
"""Newton rounds of the polar factor: enough for 1e-7 unless a blend is nearly singular."""

SINGULAR = 1e-3
"""Determinant below which a blend of rotations has no usable polar factor: opposite rotations cancelled out."""


def vertex_turns(model: BodyModel, pose: ArrayLike, rest_pose: ArrayLike) -> NDArray[np.float32]:
    """Rotation of each vertex' neighbourhood from the rest pose to each frame.

    The blended transform of a vertex is no rotation. For two bones of equal weight its smallest singular value is
    cos(phi / 2), so that inverting it blows up noise where joints bend most. Its polar factor is the nearest rotation:
    isometric, and inverted by its transpose.

    Args:
        model: Body model; only its skeleton and weights matter.
        pose: Rotation of each joint relative to its parent, axis-angle [rad], shape [T, K, 3].
        rest_pose: The same for the rest pose, shape [K, 3].

    Returns:
        Rotations that take directions of the rest pose to the frames, shape [T, N, 3, 3].

    Source: CLOTH3D, supplement, Wrinkle factorization, with the inverse kinematic function made isometric.
    """
    poses = np.concatenate([np.asarray(rest_pose, np.float64)[None], np.asarray(pose, np.float64)])
    rotations = joint_transforms(model.joint_template, model.parents, poses)[..., :3]
    weights = np.asarray(model.weights, np.float64)
    strongest = weights.argmax(axis=1)
    turns = np.empty((len(poses) - 1, len(weights), 3, 3), np.float32)
    at_rest = np.empty(0)
    for t, frame in enumerate(rotations):
        nearest = nearest_rotations((weights @ frame.reshape(-1, 9)).reshape(-1, 3, 3), frame[strongest])
        if t == 0:
            at_rest = np.swapaxes(nearest, 1, 2)
        else:
            turns[t - 1] = nearest @ at_rest
    return turns


def nearest_rotations(blends: NDArray[np.float64], fallback: NDArray[np.float64]) -> NDArray[np.float64]:
    """Polar factors of blended rotations, shape [N, 3, 3]; `fallback` where a blend is singular.

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
