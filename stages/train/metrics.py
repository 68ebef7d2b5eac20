"""How well garments are reconstructed (CLOTH3D, Experiments), one number a sample, and averages of two kinds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from model.mesh.geometry import face_normals

MM = 1000.0


def surface_error(predicted: NDArray, target: NDArray, mask: NDArray[np.bool_]) -> float:
    """Mean Euclidean distance [mm] of offsets (N, 3) from the true ones, over the true mask (N,)."""
    return MM * float(np.linalg.norm((predicted - target)[mask].astype(np.float64), axis=1).mean())


def normals_error(
    predicted: NDArray, target: NDArray, base: NDArray, faces: NDArray[np.integer], mask: NDArray[np.bool_]
) -> float:
    """Mean angle [rad] between the face normals of base + offsets, over the faces wholly inside the true mask.

    Args:
        predicted: Offsets [m], shape (N, 3).
        target: True offsets [m], shape (N, 3).
        base: What they are added to [m], shape (N, 3).
        faces: The topology of the garment's type, shape (F, 3).
        mask: True mask, shape (N,).
    """
    inner = faces[mask[faces].all(axis=1)]
    first, second = face_normals(base + predicted, inner), face_normals(base + target, inner)
    # atan2 instead of arccos, which has no precision left for nearly equal normals.
    sine = np.linalg.norm(np.cross(first, second), axis=1)
    return float(np.arctan2(sine, np.sum(first * second, axis=1)).mean())


def mask_iou(predicted: NDArray[np.bool_], target: NDArray[np.bool_]) -> float:
    """Intersection over union of two masks (N,)."""
    return float((predicted & target).sum() / max((predicted | target).sum(), 1))


def inside_share(offsets: NDArray, normals: NDArray, mask: NDArray[np.bool_]) -> float:
    """Share of the mask's vertices whose offset (N, 3) points behind the tangent plane of the body's normal (N, 3)."""
    return float((np.sum(offsets[mask] * normals[mask], axis=1) < 0).mean())


def averages(scores: Mapping[str, Sequence[float]], types: Sequence[str]) -> dict[str, dict[str, float]]:
    """Averages of per-sample scores.

    The paper doesn't say which average it takes; its figures look weighted by samples. Both are given.

    Args:
        scores: Metric -> one number a sample.
        types: Garment type of each sample.

    Returns:
        "samples": mean over samples; "categories": mean of the types' means; and the mean of each type.
    """
    kinds = sorted(set(types))
    table: dict[str, dict[str, float]] = {"samples": {}, "categories": {}, **{kind: {} for kind in kinds}}
    for metric, values in scores.items():
        array = np.asarray(values, np.float64)
        for kind in kinds:
            table[kind][metric] = float(array[[t == kind for t in types]].mean())
        table["samples"][metric] = float(array.mean())
        table["categories"][metric] = float(np.mean([table[kind][metric] for kind in kinds]))
    return table
