"""How good a simulated sequence is, measured from its positions alone."""

from __future__ import annotations

from collections.abc import Callable

import igl
import numpy as np

LOOKS = 8
"""Frames in which penetration is measured exactly: it costs as much as simulating them."""


def strain(x: np.ndarray, edges: np.ndarray, rest_length: np.ndarray) -> np.ndarray:
    """Stretch l / l0 - 1 of every edge at x (N, 3), shape [E]."""
    stretch: np.ndarray = np.linalg.norm(x[edges[:, 0]] - x[edges[:, 1]], axis=1) / rest_length - 1
    return stretch


def deepest(x: np.ndarray, body: Callable[[int], np.ndarray], body_faces: np.ndarray) -> float:
    """Greatest depth [m] of any vertex of x (T, N, 3) inside the body in LOOKS frames spread over T, 0 if none."""
    worst = 0.0
    faces = np.ascontiguousarray(body_faces, np.int64)
    for k in np.unique(np.linspace(0, len(x) - 1, LOOKS).round().astype(int)):
        surface = np.ascontiguousarray(body(int(k)), np.float64)
        worst = max(worst, -float(igl.signed_distance(np.ascontiguousarray(x[k]), surface, faces)[0].min()))
    return worst


def measure(
    x: np.ndarray, edges: np.ndarray, rest_length: np.ndarray, body: Callable[[int], np.ndarray], body_faces: np.ndarray
) -> dict[str, float]:
    """Figures of a sequence x (T, N, 3) [m]: penetration [m], stretch, acceleration; those of the worst frame."""
    # Frame by frame: all edges of all frames at once would take more memory than the simulation.
    seen = []
    for frame in x:
        stretch = strain(frame, edges, rest_length)
        seen.append((np.percentile(stretch, 99), stretch.max(), (stretch > 0.1).mean()))
    p99, most, share = (float(worst) for worst in np.max(seen, axis=0))
    return {
        "max_penetration_m": deepest(x, body, body_faces),
        "strain_p99": p99,
        "strain_max": most,
        "share_over_10_percent": share,
    }
