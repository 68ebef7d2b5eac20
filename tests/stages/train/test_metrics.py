"""Metrics on examples made by hand."""

import math

import numpy as np
import pytest

from stages.train import metrics


def test_surface_error_is_the_mean_distance_in_millimetres_over_the_mask() -> None:
    target = np.zeros((3, 3))
    predicted = np.array([[0.003, 0.004, 0.0], [0.0, 0.0, 0.001], [9.0, 9.0, 9.0]])
    assert metrics.surface_error(predicted, target, np.array([True, True, False])) == pytest.approx(3.0)


def test_normals_error_is_the_angle_of_tilted_faces() -> None:
    base = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    faces = np.array([[0, 1, 2], [1, 3, 2]])
    tilt = 0.3
    # Lifting the edge x = 1 tilts both faces about the y axis.
    tilted = np.zeros((4, 3))
    tilted[[1, 3], 2] = math.tan(tilt)
    mask = np.ones(4, bool)
    assert metrics.normals_error(tilted, np.zeros((4, 3)), base, faces, mask) == pytest.approx(tilt)
    assert metrics.normals_error(tilted, tilted, base, faces, mask) == 0.0


def test_normals_outside_the_mask_do_not_count() -> None:
    base = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    faces = np.array([[0, 1, 2], [1, 3, 2]])
    lifted = np.zeros((4, 3))
    lifted[3, 2] = 1.0
    assert metrics.normals_error(lifted, np.zeros((4, 3)), base, faces, np.array([True, True, True, False])) == 0.0


def test_intersection_over_union() -> None:
    first, second = np.array([1, 1, 1, 0, 0], bool), np.array([0, 1, 1, 1, 0], bool)
    assert metrics.mask_iou(first, second) == pytest.approx(0.5)
    assert metrics.mask_iou(first, first) == 1.0


def test_share_inside_the_body() -> None:
    normals = np.tile([0.0, 0.0, 1.0], (4, 1))
    offsets = np.array([[0, 0, -1.0], [1, 0, 0.1], [0, 0, -0.1], [0, 0, -5]])
    assert metrics.inside_share(offsets, normals, np.array([True, True, True, False])) == pytest.approx(2 / 3)


def test_both_averages() -> None:
    table = metrics.averages({"surface_mm": [1.0, 3.0, 10.0]}, ["top", "top", "skirt"])
    assert table["samples"]["surface_mm"] == pytest.approx(14 / 3)
    assert table["categories"]["surface_mm"] == pytest.approx(6.0)
    assert table["top"]["surface_mm"] == pytest.approx(2.0)
