"""Connectivity, Laplacian, harmonic filling and carried points on meshes whose answer is known."""

import numpy as np
import pytest
import trimesh

from model.mesh.barycentric import carry
from model.mesh.operators import graph_laplacian, harmonic_fill
from model.mesh.topology import (
    adjacency,
    border_halfedges,
    border_loops,
    border_vertices,
    compact,
    component_labels,
    edge_list,
    edges_with_counts,
    euler_characteristic,
    is_edge_manifold,
    largest_component_faces,
)


@pytest.fixture(scope="module")
def tube() -> tuple[np.ndarray, np.ndarray]:
    """An open tube of 24 x 16 vertices around z: two borders."""
    k, n = 24, 16
    angle, height = np.meshgrid(2 * np.pi * np.arange(k) / k, np.arange(n) / n, indexing="ij")
    index = np.arange(k * n).reshape(k, n)
    right = np.roll(index, -1, axis=0)
    a, b, c, d = index[:, :-1].ravel(), right[:, :-1].ravel(), right[:, 1:].ravel(), index[:, 1:].ravel()
    vertices = np.stack([np.cos(angle), np.sin(angle), height], axis=2).reshape(-1, 3)
    return vertices, np.vstack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def test_topology_agrees_with_trimesh(tube: tuple[np.ndarray, np.ndarray]) -> None:
    mesh = trimesh.Trimesh(*tube, process=False)
    ours = {tuple(edge) for edge in edge_list(tube[1]).tolist()}
    assert ours == {tuple(edge) for edge in mesh.edges_unique.tolist()}
    assert euler_characteristic(tube[1]) == mesh.euler_number == 0
    edges, counts = edges_with_counts(tube[1])
    assert counts.sum() == 3 * len(tube[1]) and (counts == 1).sum() == 48
    assert is_edge_manifold(tube[1])
    assert not is_edge_manifold(np.vstack([tube[1], tube[1][:1]]))
    assert (border_vertices(tube[1], len(tube[0])) == np.isin(tube[0][:, 2], [0.0, 15 / 16])).all()
    assert len(edges) == len(ours)


def test_edges_and_borders_are_those_counted_one_by_one() -> None:
    """Over soups of triangles: edges with one face, two, many, and neighbours turned against each other."""
    rng = np.random.default_rng(3)
    for count in (0, 1, 8, 30):
        faces = np.stack([rng.permutation(12)[:3] for _ in range(count)]) if count else np.zeros((0, 3), dtype=int)
        half = [(a, b) for f in faces.tolist() for a, b in zip(f, [*f[1:], f[0]])]
        undirected = [(min(pair), max(pair)) for pair in half]
        edges, counts = edges_with_counts(faces)
        assert [tuple(edge) for edge in edges.tolist()] == sorted(set(undirected))
        assert counts.tolist() == [undirected.count(edge) for edge in sorted(set(undirected))]
        assert [tuple(h) for h in border_halfedges(faces).tolist()] == [h for h in half if h[::-1] not in half]


def test_border_loops_run_along_the_faces(tube: tuple[np.ndarray, np.ndarray]) -> None:
    loops = border_loops(tube[1])
    assert [len(loop) for loop in loops] == [24, 24]
    half = {tuple(edge) for edge in tube[1][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()}
    for loop in loops:
        assert all((int(a), int(b)) in half for a, b in zip(loop, np.roll(loop, -1), strict=True))
    with pytest.raises(ValueError, match="two borders touch at vertex 0"):
        border_loops(np.array([[0, 1, 2], [0, 3, 4]]))


def test_components_and_compaction(tube: tuple[np.ndarray, np.ndarray]) -> None:
    two = np.vstack([tube[1], tube[1][:5] + 1000])
    assert largest_component_faces(two).sum() == len(tube[1])
    labels = component_labels(np.array([[0, 1], [3, 4]]), 5)
    assert labels.tolist() == [0, 0, 1, 2, 2]
    faces, kept = compact(two[-5:], 2000)
    assert (kept[faces] == two[-5:]).all() and faces.max() == len(kept) - 1


def test_laplacian_is_degree_minus_adjacency(tube: tuple[np.ndarray, np.ndarray]) -> None:
    edges, count = edge_list(tube[1]), len(tube[0])
    laplacian = graph_laplacian(edges, count)
    x = np.random.default_rng(0).standard_normal(count)
    energy = sum((x[a] - x[b]) ** 2 for a, b in edges.tolist())
    assert x @ (laplacian @ x) == pytest.approx(energy)
    assert adjacency(edges, count).sum() == 2 * len(edges)


def test_harmonic_fill_makes_each_free_vertex_the_mean_of_its_neighbours(tube: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, faces = tube
    edges = edge_list(faces)
    free = (vertices[:, 2] > 0.2) & (vertices[:, 2] < 0.8)
    noisy = vertices + free[:, None] * np.random.default_rng(1).standard_normal(vertices.shape)
    filled = harmonic_fill(edges, noisy, free)
    np.testing.assert_array_equal(filled[~free], noisy[~free])
    links = adjacency(edges, len(vertices))
    mean = (links @ filled) / np.asarray(links.sum(axis=1)).reshape(-1, 1)
    assert np.abs(filled - mean)[free].max() < 1e-12
    np.testing.assert_array_equal(harmonic_fill(edges, noisy, np.zeros(len(vertices), bool)), noisy)


def test_carried_points_follow_their_face() -> None:
    faces = np.array([[0, 1, 2], [2, 1, 3]])
    vertices = np.random.default_rng(2).standard_normal((5, 4, 3))
    weights = np.array([[0.5, 0.25, 0.25], [0.0, 1.0, 0.0], [0.3, 0.3, 0.4]])
    carried = carry(vertices, faces, np.array([0, 1, -1]), weights)
    expected = 0.5 * vertices[:, 0] + 0.25 * vertices[:, 1] + 0.25 * vertices[:, 2]
    np.testing.assert_allclose(carried[:, 0], expected)
    np.testing.assert_allclose(carried[:, 1], vertices[:, 1])
    assert not carried[:, 2].any()
