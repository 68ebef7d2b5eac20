"""Flange, snapping, cleaning and untangling on flat pieces whose answer is known."""

import numpy as np
import pytest

from model.mesh.geometry import area_vectors, face_areas
from model.mesh.remesh import remesh
from model.mesh.split import split_along
from model.mesh.topology import border_loops, compact, edge_list
from stages.register.cover import _snap, _tidy, cover
from stages.register.flange import add_flange
from stages.register.quality import measure
from stages.register.target import Target
from stages.register.untangle import untangle


def sheet(n: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    """A flat square of n x n vertices around the origin, facing +z."""
    x, y = np.meshgrid(*(2 * [np.linspace(-size / 2, size / 2, n)]), indexing="ij")
    index = np.arange(n * n).reshape(n, n)
    a, b, c, d = (index[i : n - 1 + i, j : n - 1 + j].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), np.vstack(
        [np.stack([a, b, c], 1), np.stack([a, c, d], 1)]
    )


@pytest.fixture(scope="module")
def disk() -> tuple[np.ndarray, np.ndarray]:
    """A disk of radius 0.1 m with 6 mm edges."""
    vertices, faces = sheet(41, 0.3)
    points, triangles, positive = split_along(vertices, faces, 0.1 - np.linalg.norm(vertices, axis=1))
    triangles, used = compact(triangles[positive], len(points))
    return remesh(points[used], triangles, 0.006, passes=6)


def test_flange_widens_a_disk_in_its_plane(disk: tuple[np.ndarray, np.ndarray]) -> None:
    made = add_flange(*disk, width=0.03, rings=3)
    assert made.garment_faces == len(disk[1])
    np.testing.assert_array_equal(made.vertices[: len(disk[0])], disk[0])
    assert np.abs(made.vertices[:, 2]).max() < 1e-12
    assert (area_vectors(made.vertices, made.faces)[:, 2] > 0).all()
    rim = border_loops(made.faces)
    assert len(rim) == 1
    radius = np.linalg.norm(made.vertices[rim[0]], axis=1)
    assert np.abs(radius - 0.13).max() < 2e-3
    assert face_areas(made.vertices, made.faces).sum() == pytest.approx(np.pi * 0.13**2, rel=0.02)


def test_cover_of_a_disk_ends_on_its_circle(disk: tuple[np.ndarray, np.ndarray]) -> None:
    layer, faces = sheet(61, 0.6)
    layer[:, 2] = 0.001
    found = cover(layer, faces, Target(*disk), 0.02)
    radius = np.linalg.norm(layer[:, :2], axis=1)
    assert found.mask[radius < 0.095].all() and not found.mask[radius > 0.11].any()
    covered = faces[found.mask[faces].all(axis=1)]
    corners = disk[0][disk[1][np.maximum(found.face, 0)]]
    registered = (found.barycentric[:, :, None] * corners).sum(axis=1)
    edge = border_loops(covered)
    assert len(edge) == 1
    assert np.abs(np.linalg.norm(registered[edge[0]], axis=1) - 0.1).max() < 1.5e-3
    assert face_areas(registered, covered).sum() == pytest.approx(np.pi * 0.1**2, rel=0.01)
    quality = measure(*disk, registered, faces, found.mask, found.face, np.random.default_rng(0))
    assert quality.coverage == 1.0
    assert quality.turned_faces == 0
    assert quality.error_mean_m < 2e-5


def test_a_far_or_opposed_garment_covers_nothing(disk: tuple[np.ndarray, np.ndarray]) -> None:
    layer, faces = sheet(61, 0.6)
    target = Target(*disk)
    away = cover(layer + np.array([0, 0, 0.03]), faces, target, 0.02)
    assert not away.mask.any() and (away.face == -1).all()
    quality = measure(*disk, 0 * layer, faces, away.mask, away.face, np.random.default_rng(0))
    assert quality.coverage == 0.0 and np.isinf(quality.error_mean_m)
    assert not cover(layer + np.array([0, 0, 0.001]), faces[:, ::-1], target, 0.02).mask.any()


def test_islands_go_and_gaps_close() -> None:
    vertices, faces = sheet(61, 0.6)
    radius = np.linalg.norm(vertices, axis=1)
    inside = (radius < 0.2) & (radius > 0.015)
    inside |= np.linalg.norm(vertices - (0.27, 0.27, 0), axis=1) < 0.02
    tidy = _tidy(inside, edge_list(faces), (np.abs(vertices) > 0.299).any(axis=1))
    np.testing.assert_array_equal(tidy, radius < 0.2)


def test_snapping_leaves_no_crossing_edge_open() -> None:
    vertices, faces = sheet(31, 0.3)
    radius = np.linalg.norm(vertices, axis=1)
    inside, edges = radius < 0.1, edge_list(faces)
    snapped = _snap(inside, edges, np.abs(radius - 0.1))
    crossing = edges[inside[edges[:, 0]] != inside[edges[:, 1]]]
    assert snapped[crossing].any(axis=1).all()
    assert np.abs(radius[snapped] - 0.1).max() < 0.0101
    assert snapped.sum() < 0.6 * len(np.unique(crossing))


def test_untangle_turns_a_flipped_face_back(disk: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, faces = sheet(11, 0.1)
    target = Target(*disk)
    folded = vertices.copy()
    middle = 60
    folded[middle, :2] += (0.014, 0.003)
    index = target.closest(folded).faces
    on_border = np.zeros(len(folded), dtype=bool)
    assert (area_vectors(folded, faces)[:, 2] < 0).any()
    flat, where = untangle(folded, index, on_border, faces, target)
    assert (area_vectors(flat, faces)[:, 2] > 0).all()
    moved = np.abs(flat - folded).max(axis=1) > 0
    assert moved[middle] and moved.sum() < 15
    np.testing.assert_array_equal(where[~moved], index[~moved])
