"""How well a registered garment stands for the original."""

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.mesh.geometry import area_vectors, edge_lengths, face_areas
from model.mesh.topology import edge_list


@dataclass(frozen=True, kw_only=True)
class Quality:
    """Errors of one registered garment.

    Attributes:
        error_mean_m: Mean distance of the garment's surface to the registered one [m].
        error_p95_m: Its 95th percentile [m].
        coverage: Share of the garment's area nearer than `COVERED` to the registered surface.
        longest_edge_m: Longest registered edge [m].
        turned_faces: Registered faces that face against the garment.
    """

    error_mean_m: float
    error_p95_m: float
    coverage: float
    longest_edge_m: float
    turned_faces: int


COVERED = 0.005
"""Distance below which a piece of the garment counts as covered [m]: half an edge."""


def measure(
    garment: ArrayLike,
    garment_faces: ArrayLike,
    registered: ArrayLike,
    layer_faces: ArrayLike,
    mask: ArrayLike,
    face: ArrayLike,
    rng: np.random.Generator,
    samples: int = 10_000,
) -> Quality:
    """Measures the distance from the garment to the registered surface.

    Args:
        garment: Garment [m], shape [M, 3].
        garment_faces: Its triangles, shape [G, 3].
        registered: Registered layer [m], shape [N, 3].
        layer_faces: Triangles of the layer, shape [F, 3]; those wholly in the mask make the registered surface.
        mask: Covered vertices, shape [N].
        face: The garment's face of each covered vertex, shape [N].
        rng: Picks the points on the garment, evenly by area.
        samples: Number of points.

    Returns:
        The figures; infinite errors and no coverage if nothing was registered.
    """
    points, triangles = np.asarray(registered, dtype=np.float64), np.asarray(layer_faces, dtype=np.int64)
    surface = np.ascontiguousarray(triangles[np.asarray(mask)[triangles].all(axis=1)])
    if len(surface) == 0:
        return Quality(error_mean_m=np.inf, error_p95_m=np.inf, coverage=0.0, longest_edge_m=0.0, turned_faces=0)
    queries = _sample(np.asarray(garment, dtype=np.float64), np.asarray(garment_faces), samples, rng)
    distance = np.sqrt(igl.point_mesh_squared_distance(queries, points, surface)[0])
    normals = area_vectors(garment, garment_faces)[np.asarray(face)[surface]].sum(axis=1)
    turned = (area_vectors(points, surface) * normals).sum(axis=1) < 0
    return Quality(
        error_mean_m=float(distance.mean()),
        error_p95_m=float(np.percentile(distance, 95)),
        coverage=float((distance < COVERED).mean()),
        longest_edge_m=float(edge_lengths(points, edge_list(surface)).max()),
        turned_faces=int(turned.sum()),
    )


def _sample(
    points: NDArray[np.float64], faces: NDArray[np.integer], count: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Points spread over a surface evenly by area [m], shape [count, 3]."""
    cumulative = np.cumsum(face_areas(points, faces))
    chosen = np.searchsorted(cumulative, rng.random(count) * cumulative[-1], side="right")
    chosen = np.minimum(chosen, len(faces) - 1)
    u, v = rng.random((2, count))
    fold = u + v > 1
    u, v = np.where(fold, 1 - u, u)[:, None], np.where(fold, 1 - v, v)[:, None]
    a, b, c = (points[faces[chosen, k]] for k in range(3))
    return np.ascontiguousarray(a + u * (b - a) + v * (c - a))
