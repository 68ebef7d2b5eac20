"""Finds the triangles of two meshes, or of one mesh with itself, that pass through each other."""

from itertools import chain

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

Points = NDArray[np.float64]
Faces = NDArray[np.int64]

BLOCK = 200_000
"""Pairs of triangles tested at a time: bounds the memory to about 200 MB."""


def intersecting_faces(
    vertices: ArrayLike, faces: ArrayLike, other_vertices: ArrayLike, other_faces: ArrayLike
) -> NDArray[np.int64]:
    """Pairs of faces of two meshes where an edge of one passes through the other.

    Args:
        vertices: Vertices of the first mesh [m], shape [V, 3].
        faces: Its triangles, shape [F, 3].
        other_vertices: Vertices of the second mesh [m], shape [W, 3].
        other_faces: Its triangles, shape [G, 3].

    Returns:
        Face of the first and face of the second mesh, shape [n, 2]. Coplanar triangles that overlap are not found.
    """
    a = np.asarray(vertices, dtype=np.float64)[np.asarray(faces)]
    b = np.asarray(other_vertices, dtype=np.float64)[np.asarray(other_faces)]
    return _crossing(a, b, _near_pairs(a, b))


def self_intersecting_faces(vertices: ArrayLike, faces: ArrayLike) -> NDArray[np.int64]:
    """Pairs of faces of one mesh, without a vertex in common, that pass through each other, shape [n, 2]."""
    f = np.asarray(faces, dtype=np.int64)
    a = np.asarray(vertices, dtype=np.float64)[f]
    pairs = _near_pairs(a, a)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    apart = np.ones(len(pairs), dtype=bool)
    for i in range(3):
        for j in range(3):
            apart &= f[pairs[:, 0], i] != f[pairs[:, 1], j]
    return _crossing(a, a, pairs[apart])


def self_crossings(vertices: ArrayLike, faces: ArrayLike) -> NDArray[np.int64]:
    """The pairs of `self_intersecting_faces`, in another order, sooner on cloth, whose layers lie near each other.

    Few of the pairs with boxes that overlap have corners on both sides of each other's planes: only their edges are
    tried.

    Args:
        vertices: Vertices of the mesh [m], shape [V, 3].
        faces: Its triangles, at least one, shape [F, 3].

    Returns:
        Pairs of faces, the lower one first, shape [n, 2].
    """
    x, f = np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64)
    return _crossing(x[f], x[f], _may_cross(x, f))


def _may_cross(x: Points, faces: Faces) -> Faces:
    """Pairs of faces without a common vertex, with boxes that overlap, neither all on one side of the other."""
    corners = x[faces]
    centre = corners.mean(axis=1)
    radius = float(np.linalg.norm(corners - centre[:, None], axis=2).max())
    i, j = cKDTree(centre).query_pairs(2 * radius, output_type="ndarray").astype(np.int32).T
    low, high = corners.min(axis=1), corners.max(axis=1)
    for axis in range(3):
        # Axis by axis: each halves what is left, and such lists fit the cache. Exact: these are copies.
        lower, upper = np.ascontiguousarray(low[:, axis]), np.ascontiguousarray(high[:, axis])
        near = (lower[i] <= upper[j]) & (lower[j] <= upper[i])
        i, j = i[near], j[near]
    apart = np.ones(len(i), bool)
    columns = np.ascontiguousarray(faces.T.astype(np.int32))
    for a in columns:
        first = a[i]
        for b in columns:
            apart &= first != b[j]
    i, j = i[apart], j[apart]
    both = _straddles(corners, i, j) & _straddles(corners, j, i)
    return np.stack([i[both], j[both]], axis=1).astype(np.int64)


def _straddles(corners: Points, i: NDArray[np.int32], j: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Whether face j has corners on both sides of the plane of face i, or nearly."""
    p, q = corners[i], corners[j]
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    side = np.einsum("nkc,nc->nk", q - p[:, :1], normal)
    slack = 1e-9 * np.abs(normal).sum(axis=1)
    both: NDArray[np.bool_] = (side.min(axis=1) <= slack) & (side.max(axis=1) >= -slack)
    return both


def _near_pairs(a: Points, b: Points) -> NDArray[np.int64]:
    """Pairs of triangles [n, 3, 3] whose bounding boxes overlap."""
    low_a, high_a, low_b, high_b = a.min(axis=1), a.max(axis=1), b.min(axis=1), b.max(axis=1)
    centre_a, centre_b = a.mean(axis=1), b.mean(axis=1)
    radius_a = np.linalg.norm(a - centre_a[:, None], axis=2).max(axis=1, initial=0.0)
    radius_b = np.linalg.norm(b - centre_b[:, None], axis=2).max(initial=0.0)
    found = cKDTree(centre_b).query_ball_point(centre_a, radius_a + radius_b)
    counts = np.array([len(f) for f in found], dtype=np.int64)
    first = np.repeat(np.arange(len(a)), counts)
    second = np.fromiter(chain.from_iterable(found), np.int64, int(counts.sum()))
    overlap = ((low_a[first] <= high_b[second]) & (low_b[second] <= high_a[first])).all(axis=1)
    return np.stack([first[overlap], second[overlap]], axis=1)


def _crossing(a: Points, b: Points, pairs: NDArray[np.int64]) -> NDArray[np.int64]:
    """The pairs of which an edge of one triangle passes through the other."""
    kept = []
    for start in range(0, len(pairs), BLOCK):
        block = pairs[start : start + BLOCK]
        p, q = a[block[:, 0]], b[block[:, 1]]
        hit = np.zeros(len(block), dtype=bool)
        for k in range(3):
            hit |= _segment_hits(p[:, k], p[:, (k + 1) % 3], q)
            hit |= _segment_hits(q[:, k], q[:, (k + 1) % 3], p)
        kept.append(block[hit])
    return np.concatenate(kept) if kept else np.zeros((0, 2), dtype=np.int64)


def _segment_hits(start: Points, end: Points, triangle: Points) -> NDArray[np.bool_]:
    """Whether each segment [n, 3] to [n, 3] passes through its triangle [n, 3, 3], by signs of volumes."""

    def volume(p: Points, u: Points, v: Points, w: Points) -> Points:
        result: Points = np.einsum("ni,ni->n", u - p, np.cross(v - p, w - p))
        return result

    a, b, c = triangle[:, 0], triangle[:, 1], triangle[:, 2]
    sides = volume(start, a, b, c) * volume(end, a, b, c) < 0
    ab, bc, ca = volume(start, end, a, b), volume(start, end, b, c), volume(start, end, c, a)
    same = ((ab > 0) & (bc > 0) & (ca > 0)) | ((ab < 0) & (bc < 0) & (ca < 0))
    return sides & same
