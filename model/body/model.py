"""A body model in SMPL's schema: linear shape, optional pose correctives, linear blend skinning."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from model.body.skinning import FRAMES_PER_CHUNK, joint_transforms, rotation_matrices, skin


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class BodyModel:
    """A body: a template, what shape and pose do to it, and the skeleton that carries it.

    The model frame is y up, x to the person's left, facing +z, in metres, in the T-pose.
    """

    gender: str
    """`female`, `male` or `neutral`."""
    v_template: NDArray[np.float32]
    """Mean body in the T-pose [m], shape [V, 3]."""
    shapedirs: NDArray[np.float32]
    """Displacement per unit of each beta [m], shape [V, 3, B]."""
    joint_template: NDArray[np.float64]
    """Joints of the mean body [m], shape [K, 3]: the joint regressor applied to `v_template`."""
    joint_shapedirs: NDArray[np.float64]
    """Joint displacement per unit of each beta [m], shape [K, 3, B]."""
    weights: NDArray[np.float32]
    """Skinning weights, rows sum to 1, shape [V, K]."""
    parents: NDArray[np.int32]
    """Parent of each joint, -1 for the root, shape [K]."""
    faces: NDArray[np.int32]
    """Triangles, counter-clockwise seen from outside, shape [F, 3]."""
    posedirs: NDArray[np.float32] | None = None
    """Pose correctives [m] per entry of (R_1 - I, ..., R_{K-1} - I), shape [V, 3, 9 (K-1)]; a body may have none."""

    def __post_init__(self) -> None:
        """Checks that the arrays belong together.

        Raises:
            ValueError: A shape disagrees with the others.
        """
        v, k, b = len(self.v_template), len(self.joint_template), self.shapedirs.shape[-1]
        expected: dict[str, tuple[int, ...]] = {
            "v_template": (v, 3),
            "shapedirs": (v, 3, b),
            "joint_template": (k, 3),
            "joint_shapedirs": (k, 3, b),
            "weights": (v, k),
            "parents": (k,),
            "faces": (len(self.faces), 3),
        }
        if self.posedirs is not None:
            expected["posedirs"] = (v, 3, 9 * (k - 1))
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"BodyModel.{name} must have shape {shape}, got {getattr(self, name).shape}")

    def __repr__(self) -> str:
        """Says which body this is, without its arrays."""
        return f"BodyModel({self.gender}, {self.vertex_count} vertices, {self.beta_count} betas)"

    @property
    def vertex_count(self) -> int:
        """Number of vertices V."""
        return len(self.v_template)

    @property
    def beta_count(self) -> int:
        """Number of shape coefficients B."""
        return int(self.shapedirs.shape[2])

    def shape(self, betas: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
        """The body of one person in the T-pose.

        Args:
            betas: Shape coefficients, shape [b] with b <= B; those left out are 0.

        Returns:
            Vertices [m], shape [V, 3], and joints [m], shape [K, 3], in the model frame (y up).

        Raises:
            ValueError: There are more betas than shape directions.
        """
        beta = np.asarray(betas, dtype=np.float64).reshape(-1)
        if len(beta) > self.beta_count:
            raise ValueError(f"betas must have at most {self.beta_count} entries, got {len(beta)}")
        vertices = self.v_template + self.shapedirs[:, :, : len(beta)] @ beta.astype(np.float32)
        joints = self.joint_template + self.joint_shapedirs[:, :, : len(beta)] @ beta
        return vertices, joints

    def pose(self, betas: ArrayLike, pose: ArrayLike, trans: ArrayLike | None = None) -> NDArray[np.float32]:
        """The posed body, frame by frame.

        Args:
            betas: Shape coefficients, shape [b] with b <= B.
            pose: Rotation of each joint relative to its parent, axis-angle [rad], shape [T, K, 3]. The root carries
                the turn from the y-up model to the z-up world.
            trans: World position of the root joint [m], shape [T, 3]; left out, the root joint stays at its rest
                position and the pose is applied about it.

        Returns:
            Vertices [m], shape [T, V, 3].
        """
        vertices, joints = self.shape(betas)
        rotations = np.asarray(pose, dtype=np.float64)
        transforms = joint_transforms(joints, self.parents, rotations)
        if trans is not None:
            transforms[..., 3] += (np.asarray(trans, dtype=np.float64) - joints[0])[:, None]
        if self.posedirs is None:
            return skin(vertices, self.weights, transforms).astype(np.float32, copy=False)
        out = np.empty((len(rotations), *vertices.shape), np.float32)
        for start in range(0, len(rotations), FRAMES_PER_CHUNK):
            part = slice(start, start + FRAMES_PER_CHUNK)
            out[part] = skin(vertices + self._correctives(rotations[part]), self.weights, transforms[part])
        return out

    def _correctives(self, pose: NDArray[np.float64]) -> NDArray[np.float32]:
        """Pose-dependent displacements [m], shape [T, V, 3] (SMPL, equation 9)."""
        assert self.posedirs is not None
        features = (rotation_matrices(pose[:, 1:]) - np.eye(3)).reshape(len(pose), -1).astype(np.float32)
        flat = self.posedirs.reshape(-1, features.shape[1])
        return (features @ flat.T).reshape(len(pose), -1, 3)

    def resample(self, rows: sp.sparray | sp.spmatrix, faces: NDArray[np.int32]) -> "BodyModel":
        """Another body model whose vertices are linear combinations of this one's: a subdivision or a selection.

        Args:
            rows: Sparse matrix, each row sums to 1, shape [V', V].
            faces: Triangles over the new vertices, shape [F', 3].

        Returns:
            The model over the new vertices. The joints stay as they are; weights are normalised again.

        Raises:
            ValueError: `rows` does not fit, or a row does not sum to 1.
        """
        matrix = sp.csr_matrix(rows).astype(np.float64)
        if matrix.shape[1] != self.vertex_count:
            raise ValueError(f"rows must have {self.vertex_count} columns, got {matrix.shape[1]}")
        sums = np.asarray(matrix.sum(axis=1)).reshape(-1)
        if not np.allclose(sums, 1.0, atol=1e-6):
            raise ValueError(f"each row must sum to 1, row {int(np.abs(sums - 1).argmax())} does not")

        def apply(field: NDArray[np.float32]) -> NDArray[np.float32]:
            flat = field.reshape(self.vertex_count, -1)
            return np.asarray(matrix @ flat, dtype=np.float32).reshape(-1, *field.shape[1:])

        weights = np.clip(apply(self.weights), 0.0, None)
        return replace(
            self,
            v_template=apply(self.v_template),
            shapedirs=apply(self.shapedirs),
            posedirs=None if self.posedirs is None else apply(self.posedirs),
            weights=weights / weights.sum(axis=1, keepdims=True),
            faces=np.ascontiguousarray(faces, dtype=np.int32),
        )
