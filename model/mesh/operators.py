"""Linear operators on the vertices of a mesh."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.linalg import splu

from model.mesh.topology import adjacency


def graph_laplacian(edges: ArrayLike, vertex_count: int) -> sp.csr_matrix:
    """D - A: degree minus adjacency; symmetric, positive semi-definite, rows sum to 0, shape [V, V]."""
    links = adjacency(edges, vertex_count)
    degree = np.asarray(links.sum(axis=1)).reshape(-1)
    return sp.csr_matrix(sp.diags(degree) - links)


def harmonic_fill(edges: ArrayLike, values: ArrayLike, free: ArrayLike) -> NDArray[np.float64]:
    """Replaces the values of free vertices by the smoothest ones: each the mean of its neighbours.

    This is what iterated Laplacian smoothing of those vertices converges to.

    Args:
        edges: Undirected edges, shape [E, 2].
        values: One row per vertex, shape [V, D].
        free: Vertices to fill, shape [V]; each connected to one that is not free.

    Returns:
        Values, shape [V, D], those that are not free unchanged.
    """
    filled = np.array(values, dtype=np.float64)
    unknown = np.asarray(free, dtype=bool)
    if not unknown.any():
        return filled
    laplacian = graph_laplacian(edges, len(filled))
    inner = laplacian[unknown][:, unknown].tocsc()
    factor = splu(inner, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    filled[unknown] = factor.solve(-(laplacian[unknown][:, ~unknown] @ filled[~unknown]))
    return filled
