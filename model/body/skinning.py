"""Forward kinematics and linear blend skinning, vectorised over frames."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.floating]

FRAMES_PER_CHUNK = 32
"""Frames skinned at a time: bounds the temporary arrays to about 10 MB for a body of 13,000 vertices."""


def rotation_matrices(pose: ArrayLike) -> NDArray[np.float64]:
    """Turns axis-angle vectors into rotation matrices.

    Args:
        pose: Axis-angle vectors [rad], shape [..., 3].

    Returns:
        Rotation matrices, shape [..., 3, 3].
    """
    vectors = np.array(pose, dtype=np.float64)  # a copy: scipy refuses read-only arrays
    return Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(*vectors.shape, 3)


def _joint_frames(joints: ArrayLike, parents: ArrayLike, pose: ArrayLike) -> NDArray[np.float64]:
    """World frames [T, K, 3, 4] of the joints: rotation in columns 0-2, position [m] in column 3."""
    joints = np.asarray(joints, dtype=np.float64)
    parents = np.asarray(parents)
    local = rotation_matrices(pose)
    if local.ndim != 4 or local.shape[1] != len(joints):
        raise ValueError(f"pose must have shape [T, {len(joints)}, 3], got {np.shape(pose)}")
    frames = np.empty((len(local), len(joints), 3, 4))
    for k, parent in enumerate(parents):
        if parent < 0:
            frames[:, k, :, :3] = local[:, k]
            frames[:, k, :, 3] = joints[k]
            continue
        frames[:, k, :, :3] = frames[:, parent, :, :3] @ local[:, k]
        frames[:, k, :, 3] = frames[:, parent, :, :3] @ (joints[k] - joints[parent]) + frames[:, parent, :, 3]
    return frames


def joint_transforms(joints: ArrayLike, parents: ArrayLike, pose: ArrayLike) -> NDArray[np.float64]:
    """Skinning transforms: what takes a point from the T-pose to where each joint would carry it.

    The root turns about its own rest position; the world translation is not part of these transforms.

    Args:
        joints: Joint positions in the T-pose [m], shape [K, 3].
        parents: Parent of each joint, -1 for the root, parents before children, shape [K].
        pose: Rotation of each joint relative to its parent, axis-angle [rad], shape [T, K, 3].

    Returns:
        Transforms [R | t] with t in metres, shape [T, K, 3, 4].

    Raises:
        ValueError: The pose does not have one rotation per joint and frame.

    Source: Loper et al., SMPL (2015), equations 2-4.
    """
    transforms = _joint_frames(joints, parents, pose)
    rest = np.asarray(joints, dtype=np.float64)
    transforms[..., 3] -= (transforms[..., :3] @ rest[:, :, None])[..., 0]
    return transforms


def joint_positions(
    joints: ArrayLike, parents: ArrayLike, pose: ArrayLike, trans: ArrayLike | None = None
) -> NDArray[np.float64]:
    """Posed joint positions.

    Args:
        joints: Joint positions in the T-pose [m], shape [K, 3].
        parents: Parent of each joint, -1 for the root, shape [K].
        pose: Axis-angle rotations relative to the parent [rad], shape [T, K, 3].
        trans: World position of the root joint [m], shape [T, 3]; left out, the root stays where the rest has it.

    Returns:
        Joint positions [m], shape [T, K, 3].
    """
    positions = _joint_frames(joints, parents, pose)[..., 3]
    if trans is not None:
        positions = positions - positions[:, :1] + np.asarray(trans, dtype=np.float64)[:, None]
    return positions


def skin(points: Array, weights: Array, transforms: Array) -> Array:
    """Linear blend skinning.

    For points that do not change from frame to frame, the whole chunk of frames is one matrix product:
    x'_n = sum_k w_nk T_k [x_n; 1] is linear in the entries of T_k, with coefficients w_nk [x_n; 1].

    Args:
        points: Points in the T-pose [m], shape [N, 3], or one set per frame, shape [T, N, 3].
        weights: Skinning weights, each row sums to 1, shape [N, K].
        transforms: Skinning transforms of `joint_transforms`, shape [T, K, 3, 4].

    Returns:
        Posed points [m], shape [T, N, 3], in the precision of `points`.
    """
    points = np.asarray(points)
    dtype = points.dtype if points.dtype in (np.float32, np.float64) else np.dtype(np.float64)
    weights = np.asarray(weights, dtype=dtype)
    transforms = np.asarray(transforms, dtype=dtype)
    if points.ndim == 2:
        return _skin_fixed(points.astype(dtype, copy=False), weights, transforms)
    return _skin_moving(points.astype(dtype, copy=False), weights, transforms)


def _skin_fixed(points: Array, weights: Array, transforms: Array) -> Array:
    """Skins the same points [N, 3] in every frame."""
    (n, _), k = points.shape, weights.shape[1]
    homogeneous = np.concatenate([points, np.ones((n, 1), points.dtype)], axis=1)
    coefficients = np.ascontiguousarray((weights[:, :, None] * homogeneous[:, None, :]).reshape(n, k * 4).T)
    out = np.empty((len(transforms), n, 3), points.dtype)
    for start in range(0, len(transforms), FRAMES_PER_CHUNK):
        chunk = transforms[start : start + FRAMES_PER_CHUNK]
        rows = np.ascontiguousarray(chunk.transpose(0, 2, 1, 3)).reshape(-1, k * 4)
        out[start : start + len(chunk)] = (rows @ coefficients).reshape(len(chunk), 3, n).transpose(0, 2, 1)
    return out


def _skin_moving(points: Array, weights: Array, transforms: Array) -> Array:
    """Skins points [T, N, 3] that pose correctives move before skinning."""
    out = np.empty_like(points)
    columns = np.ascontiguousarray(weights.T)
    for start in range(0, len(transforms), FRAMES_PER_CHUNK):
        chunk = transforms[start : start + FRAMES_PER_CHUNK]
        rows = np.ascontiguousarray(chunk.transpose(0, 2, 3, 1)).reshape(-1, len(columns))
        # Vertices last: all that follows runs along contiguous rows of them.
        blended = (rows @ columns).reshape(len(chunk), 3, 4, -1)
        x, y, z = np.ascontiguousarray(points[start : start + len(chunk)].transpose(2, 0, 1))
        for axis in range(3):
            turned = blended[:, axis, 0] * x + blended[:, axis, 1] * y + blended[:, axis, 2] * z
            out[start : start + len(chunk), :, axis] = turned + blended[:, axis, 3]
    return out
