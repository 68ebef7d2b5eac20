"""Parts of the body that may run into each other, thinned to what a fast test of every frame needs."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.body import BodyModel, joint_transforms, skin
from stages.body.collision.vectors import dot

Array = NDArray[np.float64]

SPACING = 0.014
"""Distance between the points kept of a part [m]: the surface between them bulges by less than 1 mm."""

COARSE = 0.022
"""The same for points that are only tested against another part [m]."""

ARM_START = 0.45
"""Share of the upper arm, from the shoulder, that may lie in the crease of the armpit."""

LEG_START = 0.22
"""Share of the thigh, from the hip, that may lie in the crease of the crotch."""

ARMS = ((16, 18, 20, 22), (17, 19, 21, 23))
LEGS = ((1, 4, 7, 10), (2, 5, 8, 11))
TRUNK = (0, 3, 6, 9, 12, 13, 14, 15, 1, 2, 4, 5)
"""Joints whose skin an arm must not run into: all but the arms and feet."""


@dataclass(frozen=True, eq=False)
class Part:
    """Points of the skin with their normals, in the T-pose of one person."""

    points: NDArray[np.float32]
    """Positions [m], shape [N, 3]."""
    normals: NDArray[np.float32]
    """Outward normals, shape [N, 3]."""
    weights: NDArray[np.float32]
    """Skinning weights, shape [N, 24]."""

    @cached_property
    def joints(self) -> NDArray[np.int64]:
        """The joints that move it: a leg hangs on six of them, not on all."""
        return np.flatnonzero(self.weights.any(axis=0))

    def posed(self, transforms: Array) -> NDArray[np.float32]:
        """Points [m], shape [T, N, 3], for skinning transforms [T, 24, 3, 4]."""
        return skin(self.points, self.weights[:, self.joints], transforms[:, self.joints]).astype(np.float32)

    def normals_in(self, transforms: Array, rows: NDArray[np.int64]) -> NDArray[np.float32]:
        """Normals of the points `rows` [N], shape [N, 3], for skinning transforms [24, 3, 4] of one frame."""
        turning = transforms[self.joints, :, :3].astype(np.float32).reshape(-1, 9)
        turned = (self.weights[np.ix_(rows, self.joints)] @ turning).reshape(-1, 3, 3)
        normals = (turned @ self.normals[rows][:, :, None])[:, :, 0]
        return np.asarray(normals / np.sqrt(dot(normals, normals))[:, None])


@dataclass(frozen=True, eq=False)
class Parts:
    """What is tested: each arm against the trunk, each leg against the other."""

    joints: Array
    """Joints in the T-pose [m], shape [24, 3]."""
    parents: NDArray[np.int32]
    """Parent of each joint, shape [24]."""
    trunk: Part
    arms: tuple[Part, Part]
    legs: tuple[Part, Part]

    def transforms(self, pose: Array) -> Array:
        """Skinning transforms [T, 24, 3, 4] of poses [T, 24, 3], the root joint at its rest position."""
        return np.asarray(joint_transforms(self.joints, self.parents, pose))


def divide(model: BodyModel, betas: ArrayLike, left_out: Collection[int] = ()) -> Parts:
    """Divides a person into parts by the joint that moves each vertex most.

    Args:
        model: The body.
        betas: Shape coefficients, shape [B].
        left_out: Joints of the arms whose skin is in nobody's way.

    Returns:
        The parts.
    """
    vertices, joints = model.shape(betas)
    owner = model.weights.argmax(axis=1)
    normals = _normals(vertices, model.faces)

    def part(chosen: NDArray[np.bool_], spacing: float) -> Part:
        rows = _thinned(vertices, np.flatnonzero(chosen), spacing)
        return Part(points=vertices[rows], normals=normals[rows], weights=model.weights[rows])

    arms, legs = [], []
    for side in (0, 1):
        upper, fore = ARMS[side][:2]
        along = np.abs(vertices[:, 0] - joints[upper, 0]) / abs(joints[fore, 0] - joints[upper, 0])
        kept = [joint for joint in ARMS[side] if joint not in left_out]
        arms.append(part(_of(owner, kept) & ((owner != upper) | (along > ARM_START)), COARSE))
        hip, knee = LEGS[side][:2]
        along = (joints[hip, 1] - vertices[:, 1]) / (joints[hip, 1] - joints[knee, 1])
        legs.append(part(_of(owner, LEGS[side]) & ((owner != hip) | (along > LEG_START)), SPACING))
    return Parts(
        joints=joints,
        parents=model.parents,
        trunk=part(_of(owner, TRUNK), SPACING),
        arms=(arms[0], arms[1]),
        legs=(legs[0], legs[1]),
    )


def _of(owner: NDArray[np.int64], joints: Iterable[int]) -> NDArray[np.bool_]:
    return np.isin(owner, list(joints))


def _normals(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> NDArray[np.float32]:
    """Unit vertex normals, weighted by area, shape [V, 3]."""
    corners = vertices[faces]
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    out = np.zeros_like(vertices)
    for i in range(3):
        np.add.at(out, faces[:, i], crossed)
    return np.asarray(out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12), dtype=np.float32)


def _thinned(vertices: NDArray[np.float32], rows: NDArray[np.int64], spacing: float) -> NDArray[np.int64]:
    """One vertex of each cube of side `spacing`: rows of `vertices`, ascending."""
    cubes = np.floor(vertices[rows] / spacing).astype(np.int64)
    cubes -= cubes.min(axis=0, initial=0)
    _, first = np.unique(np.ravel_multi_index(tuple(cubes.T), cubes.max(axis=0, initial=0) + 1), return_index=True)
    return np.sort(rows[first])
