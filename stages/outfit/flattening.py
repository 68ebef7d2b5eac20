"""Lays the panels of a garment flat, as near to their true size as can be: as-rigid-as-possible, in metres."""

from collections.abc import Collection
from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from model.mesh.topology import component_labels, edge_list, is_member

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

ROUNDS = 12
"""Rounds of turning triangles and solving for vertices."""

GAP = 0.02
"""Distance between the panels laid side by side [m]."""


@dataclass(frozen=True, eq=False)
class Flat:
    """A garment's panels side by side in one plane."""

    points: Array
    """Positions [m], u to the right and v upwards as seen from outside the garment, shape [M, 2]."""
    faces: Faces
    """The garment's triangles over these points, shape [F, 3]."""


def flatten(points: Array, faces: Faces, panel: Faces, cut_edges: Faces, sleeves: Collection[int] = ()) -> Flat:
    """Lays a garment flat.

    Args:
        points: Vertices [m], shape [N, 3].
        faces: Triangles, counter-clockwise seen from outside, shape [F, 3].
        panel: Number of each triangle's panel, shape [F].
        cut_edges: Edges at which the garment is opened, smaller vertex first, shape [S, 2].
        sleeves: Numbers of the panels that hang from the shoulder along x, not down along z.

    Returns:
        The panels from left to right by their numbers; one that the cuts leave in several parts lies in as many.
    """
    count = len(points)
    opened, corner = opened_faces(faces, cut_edges, count)
    island = component_labels(edge_list(opened), len(corner))[opened[:, 0]]
    flat = np.zeros((len(corner), 2))
    right = 0.0
    order = sorted(np.unique(island).tolist(), key=lambda k: (int(panel[island == k][0]), k))
    for k in order:
        local = opened[island == k]
        used = np.unique(local)
        renumber = np.zeros(len(corner), dtype=np.int64)
        renumber[used] = np.arange(len(used))
        part = points[corner[used]]
        up = -np.abs(part[:, 0]) if int(panel[island == k][0]) in sleeves else part[:, 2]
        laid = _upright(_laid_flat(part, renumber[local]), up)
        laid -= laid.min(axis=0)
        flat[used] = laid + np.array([right, 0.0])
        right += float(laid[:, 0].max()) + GAP
    return Flat(flat, opened)


def opened_faces(faces: Faces, cut_edges: Faces, count: int) -> tuple[Faces, Faces]:
    """The faces over vertices of their own on either side of the cuts.

    Args:
        faces: Triangles, shape [F, 3].
        cut_edges: Edges to cut, smaller vertex first, shape [S, 2].
        count: Number of vertices.

    Returns:
        Faces over the new vertices, shape [F, 3]; the vertex that each new one is a copy of, shape [M].
    """
    half = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    low, high = half.min(axis=1), half.max(axis=1)
    code = low * count + high
    inner = ~is_member(code, np.sort(cut_edges[:, 0] * count + cut_edges[:, 1]))
    order = np.flatnonzero(inner)[np.argsort(code[inner], kind="stable")]
    same = np.flatnonzero(code[order[1:]] == code[order[:-1]])
    one, other = order[same], order[same + 1]
    # Half-edge h runs from corner h to the next one of its face; its twin runs the other way.
    after = np.arange(faces.size).reshape(-1, 3)[:, [1, 2, 0]].reshape(-1)
    links = np.concatenate([np.stack([one, after[other]]), np.stack([after[one], other])], axis=1)
    graph = sp.coo_matrix((np.ones(links.shape[1]), (links[0], links[1])), shape=(faces.size, faces.size))
    label = connected_components(graph, directed=False)[1]
    corner = np.empty(int(label.max()) + 1, dtype=np.int64)
    corner[label] = faces.reshape(-1)
    return label.reshape(-1, 3).astype(np.int64), corner


def stretches(points: Array, faces: Faces, flat: Flat) -> Array:
    """Largest and smallest stretch of every triangle when it is laid flat [1], shape [F, 2]; the smallest is negative
    if it is turned over."""
    inverse = np.linalg.inv(_frames(points[faces]))
    a, b, c = (flat.points[flat.faces[:, k]] for k in range(3))
    jacobian = np.stack([b - a, c - a], axis=2) @ inverse
    values = np.linalg.svd(jacobian, compute_uv=False)
    values[:, 1] *= np.sign(np.linalg.det(jacobian))
    return values


