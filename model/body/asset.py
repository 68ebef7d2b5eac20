"""The npz file of an embedded body: small, exact enough, and read without pickle."""

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from model.body.model import BodyModel

ASSET_FOLDER = Path(__file__).parent / "assets"

SHAPE_QUANTUM = 1e-5
"""Step of the stored shape directions [m per beta]: at |beta| = 3 the rounding stays under 15 um."""

GENDERS = ("female", "male")


@lru_cache(maxsize=4)
def load_free_body(gender: str) -> BodyModel:
    """The embedded free body, read once per process.

    Args:
        gender: `female` or `male`.

    Returns:
        The model; its arrays are shared between callers and read-only.

    Raises:
        ValueError: There is no such gender.
    """
    if gender not in GENDERS:
        raise ValueError(f"gender must be one of {', '.join(GENDERS)}, got {gender!r}")
    return load_body(ASSET_FOLDER / f"free_{gender}.npz")


def load_body(path: Path) -> BodyModel:
    """Reads a file of `save_body`.

    Args:
        path: The npz file.

    Returns:
        The model, with read-only arrays.
    """
    with np.load(path, allow_pickle=False) as data:
        joint_template = data["joint_template"].astype(np.float64)
        model = BodyModel(
            gender=str(data["gender"]),
            v_template=data["v_template"].astype(np.float32),
            shapedirs=(data["shapedirs_steps"] * float(data["shapedirs_quantum"])).astype(np.float32),
            joint_template=joint_template,
            joint_shapedirs=data["joint_shapedirs"].astype(np.float64),
            weights=_dense_weights(data["weight_joints"], data["weight_values"], len(joint_template)),
            parents=data["parents"].astype(np.int32),
            faces=data["faces"].astype(np.int32),
        )
    for value in vars(model).values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return model


def save_body(path: Path, model: BodyModel) -> None:
    """Writes a body without pose correctives, about 1 MB for 13,000 vertices.

    Shape directions are kept as whole steps of `SHAPE_QUANTUM`, weights as the joints that matter and their values.

    Args:
        path: The npz file to write.
        model: The body.

    Raises:
        ValueError: The body has pose correctives, or a shape direction is too large for 16 bits.
    """
    if model.posedirs is not None:
        raise ValueError("a body with posedirs cannot be stored in this format")
    steps = np.rint(model.shapedirs.astype(np.float64) / SHAPE_QUANTUM)
    if np.abs(steps).max() > np.iinfo(np.int16).max:
        raise ValueError(f"shapedirs must stay below {SHAPE_QUANTUM * np.iinfo(np.int16).max:.3f} m per beta")
    weight_joints, weight_values = _sparse_weights(model.weights)
    np.savez_compressed(
        path,
        gender=np.array(model.gender),
        v_template=model.v_template.astype(np.float32),
        shapedirs_steps=steps.astype(np.int16),
        shapedirs_quantum=np.array(SHAPE_QUANTUM),
        joint_template=model.joint_template.astype(np.float32),
        joint_shapedirs=model.joint_shapedirs.astype(np.float32),
        weight_joints=weight_joints,
        weight_values=weight_values,
        parents=model.parents.astype(np.int8),
        faces=model.faces.astype(np.uint16 if model.vertex_count <= 2**16 else np.int32),
    )


def _sparse_weights(weights: NDArray[np.float32]) -> tuple[NDArray[np.uint8], NDArray[np.float16]]:
    """Joints [V, k] and weights [V, k] of the k largest weights, k = what the fullest row needs."""
    k = int((weights > 0).sum(axis=1).max())
    joints = np.argsort(-weights, axis=1, kind="stable")[:, :k]
    return joints.astype(np.uint8), np.take_along_axis(weights, joints, axis=1).astype(np.float16)


def _dense_weights(joints: NDArray[np.uint8], values: NDArray[np.float16], joint_count: int) -> NDArray[np.float32]:
    """Weights [V, K] whose rows sum to 1."""
    weights = np.zeros((len(joints), joint_count), np.float32)
    np.put_along_axis(weights, joints.astype(np.int64), values.astype(np.float32), axis=1)
    return weights / weights.sum(axis=1, keepdims=True)
