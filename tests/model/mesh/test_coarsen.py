"""Edge contraction: exact counts, labels kept apart, connected clusters, and what it refuses."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from model.mesh.coarsen import coarsen
from model.mesh.topology import edge_list

COUNTS = [300, 75, 20, 6]


def torus(rings: int = 40, sides: int = 30) -> tuple[np.ndarray, np.ndarray]:
    """A closed mesh with a handle, shape (1200, 3) and (2400, 3)."""
    u, v = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")
    s, t = u * 2 * np.pi / rings, v * 2 * np.pi / sides
    radius = 1.0 + 0.3 * np.cos(t)
    vertices = np.stack([radius * np.cos(s), radius * np.sin(s), 0.3 * np.sin(t)], axis=-1).reshape(-1, 3)
    a, b = u * sides + v, u * sides + (v + 1) % sides
    c, d = (u + 1) % rings * sides + v, (u + 1) % rings * sides + (v + 1) % sides
    faces = np.concatenate([np.stack([a, c, d], -1).reshape(-1, 3), np.stack([a, d, b], -1).reshape(-1, 3)])
    return vertices, faces


def six_sectors(vertices: np.ndarray) -> np.ndarray:
    """Labels 0..5 by the angle around the torus' axis."""
    angle = np.arctan2(vertices[:, 1], vertices[:, 0]) + np.pi
    return np.minimum((angle / (2 * np.pi) * 6).astype(int), 5)


def test_counts_are_exact_and_labels_never_mix() -> None:
    vertices, faces = torus()
    labels = six_sectors(vertices)
    cluster = np.arange(len(vertices))
    for clusters, count in zip(coarsen(vertices, faces, edge_list(faces), labels, COUNTS), COUNTS):
        cluster = clusters[cluster]
        assert np.array_equal(np.unique(cluster), np.arange(count))
        for k in range(count):
            assert len(np.unique(labels[cluster == k])) == 1


def test_every_cluster_is_connected() -> None:
    vertices, faces = torus()
    edges = edge_list(faces)
    cluster = np.arange(len(vertices))
    for clusters in coarsen(vertices, faces, edges, six_sectors(vertices), COUNTS):
        cluster = clusters[cluster]
        inner = edges[cluster[edges[:, 0]] == cluster[edges[:, 1]]]
        graph = sp.coo_matrix((np.ones(len(inner)), inner.T), shape=(len(vertices),) * 2)
        assert connected_components(graph, directed=False)[0] == cluster.max() + 1


def test_clusters_are_more_even_than_by_quadrics_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces = torus()
    vertices[:, 2] *= 0.05  # nearly flat: the quadrics say little, and alone merge the same vertices again and again
    labels = np.zeros(len(vertices), int)

    def spread() -> float:
        sizes = np.bincount(coarsen(vertices, faces, edge_list(faces), labels, [300])[0])
        return float(sizes.std() / sizes.mean())

    even = spread()
    monkeypatch.setattr("model.mesh.coarsen.UNIFORMITY", 0.0)
    assert even < 0.35
    assert spread() > 0.45


def test_same_input_gives_the_same_clusters() -> None:
    vertices, faces = torus()
    first, second = (coarsen(vertices, faces, edge_list(faces), six_sectors(vertices), COUNTS) for _ in range(2))
    assert all(np.array_equal(a, b) for a, b in zip(first, second))


def test_a_label_in_two_pieces_is_refused() -> None:
    vertices, faces = torus()
    labels = six_sectors(vertices) % 3
    with pytest.raises(ValueError, match="6 vertices are left and none may merge, wanted 3"):
        coarsen(vertices, faces, edge_list(faces), labels, [3])
