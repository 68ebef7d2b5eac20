"""What lies inside an obstacle comes out by its margin; what lies outside stays."""

import numpy as np
import pytest

from stages.outfit.clearance import clear
from stages.outfit.obstacle import Obstacle
from tests.stages.outfit.measures import angles, ball, tube


def test_distance_to_a_ball_is_exact_inside_and_outside() -> None:
    points, faces = ball(0.1)
    obstacle = Obstacle(points, faces, 0.003)
    probe = np.array([[0.05, 0.0, 0.0], [0.0, 0.16, 0.0], [0.0, 0.0, -0.02]])
    distance, outwards = obstacle.distance(probe)
    assert distance == pytest.approx([-0.05, 0.06, -0.08], abs=1e-3)
    assert (outwards * probe).sum(axis=1) / np.linalg.norm(probe, axis=1) == pytest.approx(1.0, abs=0.02)


def test_a_tube_stretches_around_a_ball_that_bulges_out_of_it() -> None:
    points, faces = tube(0.09, 0.3, 0.01)
    body, body_faces = ball(0.1)
    obstacle = Obstacle(body + np.array([0.0, 0.0, 0.15]), body_faces, 0.003)
    fitted, left = clear(points, faces, [obstacle])
    assert left >= 0
    assert obstacle.distance(fitted)[0].min() >= 0.003
    assert np.linalg.norm(fitted - points, axis=1).max() < 0.02
    far = np.abs(points[:, 2] - 0.15) > 0.14
    assert np.linalg.norm(fitted - points, axis=1)[far].max() < 2e-3
    assert angles(fitted, faces).min() > 30


def test_a_tube_that_is_clear_is_left_as_it_is() -> None:
    points, faces = tube(0.12, 0.3, 0.01)
    body, body_faces = ball(0.1)
    fitted, left = clear(points, faces, [Obstacle(body + np.array([0.0, 0.0, 0.15]), body_faces, 0.003)])
    assert np.array_equal(fitted, points)
    assert left == pytest.approx(0.017, abs=1e-3)


def test_extra_distance_is_kept_where_asked() -> None:
    points, faces = tube(0.105, 0.3, 0.01)
    body, body_faces = ball(0.1)
    obstacle = Obstacle(body + np.array([0.0, 0.0, 0.15]), body_faces, 0.003)
    extra = np.where(points[:, 0] > 0, 0.004, 0.0)
    fitted, _ = clear(points, faces, [obstacle], extra)
    assert obstacle.distance(fitted[points[:, 0] > 0])[0].min() >= 0.007


def test_a_vertex_deep_inside_comes_out_on_the_garments_own_side() -> None:
    """The nearest surface of a thick wall would be the wrong one for a vertex beyond its middle."""
    points, faces = tube(0.045, 0.1, 0.01)
    body, body_faces = ball(0.1)
    fitted, left = clear(points, faces, [Obstacle(body + np.array([0.0, 0.0, 0.05]), body_faces, 0.003)])
    assert left >= 0
    radial = np.linalg.norm(fitted[:, :2], axis=1)
    assert radial.min() > 0.06
