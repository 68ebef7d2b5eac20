"""Normals, areas and edge lengths of triangle meshes."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def area_vectors(vertices: ArrayLike, faces: ArrayLike) -> NDArray[np.float64]:
    """Normals of the faces, twice their area long [m^2], shape [F, 3]."""
    points, f = np.asarray(vertices, dtype=np.float64), np.asarray(faces)
    # One coordinate at a time: several times faster than np.cross.
    x, y, z = (points[:, k] for k in range(3))
    a, b, c = (f[:, k] for k in range(3))
    ux, uy, uz = x[b] - x[a], y[b] - y[a], z[b] - z[a]
    vx, vy, vz = x[c] - x[a], y[c] - y[a], z[c] - z[a]
    return np.stack([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], axis=1)


def face_normals(vertices: ArrayLike, faces: ArrayLike) -> NDArray[np.float64]:
    """Unit normals of the faces, 0 where a face has no area, shape [F, 3]."""
    return _unit(area_vectors(vertices, faces))


def vertex_normals(vertices: ArrayLike, faces: ArrayLike) -> NDArray[np.float64]:
    """Unit normals of the vertices, area-weighted means of their faces', 0 where there is none, shape [V, 3]."""
    points = np.asarray(vertices, dtype=np.float64)
    f = np.asarray(faces)
    vectors = area_vectors(points, f)
    corner, count = f.reshape(-1), len(points)
    total = [np.bincount(corner, weights=np.repeat(vectors[:, k], 3), minlength=count) for k in range(3)]
    return _unit(np.stack(total, axis=1).astype(np.float64))


def edge_lengths(vertices: ArrayLike, edges: ArrayLike) -> NDArray[np.float64]:
    """Lengths of edges [m], shape [E]."""
    points, e = np.asarray(vertices, dtype=np.float64), np.asarray(edges)
    return np.linalg.norm(points[e[:, 0]] - points[e[:, 1]], axis=1)


def face_areas(vertices: ArrayLike, faces: ArrayLike) -> NDArray[np.float64]:
    """Areas of the faces [m^2], shape [F]."""
    return 0.5 * np.linalg.norm(area_vectors(vertices, faces), axis=1)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors of length 1; those shorter than 1e-20 become 0."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(length > 1e-20, vectors / np.maximum(length, 1e-20), 0.0)
