"""Garments as offsets from the posed layer, and the form of these offsets that does not depend on the pose.

Notation: T the layer, C_s the garment in the rest pose, C_d the garment in a frame. K takes points of the rest pose to
the frame with the layer's skinning, one affine map M_i = B_i(frame) B_i(rest)^-1 per vertex; R_i is the rotation
nearest to M_i's linear part.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.body import REST_POSE, joint_transforms
from model.body.layer import GarmentLayer
from model.body.turning import nearest_rotations
from model.mesh.operators import harmonic_fill
from model.mesh.topology import edge_list

Array = NDArray[np.float64]


def extract_offsets(garment: ArrayLike, layer: ArrayLike, mask: ArrayLike) -> NDArray[np.floating]:
    """Offsets of a registered garment from the layer in the same pose.

    Args:
        garment: Registered garment [m], shape [..., N, 3].
        layer: Layer in the same pose and frame of reference [m], shape [..., N, 3].
        mask: Vertices that the garment covers, shape [N].

    Returns:
        Offsets along the world's axes [m], shape [..., N, 3]; 0 outside the mask.
    """
    return np.where(np.asarray(mask)[:, None], np.asarray(garment) - np.asarray(layer), 0.0)


def apply_offsets(layer: ArrayLike, offsets: ArrayLike) -> NDArray[np.floating]:
    """The registered garment [m], shape [..., N, 3], of a layer and its offsets; only its masked part is cloth."""
    return np.asarray(layer) + np.asarray(offsets)


def garment_weights(layer: GarmentLayer, topology: str) -> NDArray[np.float64]:
    """Skinning weights for cloth of a topology, rows sum to 1, shape [N, K].

    On a skirt the inner sides of the legs lie next to each other, one moved by the left leg and one by the right. There
    the weights are the smoothest ones between the outer sides, so that K bends a skirt without tearing it.
    """
    weights = np.asarray(layer.model.weights, dtype=np.float64)
    if topology == "skirt":
        weights = np.clip(harmonic_fill(edge_list(layer.skirt_faces), weights, layer.inner_leg), 0.0, None)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


@dataclass(frozen=True, eq=False, kw_only=True)
class RestToPose:
    """The map K of a sequence, from the rest frame to frames with the root joint at the origin.

    Attributes:
        linear: Linear parts of M, shape [T, N, 3, 3].
        shift: Translations of M [m], shape [T, N, 3].
        rotation: R, shape [T, N, 3, 3].
    """

    linear: Array
    shift: Array
    rotation: Array

    def carry(self, rest: ArrayLike) -> Array:
        """K(C): points of the rest pose [m], shape [N, 3], in every frame [m], shape [T, N, 3]."""
        return _times(self.linear, np.asarray(rest, dtype=np.float64)) + self.shift

    def unpose(self, dynamic: ArrayLike, static: ArrayLike) -> Array:
        """X_new = R^T (C_d - K(C_s)): what the cloth does beyond following the body, along the rest frame's axes.

        Args:
            dynamic: C_d, root-relative [m], shape [T, N, 3].
            static: C_s in the rest frame [m], shape [N, 3].

        Returns:
            X_new [m], shape [T, N, 3]: as long as the difference it stands for.
        """
        return _times(np.swapaxes(self.rotation, -1, -2), np.asarray(dynamic, dtype=np.float64) - self.carry(static))

    def repose(self, offsets: ArrayLike, static: ArrayLike) -> Array:
        """C_d = R X_new + K(C_s): the exact inverse of `unpose`, root-relative [m], shape [T, N, 3]."""
        return _times(self.rotation, np.asarray(offsets, dtype=np.float64)) + self.carry(static)

    def unpose_exactly(self, dynamic: ArrayLike, static: ArrayLike) -> Array:
        """X_new = K^-1(C_d) - C_s, as CLOTH3D states it (supplement, Wrinkle factorization).

        Where two bones bend by phi, K shrinks by cos(phi / 2) in one direction and K^-1 magnifies noise as much; prefer
        `unpose`. Arguments and result as there.

        Raises:
            numpy.linalg.LinAlgError: A vertex lies between two bones that are turned by exactly 180 degrees.
        """
        moved = np.asarray(dynamic, dtype=np.float64) - self.shift
        return np.asarray(np.linalg.solve(self.linear, moved[..., None])[..., 0] - np.asarray(static))

    def repose_exactly(self, offsets: ArrayLike, static: ArrayLike) -> Array:
        """C_d = K(X_new + C_s): the inverse of `unpose_exactly`."""
        return _times(self.linear, np.asarray(offsets) + np.asarray(static, dtype=np.float64)) + self.shift


def rest_to_pose(layer: GarmentLayer, betas: ArrayLike, pose: ArrayLike, topology: str) -> RestToPose:
    """The map K for a shape and a sequence of poses.

    Args:
        layer: The layer.
        betas: Shape, shape [b].
        pose: Axis-angle rotations [rad], shape [T, K, 3].
        topology: "body" or "skirt"; see `garment_weights`.

    Returns:
        K; for the topology "body" it takes the layer at rest to the posed layer (of a body without pose correctives).
    """
    joints = layer.model.shape(betas)[1]
    weights = garment_weights(layer, topology)
    poses = np.concatenate([REST_POSE[None], np.asarray(pose, dtype=np.float64)])
    transforms = joint_transforms(joints, layer.model.parents, poses)
    transforms[..., 3] -= joints[0]
    blended = np.einsum("nk,tkij->tnij", weights, transforms, optimize=True)
    rest, frames = blended[0], blended[1:]
    inverse = np.linalg.inv(rest[..., :3])
    linear = frames[..., :3] @ inverse
    strongest = (transforms[1:, :, :, :3] @ np.linalg.inv(transforms[0, :, :, :3]))[:, weights.argmax(axis=1)]
    rotation = np.stack([nearest_rotations(linear[t], strongest[t]) for t in range(len(linear))])
    return RestToPose(linear=linear, shift=frames[..., 3] - _times(linear, rest[..., 3]), rotation=rotation)


def _times(matrices: Array, vectors: Array) -> Array:
    """Matrices [..., 3, 3] times vectors [..., 3]."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])