def _frames(corners: Array) -> Array:
    """Two edges of each triangle [F, 3, 3] as columns in a frame of its own plane, shape [F, 2, 2]."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    length = np.linalg.norm(first, axis=1)
    along = (first * second).sum(axis=1) / length
    across = np.linalg.norm(np.cross(first, second), axis=1) / length
    return np.stack([np.stack([length, along], 1), np.stack([np.zeros_like(length), across], 1)], 1)


def _laid_flat(points: Array, faces: Faces) -> Array:
    """One part laid flat, shape [n, 2]: from the least squares conformal map to the most rigid one.

    Source: Liu, Zhang, Xu, Gotsman and Gortler, A Local/Global Approach to Mesh Parameterization (2008), ARAP.
    """
    flat = _conformal(points, faces)
    frames, count = _frames(points[faces]), len(points)
    weights = np.maximum(igl.cotmatrix_entries(points, faces), 1e-3)
    one, other = faces[:, [1, 2, 0]].reshape(-1), faces[:, [2, 0, 1]].reshape(-1)
    w = weights.reshape(-1)
    rows, columns = np.concatenate([one, other, one, other]), np.concatenate([one, other, other, one])
    laplacian = sp.csc_matrix((np.concatenate([w, w, -w, -w]), (rows, columns)), shape=(count, count))
    solve = splu(laplacian[1:, 1:], permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    gradient, force = _gradient(faces, frames, count), _force(faces, frames, weights, count)
    for _ in range(ROUNDS):
        right = force @ _rotations(gradient @ flat)
        flat = np.concatenate([np.zeros((1, 2)), solve.solve(right[1:])])
    return flat


def _gradient(faces: Faces, frames: Array, count: int) -> sp.csr_matrix:
    """Flat positions -> how they change along both axes of each triangle's frame, one below the other, [2 F, n]."""
    inverse = np.linalg.inv(frames)
    slopes = np.stack([-inverse.sum(axis=1), inverse[:, 0], inverse[:, 1]], axis=2)
    return _over_corners(faces, slopes, count)


def _force(faces: Faces, frames: Array, weights: Array, count: int) -> sp.csr_matrix:
    """Rotations as `_rotations` returns them -> right side of the vertices' equations, shape [n, 2 F]."""
    rest = np.stack([np.zeros((len(faces), 2)), frames[:, :, 0], frames[:, :, 1]], axis=1)
    # Weighted edges opposite to each corner; each pulls at its two ends.
    pull = weights[:, :, None] * (rest[:, [1, 2, 0]] - rest[:, [2, 0, 1]])
    return _over_corners(faces, (pull[:, [2, 0, 1]] - pull[:, [1, 2, 0]]).transpose(0, 2, 1), count).T.tocsr()


def _over_corners(faces: Faces, values: Array, count: int) -> sp.csr_matrix:
    """A matrix with two rows for each triangle and `values` [F, 2, 3] at its corners, shape [2 F, n]."""
    columns = np.repeat(faces, 2, axis=0).reshape(-1)
    return sp.csr_matrix((values.reshape(-1), columns, np.arange(0, len(columns) + 1, 3)), (2 * len(faces), count))


def _conformal(points: Array, faces: Faces) -> Array:
    """The least squares conformal map of its true area, its two furthest border vertices pinned, shape [n, 2]."""
    border = igl.boundary_loop(faces)
    far = border[np.linalg.norm(points[border] - points[border[0]], axis=1).argmax()]
    near = border[np.linalg.norm(points[border] - points[far], axis=1).argmax()]
    pins = np.array([[0.0, 0.0], [float(np.linalg.norm(points[far] - points[near])), 0.0]])
    flat = np.asarray(igl.lscm(points, faces, np.array([near, far], dtype=np.int64), pins)[0])
    a, b, c = (flat[faces[:, k]] for k in range(3))
    doubled = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    flat = flat * np.sqrt(igl.doublearea(points, faces).sum() / abs(doubled.sum()))
    return flat * [1.0, np.sign(doubled.sum())]


def _rotations(gradients: Array) -> Array:
    """The nearest rotation to each triangle's pair of gradients, in the same order, shape [2 F, 2]."""
    along, across = gradients[0::2], gradients[1::2]
    cosine, sine = along[:, 0] + across[:, 1], along[:, 1] - across[:, 0]
    length = np.maximum(np.hypot(cosine, sine), 1e-30)
    cosine, sine = cosine / length, sine / length
    return np.stack([cosine, sine, -sine, cosine], axis=1).reshape(-1, 2)


def _upright(flat: Array, up: Array) -> Array:
    """The part turned so that v runs the way in which `up` [n] grows."""
    centred = flat - flat.mean(axis=0)
    way = np.linalg.lstsq(centred, up - up.mean(), rcond=None)[0]
    way /= np.linalg.norm(way)
    return centred @ np.stack([[way[1], -way[0]], way], axis=1)
