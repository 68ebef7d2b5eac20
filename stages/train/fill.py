"""Offsets continued outside the garment by diffusion over the mesh, so that every vertex has a target."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.gcvae.hierarchy import Hierarchy

# Rounds of averaging over the neighbours at each level, after the values came down from the coarser one.
SMOOTHING_ROUNDS = 10


class Fill:
    """Harmonic continuation by pulling means up the hierarchy and pushing them back down.

    A direct solve takes 0.1 s a garment. Here the coarsest level is solved exactly and each finer one takes its
    parent's values and a few Jacobi rounds, which follows the same diffusion in milliseconds.
    """

    def __init__(self, hierarchy: Hierarchy, topology: str) -> None:
        self.maps = hierarchy.maps
        self.sizes = hierarchy.sizes
        self.averages = [
            neighbour_average(edges, size) for edges, size in zip(hierarchy.edges[topology], hierarchy.sizes)
        ]

    def __call__(self, values: NDArray[np.floating], known: NDArray[np.bool_]) -> NDArray[np.float32]:
        """Keeps `values` (N, 3) where `known` (N,) and continues them elsewhere; zero if nothing is known."""
        sums, weights = [np.where(known[:, None], values, 0.0)], [known.astype(float)]
        for clusters, size in zip(self.maps, self.sizes[1:]):
            sums.append(np.stack([np.bincount(clusters, sums[-1][:, k], size) for k in range(values.shape[1])], axis=1))
            weights.append(np.bincount(clusters, weights[-1], size))
        filled = self._coarsest(sums[-1], weights[-1])
        for level in range(len(self.sizes) - 2, -1, -1):
            free = weights[level] == 0
            means = sums[level] / np.maximum(weights[level], 1e-12)[:, None]
            filled = np.where(free[:, None], filled[self.maps[level]], means)
            rows = self.averages[level][np.flatnonzero(free)]
            for _ in range(SMOOTHING_ROUNDS):
                filled[free] = rows @ filled
        return filled.astype(np.float32)

    def _coarsest(self, sums: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """The harmonic solution of the coarsest graph, with known vertices as boundary values."""
        free = weights == 0
        filled = sums / np.maximum(weights, 1e-12)[:, None]
        if free.any() and not free.all():
            average = self.averages[-1].toarray()
            system = np.eye(int(free.sum())) - average[np.ix_(free, free)]
            # The least-norm solution gives zero to a piece of the graph that touches nothing known.
            filled[free] = np.linalg.lstsq(system, average[np.ix_(free, ~free)] @ filled[~free], rcond=1e-9)[0]
        return filled


def neighbour_average(edges: NDArray[np.integer], count: int) -> sp.csr_matrix:
    """Matrix (count, count) that averages a vertex's neighbours; the row of a lone vertex keeps its own value."""
    rows = np.concatenate([edges[:, 0], edges[:, 1]])
    columns = np.concatenate([edges[:, 1], edges[:, 0]])
    adjacency = sp.coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(count, count)).tocsr()
    degree = np.asarray(adjacency.sum(axis=1)).ravel()
    return (sp.diags(1.0 / np.maximum(degree, 1.0)) @ adjacency + sp.diags((degree == 0).astype(float))).tocsr()
