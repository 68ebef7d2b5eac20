"""The mesh hierarchy of the networks: six levels from the layer's vertices down to one vertex per segment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg
from numpy.typing import NDArray

from model.gcvae import LEVELS, TOPOLOGIES
from model.mesh.coarsen import coarsen
from model.mesh.topology import edge_list

# Each level keeps a quarter of the one above: 14475, 3618, 904, 226, 56, 21 in the paper.
REDUCTION = 4
# Below this an eigenvalue problem is solved densely: ARPACK needs more vectors than a 21-vertex graph has.
DENSE_BELOW = 64


@dataclass(frozen=True, kw_only=True)
class Hierarchy:
    """Clusters shared by the two topologies, and the edges of each topology at every level.

    Attributes:
        sizes: Vertices of each level, finest first.
        maps: Fine vertex -> coarse vertex, one array for each step down.
        edges: topology -> edges (E, 2) of each level.
        lambda_max: topology -> largest eigenvalue of the normalised Laplacian at each level.
    """

    sizes: tuple[int, ...]
    maps: tuple[NDArray[np.int32], ...]
    edges: Mapping[str, tuple[NDArray[np.int32], ...]]
    lambda_max: Mapping[str, tuple[float, ...]]

    def laplacian(self, topology: str, level: int) -> sp.csr_matrix:
        """Rescaled Laplacian 2 L / lambda_max - I (CLOTH3D supplement, Graph convolutions), float64, symmetric."""
        matrix = normalised_laplacian(self.edges[topology][level], self.sizes[level])
        scaled = 2.0 / self.lambda_max[topology][level] * matrix - sp.identity(self.sizes[level], format="csr")
        return scaled.tocsr()

    def arrays(self) -> dict[str, NDArray]:
        """What a shard stores of the hierarchy: the maps, the edges and the eigenvalues."""
        stored: dict[str, NDArray] = {f"maps/{k}": array for k, array in enumerate(self.maps)}
        for topology in TOPOLOGIES:
            stored |= {f"edges/{topology}/{k}": array for k, array in enumerate(self.edges[topology])}
            stored[f"lambda_max/{topology}"] = np.array(self.lambda_max[topology])
        return stored

    @classmethod
    def from_arrays(cls, stored: Mapping[str, NDArray]) -> Hierarchy:
        """The hierarchy that `arrays` described."""
        maps = tuple(np.asarray(stored[f"maps/{k}"], np.int32) for k in range(LEVELS - 1))
        sizes = (*(len(array) for array in maps), int(maps[-1].max()) + 1)
        edges = {
            topology: tuple(np.asarray(stored[f"edges/{topology}/{k}"], np.int32) for k in range(LEVELS))
            for topology in TOPOLOGIES
        }
        eigenvalues = {topology: tuple(float(v) for v in stored[f"lambda_max/{topology}"]) for topology in TOPOLOGIES}
        return cls(sizes=sizes, maps=maps, edges=edges, lambda_max=eigenvalues)


def build_hierarchy(
    vertices: NDArray[np.floating],
    body_faces: NDArray[np.integer],
    skirt_faces: NDArray[np.integer],
    segments: NDArray[np.integer],
) -> Hierarchy:
    """Cluster the layer's vertices into `LEVELS` levels, the coarsest holding one vertex per segment.

    Only edges that both topologies share are contracted, so that each cluster is connected under both; the clusters
    are then the same for a skirt and for trousers, and only the Laplacian differs (CLOTH3D, Pooling and SMPL-Skirt
    Topology).

    Args:
        vertices: Layer vertices in the rest pose [m], shape (N, 3).
        body_faces: Faces of the body topology, shape (F, 3).
        skirt_faces: Faces of the skirt topology, shape (G, 3).
        segments: Segment of each vertex from 0 to S - 1, shape (N,).

    Raises:
        ValueError: If a segment is not connected along the shared edges.
    """
    count, segment_count = len(vertices), int(np.max(segments)) + 1
    counts = [max(count // REDUCTION**k, segment_count) for k in range(1, LEVELS - 1)] + [segment_count]
    fine = {"body": edge_list(body_faces).astype(np.int32), "skirt": edge_list(skirt_faces).astype(np.int32)}
    shared = _rows_in_both(fine["body"], fine["skirt"], count)
    maps = coarsen(vertices, body_faces, shared, segments, counts)
    edges: dict[str, tuple[NDArray[np.int32], ...]] = {}
    eigenvalues: dict[str, tuple[float, ...]] = {}
    for topology in TOPOLOGIES:
        levels = [fine[topology]]
        for clusters in maps:
            levels.append(_distinct(clusters[levels[-1]]))
        edges[topology] = tuple(levels)
        eigenvalues[topology] = tuple(
            largest_eigenvalue(normalised_laplacian(level, size)) for level, size in zip(levels, [count, *counts])
        )
    return Hierarchy(sizes=(count, *counts), maps=tuple(maps), edges=edges, lambda_max=eigenvalues)


def _distinct(edges: NDArray[np.integer]) -> NDArray[np.int32]:
    ordered = np.sort(edges, axis=1)
    distinct = np.unique(ordered[ordered[:, 0] != ordered[:, 1]], axis=0)
    return distinct.astype(np.int32)


def _rows_in_both(first: NDArray[np.int32], second: NDArray[np.int32], count: int) -> NDArray[np.int32]:
    codes = [edges[:, 0].astype(np.int64) * count + edges[:, 1] for edges in (first, second)]
    return first[np.isin(codes[0], codes[1])]


def normalised_laplacian(edges: NDArray[np.integer], count: int) -> sp.csr_matrix:
    """I - D^-1/2 A D^-1/2 of the graph with unit weights, shape (count, count); a lone vertex has an empty row."""
    rows = np.concatenate([edges[:, 0], edges[:, 1]])
    columns = np.concatenate([edges[:, 1], edges[:, 0]])
    adjacency = sp.coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(count, count)).tocsr()
    degree = np.asarray(adjacency.sum(axis=1)).ravel()
    scale = np.where(degree > 0, 1.0 / np.sqrt(np.maximum(degree, 1.0)), 0.0)
    scaling = sp.diags(scale)
    return (sp.diags((degree > 0).astype(float)) - scaling @ adjacency @ scaling).tocsr()


def largest_eigenvalue(laplacian: sp.csr_matrix) -> float:
    """Largest eigenvalue of a symmetric matrix, rounded to 1e-6 so that its bits do not depend on the solver's path."""
    count = laplacian.shape[0]
    if count < DENSE_BELOW:
        value = np.linalg.eigvalsh(laplacian.toarray())[-1]
    else:
        start = np.cos(np.arange(count) * 2.399963)
        value = scipy.sparse.linalg.eigsh(laplacian, k=1, which="LA", v0=start, tol=1e-8, return_eigenvectors=False)[0]
    return round(float(value), 6)
