"""What lies inside an obstacle comes out by its margin; what lies outside stays."""

import numpy as np
import pytest

from stages.outfit.clearance import clear
from stages.outfit.obstacle import Gauge, Obstacle
from tests.stages.outfit.measures import angles, ball, tube


def test_a_tube_stretches_around_a_ball_that_bulges_out_of_it() -> None:
    points, faces = tube(0.09, 0.3, 0.01)
    body, body_faces = ball(0.1)
    obstacle = Obstacle(body + np.array([0.0, 0.0, 0.15]), body_faces, 0.003)
    fitted, left = clear(points, faces, [Gauge(obstacle, points)])
    assert left >= 0
    assert obstacle.distance(fitted)[0].min() >= 0.003
    assert np.linalg.norm(fitted - points, axis=1).max() < 0.02
    far = np.abs(points[:, 2] - 0.15) > 0.14
    assert np.linalg.norm(fitted - points, axis=1)[far].max() < 2e-3
    assert angles(fitted, faces).min() > 30


def test_a_tube_that_is_clear_is_left_as_it_is() -> None:
    points, faces = tube(0.12, 0.3, 0.01)
    body, body_faces = ball(0.1)
    obstacle = Obstacle(body + np.array([0.0, 0.0, 0.15]), body_faces, 0.003)
    fitted, left = clear(points, faces, [Gauge(obstacle, points)])
    assert np.array_equal(fitted, points)
    assert left == pytest.approx(0.017, abs=1e-3)


def test_extra_distance_is_kept_where_asked() -> None:
    points, faces = tube(0.105, 0.3, 0.01)
    body, body_faces = ball(0.1)
    obstacle = Obstacle(body + np.array([0.0, 0.0, 0.15]), body_faces, 0.003)
    extra = np.where(points[:, 0] > 0, 0.004, 0.0)
    fitted, _ = clear(points, faces, [Gauge(obstacle, points)], extra)
    assert obstacle.distance(fitted[points[:, 0] > 0])[0].min() >= 0.007


def test_a_vertex_deep_inside_comes_out_on_the_garments_own_side() -> None:
    """The nearest surface of a thick wall would be the wrong one for a vertex beyond its middle."""
    points, faces = tube(0.045, 0.1, 0.01)
    body, body_faces = ball(0.1)
    obstacle = Obstacle(body + np.array([0.0, 0.0, 0.05]), body_faces, 0.003)
    fitted, left = clear(points, faces, [Gauge(obstacle, points)])
    assert left >= 0
    radial = np.linalg.norm(fitted[:, :2], axis=1)
    assert radial.min() > 0.06
