"""What is measured of a trajectory, whichever solver made it: error against another, and how the cloth lies."""

from __future__ import annotations

from typing import Any

import numpy as np

from stages.simulate.springs import bending_rows, face_areas, unique_edges

PIXEL = 0.005
"""Of the silhouettes [m]."""


def errors(x: np.ndarray, reference: np.ndarray, fps: float) -> dict[str, float]:
    """Root mean square distance [mm] of x (T, N, 3) from `reference`: over the first 0.5 s and 1 s, and at those times.

    Frame 0 is the start. What lies beyond the shorter of the two is left out.
    """
    frames = min(len(x), len(reference))
    squared = ((x[:frames].astype(np.float64) - reference[:frames]) ** 2).sum(2).mean(1) * 1e6
    out = {}
    for seconds in (0.5, 1.0):
        last = round(seconds * fps)
        if last < frames:
            out[f"error_{seconds:g}s_mm"] = float(np.sqrt(squared[: last + 1].mean()))
            out[f"error_at_{seconds:g}s_mm"] = float(np.sqrt(squared[last]))
    return out


def statistics(x: np.ndarray, rest: np.ndarray, faces: np.ndarray, fps: float, first: int) -> dict[str, float]:
    """How the cloth lies and moves from frame `first` of x (T, N, 3) [m] on, `rest` (N, 3) being its rest shape.

    Strain is that of the edges, `curvature` [1/m] the root mean square over the area: the curvature whose square times
    half the rigidity is the bending energy per area. The silhouettes are those from above and from two sides together.
    """
    x = np.asarray(x[max(first, 1) - 1 :], np.float64)
    edges, _ = unique_edges(faces)
    rows, bend = bending_rows(rest, faces, np.ones(len(rest)))
    area = float(face_areas(rest, faces).sum())
    length = np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)
    strain = np.abs(np.linalg.norm(x[1:, edges[:, 0]] - x[1:, edges[:, 1]], axis=2) / length - 1)
    folded = np.array([-(bend * ((y[rows[:, 0]] - y[rows[:, 1]]) ** 2).sum(1)).sum() for y in x[1:]])
    velocity = np.diff(x, axis=0) * fps
    return {
        "strain_p99": float(np.percentile(strain, 99)),
        "strain_max": float(strain.max()),
        "curvature": float(np.sqrt(np.maximum(folded, 0.0) / area).mean()),
        "silhouette_m2": float(np.mean([silhouettes(y, faces) for y in x[1:]])),
        "kinetic_j_per_kg": float(0.5 * (velocity**2).sum(2).mean()),
    }


def silhouettes(x: np.ndarray, faces: np.ndarray) -> float:
    """Area [m^2] of the silhouettes of x (N, 3) along the three axes together, from points PIXEL or less apart."""
    corners = x[faces]
    longest = np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2).max()
    cuts = max(2, int(np.ceil(longest / PIXEL)) + 1)
    u, v = np.meshgrid(np.arange(cuts + 1), np.arange(cuts + 1), indexing="ij")
    inside = u + v <= cuts
    weights = np.stack([u[inside], v[inside], cuts - u[inside] - v[inside]], axis=1) / cuts
    points = np.einsum("wc,fcd->fwd", weights, corners).reshape(-1, 3)
    cells = np.floor(points / PIXEL).astype(np.int64)
    cells -= cells.min(0)
    count = 0
    for a, b in ((0, 1), (1, 2), (2, 0)):
        key = cells[:, a] * (cells[:, b].max() + 1) + cells[:, b]
        count += len(np.unique(key))
    return count * PIXEL**2


def relative(figures: dict[str, float], reference: dict[str, float]) -> dict[str, Any]:
    """Every figure over the reference's."""
    return {key: value / reference[key] if reference[key] else None for key, value in figures.items()}
