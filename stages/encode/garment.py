"""Encode one garment: the stage's core, arrays in and arrays out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.mesh.barycentric import carry
from model.offsets import extract_offsets


@dataclass(frozen=True, eq=False, kw_only=True)
class Rows:
    """Where each vertex of the layer lies on a garment; the register shard's correspondences.

    Attributes:
        faces: The garment's triangles, shape [G, 3].
        face: One of them for each vertex of the layer, -1 outside the mask, shape [N].
        barycentric: Weights of its corners, shape [N, 3].
        mask: Vertices that the garment covers, shape [N].
    """

    faces: NDArray[np.integer]
    face: NDArray[np.integer]
    barycentric: NDArray[np.floating]
    mask: NDArray[np.bool_]

    def __post_init__(self) -> None:
        """Checks that the rows belong to this garment.

        Raises:
            ValueError: A row names a face that the garment does not have, or the mask says otherwise.
        """
        if len(self.face) and int(self.face.max()) >= len(self.faces):
            raise ValueError(f"face must be < {len(self.faces)}, the garment's faces, got {int(self.face.max())}")
        if not np.array_equal(self.mask, self.face >= 0):
            raise ValueError("mask must hold exactly the vertices with a face")


def encode_garment(vertices: ArrayLike, layer: ArrayLike, rows: Rows) -> NDArray[np.float32]:
    """Offsets of a garment from the layer in the same pose.

    Args:
        vertices: Garment [m], shape [M, 3] or [T, M, 3].
        layer: Layer in the same frame of reference [m], shape [N, 3] or [T, N, 3].
        rows: Correspondences.

    Returns:
        Offsets along the world's axes [m], shape [N, 3] or [T, N, 3]; 0 outside the mask.

    Raises:
        ValueError: The garment has fewer vertices than its faces name, or other frames than the layer.
    """
    points = np.asarray(vertices)
    if points.shape[-2] <= int(rows.faces.max()):
        raise ValueError(f"garment must have more than {int(rows.faces.max())} vertices, got {points.shape[-2]}")
    if points.shape[:-2] != np.shape(layer)[:-2]:
        raise ValueError(
            f"garment must have as many frames as the poses, {np.shape(layer)[:-2]}, got {points.shape[:-2]}"
        )
    garment = carry(points, rows.faces, rows.face, rows.barycentric)
    return extract_offsets(garment, layer, rows.mask).astype(np.float32)
