"""Connectivity of triangle meshes: edges, borders, components, and the measures that read only connectivity."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components


def edge_list(faces: ArrayLike) -> NDArray[np.int64]:
    """Undirected edges, each once, smaller vertex first, sorted, shape [E, 2]."""
    return edges_with_counts(faces)[0]


def edges_with_counts(faces: ArrayLike) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Undirected edges [E, 2], sorted, and how many faces meet at each, shape [E]."""
    f = np.asarray(faces, dtype=np.int64)
    base = int(f.max(initial=0)) + 1
    # Neighbouring faces have neighbouring numbers: a sort that makes use of runs.
    codes = np.sort(_codes(f, base)[0], kind="stable")
    starts = np.flatnonzero(np.diff(codes, prepend=-1))
    counts = np.diff(starts, append=len(codes))
    codes = codes[starts]
    return np.stack([codes // base, codes % base], axis=1), counts


def border_halfedges(faces: ArrayLike) -> NDArray[np.int64]:
    """Directed edges that belong to one face only, in that face's direction, shape [B, 2]."""
    f = np.asarray(faces, dtype=np.int64)
    codes, rising = _codes(f, int(f.max(initial=0)) + 1)
    order = np.argsort(codes, kind="stable")
    starts = np.flatnonzero(np.diff(codes[order], prepend=-1))
    counts = np.diff(starts, append=len(codes))
    up = np.add.reduceat(rising[order], starts, dtype=np.int64) if len(starts) else np.zeros(0, dtype=np.int64)
    # All that use such an edge run the same way.
    alone = np.zeros(len(codes), dtype=bool)
    alone[order] = np.repeat((up == 0) | (up == counts), counts)
    face, side = np.divmod(np.flatnonzero(alone), 3)
    return np.stack([f[face, side], f[face, (side + 1) % 3]], axis=1)


def _codes(faces: NDArray[np.int64], base: int) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """One number for the edge under each half-edge, and whether that runs from its smaller vertex, shape [3 F]."""
    start = faces.reshape(-1)
    end = faces[:, [1, 2, 0]].reshape(-1)
    return np.minimum(start, end) * base + np.maximum(start, end), start < end


def is_member(values: NDArray[np.int64], ordered: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which values are among some sorted ones, of the values' shape; several times faster than `np.isin`."""
    if len(ordered) == 0:
        return np.zeros(values.shape, dtype=bool)
    place = np.minimum(np.searchsorted(ordered, values), len(ordered) - 1)
    found: NDArray[np.bool_] = ordered[place] == values
    return found


def border_vertices(faces: ArrayLike, vertex_count: int) -> NDArray[np.bool_]:
    """Whether each vertex lies on a border, shape [V]."""
    on_border = np.zeros(vertex_count, dtype=bool)
    on_border[border_halfedges(faces).reshape(-1)] = True
    return on_border


def border_loops(faces: ArrayLike) -> list[NDArray[np.int64]]:
    """Closed loops of border vertices in the faces' direction, longest first, each starting at its smallest vertex.

    Args:
        faces: Triangles of an oriented manifold mesh, shape [F, 3].

    Returns:
        One array of vertices per loop.

    Raises:
        ValueError: Two borders touch at one vertex, so that the loops are not defined.
    """
    following: dict[int, int] = {}
    for a, b in border_halfedges(faces).tolist():
        if a in following:
            raise ValueError(f"two borders touch at vertex {a}; the mesh must be manifold")
        following[a] = b
    loops: list[NDArray[np.int64]] = []
    while following:
        start = min(following)
        loop = [start]
        while (after := following.pop(loop[-1])) != start:
            loop.append(after)
        loops.append(np.array(loop, dtype=np.int64))
    return sorted(loops, key=lambda loop: (-len(loop), int(loop[0])))


def adjacency(edges: ArrayLike, vertex_count: int) -> sp.csr_matrix:
    """Symmetric 0/1 matrix of neighbours, shape [V, V]."""
    e = np.asarray(edges, dtype=np.int64)
    both = np.vstack([e, e[:, ::-1]])
    matrix = sp.coo_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(vertex_count, vertex_count)).tocsr()
    matrix.data[:] = 1.0
    return matrix


def component_labels(edges: ArrayLike, vertex_count: int) -> NDArray[np.int64]:
    """Number of the connected component of each vertex, in order of their first vertex, shape [V]."""
    return connected_components(adjacency(edges, vertex_count), directed=False)[1].astype(np.int64)


def euler_characteristic(faces: ArrayLike) -> int:
    """V - E + F over the vertices that the faces use."""
    f = np.asarray(faces)
    return len(np.unique(f)) - len(edge_list(f)) + len(f)


def is_edge_manifold(faces: ArrayLike) -> bool:
    """Whether no edge has more than two faces and neighbouring faces are oriented alike."""
    f = np.asarray(faces, dtype=np.int64)
    half = f[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return len(np.unique(half, axis=0)) == len(half)


def largest_component_faces(faces: ArrayLike) -> NDArray[np.bool_]:
    """Which faces belong to the component with the most faces, shape [F]."""
    f = np.asarray(faces, dtype=np.int64)
    labels = component_labels(edge_list(f), int(f.max()) + 1)[f[:, 0]]
    return labels == np.bincount(labels).argmax()


def compact(faces: ArrayLike, vertex_count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Drops unused vertices: faces over the kept vertices [F, 3], and the old number of each kept vertex [V']."""
    f = np.asarray(faces, dtype=np.int64)
    used = np.zeros(vertex_count, dtype=bool)
    used[f.reshape(-1)] = True
    kept = np.flatnonzero(used)
    renumber = np.full(vertex_count, -1, dtype=np.int64)
    renumber[kept] = np.arange(len(kept))
    return renumber[f], kept
