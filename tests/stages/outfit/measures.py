"""What the tests of the outfit stage measure on a mesh."""

import numpy as np
from numpy.typing import NDArray

from model.mesh.topology import component_labels, edge_list

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


def angles(points: Array, faces: Faces) -> Array:
    """Smallest angle of each triangle [degrees], shape [F]."""
    corner = points[faces]
    out = []
    for k in range(3):
        u, v = corner[:, (k + 1) % 3] - corner[:, k], corner[:, (k + 2) % 3] - corner[:, k]
        out.append(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1)))
    return np.degrees(np.min(out, axis=0))


def edge_lengths(points: Array, faces: Faces) -> Array:
    """Length of each edge [m], shape [E]."""
    edges = edge_list(faces)
    return np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)


def components(points: Array, faces: Faces) -> int:
    """Number of connected components, stray vertices included."""
    return int(component_labels(edge_list(faces), len(points)).max()) + 1


def area(points: Array, faces: Faces) -> float:
    """Area [m^2]."""
    corner = points[faces]
    return float(np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1).sum() / 2)


def tube(radius: float, height: float, edge: float) -> tuple[Array, Faces]:
    """A vertical tube of near-equilateral triangles, looking outwards."""
    around, rows = round(2 * np.pi * radius / edge), round(height / (edge * 0.866))
    points = []
    for i in range(rows + 1):
        angle = 2 * np.pi * (np.arange(around) + 0.5 * (i % 2)) / around
        z = np.full(around, height * i / rows)
        points.append(np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1))
    faces = []
    for i in range(rows):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = a + around, b + around
            faces += [[a, b, c], [b, d, c]] if i % 2 == 0 else [[a, b, d], [a, d, c]]
    return np.concatenate(points), np.array(faces)


def ball(radius: float) -> tuple[Array, Faces]:
    """A closed sphere that looks outwards: an octahedron divided four times."""
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    faces = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    for _ in range(4):
        edges = edge_list(faces)
        number = {(int(a), int(b)): len(points) + k for k, (a, b) in enumerate(edges)}
        points = np.concatenate([points, (points[edges[:, 0]] + points[edges[:, 1]]) / 2])
        new = []
        for a, b, c in faces.tolist():
            ab, bc, ca = (number[min(p), max(p)] for p in ((a, b), (b, c), (c, a)))
            new += [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        faces = np.array(new)
    return radius * points / np.linalg.norm(points, axis=1, keepdims=True), faces
