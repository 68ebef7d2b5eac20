"""Remeshing, splitting and strips on surfaces whose answer is known."""

import numpy as np
import pytest

from model.mesh.geometry import area_vectors, edge_lengths, face_areas, vertex_normals
from model.mesh.remesh import _apart, remesh
from model.mesh.split import split_along
from model.mesh.strip import strip_faces
from model.mesh.topology import border_loops, border_vertices, edge_list, euler_characteristic, is_edge_manifold


def grid(n: int, stretch: float) -> tuple[np.ndarray, np.ndarray]:
    """A flat n x n grid over [0, 1] x [0, stretch]."""
    x, y = np.meshgrid(np.arange(n) / (n - 1), stretch * np.arange(n) / (n - 1), indexing="ij")
    index = np.arange(n * n).reshape(n, n)
    a, b, c, d = (index[i : n - 1 + i, j : n - 1 + j].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = np.vstack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], 1), faces


def test_remesh_of_a_stretched_sheet_is_even_and_keeps_its_outline() -> None:
    vertices, faces = grid(18, 0.35)
    edge = 0.04
    points, triangles = remesh(vertices, faces, edge)
    length = edge_lengths(points, edge_list(triangles))
    assert np.percentile(length, 1) > 0.6 * edge
    assert np.percentile(length, 99) < 1.5 * edge
    assert face_areas(points, triangles).sum() == pytest.approx(0.35, rel=1e-9)
    assert (area_vectors(points, triangles)[:, 2] > 0).all()
    assert is_edge_manifold(triangles) and euler_characteristic(triangles) == 1 and len(border_loops(triangles)) == 1
    for corner in ((0, 0, 0), (1, 0, 0), (1, 0.35, 0), (0, 0.35, 0)):
        assert np.linalg.norm(points - corner, axis=1).min() < 1e-12


def test_remesh_stays_on_a_cylinder() -> None:
    vertices, faces = grid(40, 1.0)
    angle = 3.0 * vertices[:, 0]
    bent = np.stack([np.cos(angle) / 3, np.sin(angle) / 3, vertices[:, 1]], 1)
    points, triangles = remesh(bent, faces, 0.05)
    radius = np.linalg.norm(points[:, :2], axis=1)
    assert np.abs(radius - 1 / 3).max() < 1e-3
    outward = points * (1, 1, 0) / radius[:, None]
    inner = ~border_vertices(triangles, len(points))
    assert ((vertex_normals(points, triangles) * outward).sum(1)[inner] > 0.99).all()


def test_changes_that_touch_are_taken_in_order() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        members = rng.integers(0, 60, (40, 4))
        wanted = np.flatnonzero(rng.random(40) < 0.8)
        taken: list[int] = []
        touched: set[int] = set()
        for change in wanted.tolist():
            if not touched & set(members[change].tolist()):
                taken.append(change)
                touched |= set(members[change].tolist())
        chosen = _apart(np.repeat(np.arange(40), 4), members.reshape(-1), wanted, 40, 60)
        assert 1 < len(taken) < len(wanted)
        assert chosen.tolist() == taken


def test_remeshing_a_copy_stays_on_the_surface_it_came_from() -> None:
    vertices, faces = grid(30, 1.0)
    angle = 3.0 * vertices[:, 0]
    bent = np.stack([np.cos(angle) / 3, np.sin(angle) / 3, vertices[:, 1]], 1)
    coarse = remesh(bent, faces, 0.1, 20)
    again, triangles = remesh(*coarse, 0.05, onto=(bent, faces))
    alone, _ = remesh(*coarse, 0.05)
    assert len(triangles) > 2 * len(coarse[1])
    assert np.abs(np.linalg.norm(again[:, :2], axis=1) - 1 / 3).max() < 5e-4
    assert np.abs(np.linalg.norm(alone[:, :2], axis=1) - 1 / 3).max() > 1e-3


def test_split_follows_the_line_exactly() -> None:
    vertices, faces = grid(9, 1.0)
    field = vertices[:, 0] + 0.7 * vertices[:, 1] - 0.6123
    points, triangles, positive = split_along(vertices, faces, field)
    value = points[:, 0] + 0.7 * points[:, 1] - 0.6123
    assert (value[triangles[positive]].min(axis=1) > -2e-3).all()
    assert (value[triangles[~positive]].max(axis=1) < 2e-3).all()
    assert face_areas(points, triangles).sum() == pytest.approx(1.0)
    assert (area_vectors(points, triangles)[:, 2] > 0).all()
    assert is_edge_manifold(triangles) and euler_characteristic(triangles) == 1
    x = np.linspace(0, 1, 200_001)
    exact = np.clip(1 - (0.6123 - x) / 0.7, 0, 1).mean()
    assert face_areas(points, triangles[positive]).sum() == pytest.approx(exact, abs=2e-3)


def test_strip_between_two_paths_covers_it_once() -> None:
    y = np.linspace(0, -1, 7)
    left = np.stack([np.zeros(7), y, np.zeros(7)], 1)
    right = np.stack([0.3 * np.ones(5), np.linspace(0, -1, 5), np.zeros(5)], 1)
    faces = strip_faces(np.vstack([left, right]), np.arange(7), 7 + np.arange(5))
    areas = area_vectors(np.vstack([left, right]), faces)[:, 2]
    assert len(faces) == 7 + 5 - 2
    assert (areas > 0).all()
    assert 0.5 * areas.sum() == pytest.approx(0.3)
