"""Distances that are followed are those that would be measured anew; no face that meets the surface is left out."""

import numpy as np
import pytest

from model.mesh.intersection import intersecting_faces
from stages.outfit.obstacle import Gauge, Obstacle
from tests.stages.outfit.measures import ball, tube

BALL, BALL_FACES = ball(0.1)
BODY = Obstacle(BALL, BALL_FACES, 0.003)


def test_distance_to_a_ball_is_exact_inside_and_outside() -> None:
    probe = np.array([[0.05, 0.0, 0.0], [0.0, 0.16, 0.0], [0.0, 0.0, -0.02]])
    distance, outwards = BODY.distance(probe)
    assert distance == pytest.approx([-0.05, 0.06, -0.08], abs=1e-3)
    assert (outwards * probe).sum(axis=1) / np.linalg.norm(probe, axis=1) == pytest.approx(1.0, abs=0.02)


def test_followed_distances_are_those_measured_anew() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.15, 0.15, (400, 3))
    gauge, reach = Gauge(BODY, points), rng.uniform(0.0, 0.02, 400)
    crossed = 0
    for size in (0.0, 1e-4, 0.003, 0.05, 0.2, 0.001):
        before = BODY.distance(points)[0]
        points = points + size * rng.standard_normal((400, 3)) * (rng.random(400) < 0.7)[:, None]
        gauge.follow(points, reach)
        distance, outwards = BODY.distance(points)
        crossed += int(((before < 0) != (distance < 0)).sum())
        near = distance < reach
        assert near.sum() > 20
        assert np.array_equal(gauge.distance[near], distance[near])
        assert np.array_equal(gauge.outwards[near], outwards[near])
        assert (gauge.lacking(reach - BODY.margin)[~near] <= 0).all()
    assert crossed > 80


def test_only_what_may_have_come_near_is_measured() -> None:
    points = np.array([[0.2, 0.0, 0.0], [0.11, 0.0, 0.0], [0.0, 0.105, 0.0]])
    gauge = Gauge(BODY, points)
    first = gauge.distance.copy()
    gauge.follow(points - np.array([0.005, 0.0, 0.0]), 0.006)
    assert gauge.distance[0] == first[0]
    assert gauge.distance[1] == pytest.approx(0.005, abs=1e-3)


def test_faces_that_meet_the_surface_are_always_among_the_suspects() -> None:
    """Also those that a needle of the surface pierces far from their corners, after vertices moved."""
    points, faces = tube(0.11, 0.3, 0.02)
    points[:, 2] -= 0.15
    spikes = BALL.copy()
    spikes[::7] *= 1.2
    spiky = Obstacle(spikes, BALL_FACES, 0.003)
    gauge = Gauge(spiky, points)
    moved = points * [0.97, 1.0, 1.0]
    gauge.follow(moved, 0.003)
    suspects = gauge.may_meet(moved, faces)
    met = np.unique(intersecting_faces(moved, faces, spikes, BALL_FACES)[:, 0])
    assert len(met) > 20 and suspects[met].all()
    assert suspects.mean() < 0.8
