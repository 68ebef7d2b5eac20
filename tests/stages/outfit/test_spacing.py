"""Edges that are too short or too long are mended by sliding: borders, seams and what is further away stay."""

import numpy as np

from model.mesh.topology import border_vertices, edge_list
from stages.outfit.obstacle import Gauge, Obstacle
from stages.outfit.spacing import LEAST, MOST, space
from tests.stages.outfit.measures import angles, ball, edge_lengths, tube

EDGE, RADIUS, HEIGHT = 0.01, 0.1, 0.2


def squeezed(reach: float, height: float, share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A tube's points, faces, and which vertices were drawn to a vertical line, near a height [m]."""
    points, faces = tube(RADIUS, HEIGHT, EDGE)
    angle = np.arctan2(points[:, 1], points[:, 0])
    drawn = (np.abs(angle) < 0.25) & (np.abs(points[:, 2] - height) < reach)
    angle = np.where(drawn, share * angle, angle)
    points[:, :2] = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return points, faces, drawn


def spaced(points: np.ndarray, faces: np.ndarray, seam: np.ndarray, obstacle: Obstacle) -> tuple[np.ndarray, float]:
    return space(points, faces, EDGE, seam, [Gauge(obstacle, points)], np.zeros(len(points)))


def test_short_and_long_edges_are_mended_and_the_cloth_stays_where_it_is() -> None:
    points, faces, _ = squeezed(0.03, 0.1, 0.45)
    far = Obstacle(*ball(0.01), 0.002)
    lengths = edge_lengths(points, faces)
    assert lengths.min() < 0.47 * EDGE
    new, _ = spaced(points, faces, np.zeros(len(points), dtype=bool), far)
    lengths = edge_lengths(new, faces)
    assert lengths.min() > 0.5 * EDGE
    assert lengths.max() < 2 * EDGE
    assert angles(new, faces).min() > angles(points, faces).min()
    assert np.abs(np.linalg.norm(new[:, :2], axis=1) - RADIUS).max() < 0.02 * EDGE
    away = np.abs(np.arctan2(points[:, 1], points[:, 0])) > 0.8
    assert np.array_equal(new[away], points[away])


def test_a_long_edge_is_drawn_together() -> None:
    points, faces = tube(RADIUS, HEIGHT, EDGE)
    edges = edge_list(faces)
    middle = np.linalg.norm(points[edges].mean(axis=1) - [RADIUS, 0, 0.1], axis=1).argmin()
    a, b = edges[middle]
    points[a], points[b] = points[a] + 0.55 * (points[a] - points[b]), points[b] + 0.55 * (points[b] - points[a])
    assert edge_lengths(points, faces).max() > 2 * EDGE
    new, _ = spaced(points, faces, np.zeros(len(points), dtype=bool), Obstacle(*ball(0.01), 0.002))
    assert edge_lengths(new, faces).max() < (MOST + 0.01) * EDGE
    assert edge_lengths(new, faces).min() > (LEAST - 0.01) * EDGE


def test_vertices_of_borders_and_seams_slide_along_them() -> None:
    points, faces, drawn = squeezed(0.03, 0.0, 0.45)
    on_border = border_vertices(faces, len(points))
    seam = np.abs(points[:, 2] - points[np.abs(points[:, 2] - 0.0173).argmin(), 2]) < 1e-6
    new, _ = spaced(points, faces, seam, Obstacle(*ball(0.01), 0.002))
    for line in (on_border, seam):
        assert (new[line & drawn] != points[line & drawn]).any()
        assert np.abs(new[line, 2] - points[line, 2]).max() < 1e-9
        assert np.abs(np.linalg.norm(new[line, :2], axis=1) - RADIUS).max() < 0.02 * EDGE
    assert edge_lengths(new, faces).min() > 0.5 * EDGE


def test_nothing_comes_too_near_to_what_is_to_be_kept_clear_of() -> None:
    points, faces, _ = squeezed(0.03, 0.1, 0.45)
    points[:, 2] -= 0.1
    body, triangles = ball(RADIUS - 0.002)
    obstacle = Obstacle(body, triangles, 0.002)
    start = obstacle.distance(points)[0].min()
    new, left = spaced(points, faces, np.zeros(len(points), dtype=bool), obstacle)
    assert edge_lengths(new, faces).min() > 0.5 * EDGE
    assert obstacle.distance(new)[0].min() > min(start, obstacle.margin) - 1e-5
    assert left > -1e-5


def test_a_clean_mesh_is_left_alone() -> None:
    points, faces = tube(RADIUS, HEIGHT, EDGE)
    new, left = spaced(points, faces, np.zeros(len(points), dtype=bool), Obstacle(*ball(0.01), 0.002))
    assert new is points
    assert left == np.inf


def test_a_flat_triangle_is_raised_though_its_edges_are_long_enough() -> None:
    points, faces = tube(RADIUS, HEIGHT, EDGE)
    corner = faces[np.abs(points[faces].mean(axis=1) - [RADIUS, 0, 0.1]).sum(axis=1).argmin()]
    a, b, c = points[corner]
    points[corner[0]] += 0.9 * ((b + c) / 2 - a)
    points[corner[1]] += 0.1 * (b - c)
    points[corner[2]] -= 0.1 * (b - c)
    assert angles(points, faces).min() < 10
    assert 0.52 < edge_lengths(points, faces).min() / EDGE < edge_lengths(points, faces).max() / EDGE < 1.95
    new, _ = spaced(points, faces, np.zeros(len(points), dtype=bool), Obstacle(*ball(0.01), 0.002))
    assert angles(new, faces).min() > 15
    assert edge_lengths(new, faces).min() > 0.5 * EDGE
