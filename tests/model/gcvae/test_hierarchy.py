"""The hierarchy of both topologies: shared clusters, one vertex per segment, Laplacians against dense algebra."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from model.gcvae import LEVELS, TOPOLOGIES
from model.gcvae.hierarchy import Hierarchy, build_hierarchy, largest_eigenvalue
from model.mesh.topology import edge_list

RINGS, SIDES, SEGMENTS = 48, 24, 4


def two_legs() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Two tubes, and the same vertices as one tube: the faces of each tube's inner column are joined to the other's."""
    angle = np.arange(SIDES) * 2 * np.pi / SIDES
    height = np.arange(RINGS) * 0.05
    ring = np.stack([0.2 * np.cos(angle), 0.2 * np.sin(angle)], axis=1)
    tubes, labels = [], []
    for side, x in enumerate((-0.3, 0.3)):
        flip = np.array([1.0 if side == 0 else -1.0, 1.0])
        for k, z in enumerate(height):
            tubes.append(np.column_stack([ring * flip + [x, 0], np.full(SIDES, z)]))
            labels.append(np.full(SIDES, 2 * side + (k >= RINGS // 2)))
    u, v = np.meshgrid(np.arange(RINGS - 1), np.arange(SIDES), indexing="ij")
    a, b = u * SIDES + v, u * SIDES + (v + 1) % SIDES
    quads = np.stack([a, b, b + SIDES, a + SIDES], axis=-1).reshape(-1, 4)
    inner = (v == 0).ravel()  # the column from angle 0 to the next one, which faces the other tube
    one = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    outer = np.concatenate([quads[~inner][:, [0, 1, 2]], quads[~inner][:, [0, 2, 3]]])
    other = RINGS * SIDES
    p, q = quads[inner][:, 0], quads[inner][:, 3]
    r, s = quads[inner][:, 1], quads[inner][:, 2]
    bridge = np.concatenate([np.stack(t, 1) for t in
                             ((p, q, q + other), (p, q + other, p + other),
                              (r, s, s + other), (r, s + other, r + other))])  # fmt: skip
    body = np.concatenate([one, one + other])
    skirt = np.concatenate([outer, outer + other, bridge])
    return np.concatenate(tubes), body, skirt, np.concatenate(labels)


@pytest.fixture(scope="module")
def legs() -> Hierarchy:
    return build_hierarchy(*two_legs())


def test_levels_quarter_and_end_at_one_vertex_per_segment(legs: Hierarchy) -> None:
    count = 2 * RINGS * SIDES
    assert legs.sizes == (count, count // 4, count // 16, count // 64, count // 256, SEGMENTS)
    coarsest = np.arange(count)
    for clusters in legs.maps:
        coarsest = clusters[coarsest]
    labels = two_legs()[3]
    assert len({(a, b) for a, b in zip(coarsest, labels)}) == SEGMENTS


def test_clusters_are_connected_under_both_topologies(legs: Hierarchy) -> None:
    _, body, skirt, _ = two_legs()
    for faces in (body, skirt):
        edges = edge_list(faces)
        cluster = np.arange(legs.sizes[0])
        for clusters in legs.maps:
            cluster = clusters[cluster]
            inner = edges[cluster[edges[:, 0]] == cluster[edges[:, 1]]]
            graph = sp.coo_matrix((np.ones(len(inner)), inner.T), shape=(legs.sizes[0],) * 2)
            assert connected_components(graph, directed=False)[0] == cluster.max() + 1


def test_only_the_skirt_connects_the_legs(legs: Hierarchy) -> None:
    for level in range(LEVELS):
        for topology, pieces in (("body", 2), ("skirt", 1)):
            matrix = legs.laplacian(topology, level) if level < LEVELS else None
            assert connected_components(matrix, directed=False)[0] == pieces


def test_laplacian_equals_dense_algebra(legs: Hierarchy) -> None:
    for topology in TOPOLOGIES:
        for level in (3, 5):
            size = legs.sizes[level]
            adjacency = np.zeros((size, size))
            for a, b in legs.edges[topology][level]:
                adjacency[a, b] = adjacency[b, a] = 1.0
            inverse_root = np.diag(adjacency.sum(1) ** -0.5)
            laplacian = np.eye(size) - inverse_root @ adjacency @ inverse_root
            largest = np.linalg.eigvalsh(laplacian)[-1]
            expected = 2 * laplacian / largest - np.eye(size)
            assert np.allclose(legs.laplacian(topology, level).toarray(), expected, atol=2e-6)


def test_rescaled_spectrum_fills_minus_one_to_one(legs: Hierarchy) -> None:
    for level in range(2, LEVELS):
        values = np.linalg.eigvalsh(legs.laplacian("body", level).toarray())
        assert values[0] == pytest.approx(-1.0, abs=1e-6)
        assert values[-1] == pytest.approx(1.0, abs=2e-6)


def test_sparse_and_dense_eigenvalue_agree(legs: Hierarchy) -> None:
    rescaled = legs.laplacian("skirt", 2)
    shifted = rescaled + 3 * sp.identity(rescaled.shape[0])
    dense = np.linalg.eigvalsh(shifted.toarray())[-1]
    assert largest_eigenvalue(shifted) == pytest.approx(dense, abs=2e-6)


def test_stored_arrays_give_the_hierarchy_back(legs: Hierarchy) -> None:
    again = Hierarchy.from_arrays(legs.arrays())
    assert again.sizes == legs.sizes and again.lambda_max == legs.lambda_max
    assert all(np.array_equal(a, b) for a, b in zip(again.maps, legs.maps))
    assert (again.laplacian("skirt", 1) != legs.laplacian("skirt", 1)).nnz == 0
