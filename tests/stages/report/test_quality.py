"""Quality figures on hand-made cases whose penetration and stretch are known."""

import numpy as np
import pytest

from stages.report.config import ReportConfig
from stages.report.facts import badges, metric_tables
from stages.report.quality import depth_inside, measure, stretches

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
CUBE_FACES = np.array([triangle for a, b, c, d in SIDES for triangle in ((a, b, c), (a, c, d))])


def test_depth_is_the_distance_to_the_nearest_face_inside_and_zero_outside():
    points = [[0.497, 0, 0], [0, 0, -0.46], [0.6, 0, 0], [3.0, 0, 0], [0.7, 0.7, 0.7], [0.5, 0.1, 0.1]]
    np.testing.assert_allclose(depth_inside(points, CUBE, CUBE_FACES), [0.003, 0.04, 0, 0, 0, 0], atol=1e-12)


def test_depth_deep_inside_is_not_cut_off():
    np.testing.assert_allclose(depth_inside([[0.0, 0.0, 0.1]], CUBE, CUBE_FACES), [0.4], atol=1e-12)


def test_depth_counts_where_two_parts_of_a_body_overlap():
    # A small cube lies across the first one's side. Just off the part of it that is inside, a point is still inside.
    small = 0.2 * CUBE + [0.5, 0.0, 0.0]
    vertices, faces = np.concatenate([CUBE, small]), np.concatenate([CUBE_FACES, CUBE_FACES + 8])
    points = [[0.39, 0.0, 0.0], [0.44, 0.0, 0.0], [0.61, 0.0, 0.0]]
    np.testing.assert_allclose(depth_inside(points, vertices, faces), [0.01, 0.04, 0.0], atol=1e-12)


def test_stretch_of_a_scaled_triangle_is_the_scale():
    rest = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    moving = np.stack([rest, 1.25 * rest, 0.5 * rest])
    np.testing.assert_allclose(stretches(moving, rest, [[0, 1, 2]]), np.array([[0.0], [0.25], [-0.5]]) * [1, 1, 1])


def sheet_over_the_cube(lift, pull):
    """A sheet of 3 x 3 vertices whose middle lies `lift` over the cube's top; one edge is `pull` longer in frame 1."""
    x, y = np.meshgrid([-0.2, 0.0, 0.2], [-0.2, 0.0, 0.2], indexing="ij")
    rest = np.stack([x.ravel(), y.ravel(), np.full(9, 0.51)], axis=1)
    faces = [[i, i + 3, i + 1] for i in (0, 1, 3, 4)] + [[i + 3, i + 4, i + 1] for i in (0, 1, 3, 4)]
    moving = np.stack([rest, rest])
    moving[1, 4, 2] = 0.5 + lift
    moving[1, 0, 0] -= 0.2 * pull
    return moving, rest, np.array(faces)


def figures(lift, pull):
    moving, rest, faces = sheet_over_the_cube(lift, pull)
    return measure(moving, rest, faces, np.stack([CUBE, CUBE]), CUBE_FACES, stretch_limit=0.10)


def test_measure_finds_the_worst_vertex_and_the_worst_edge():
    seen = figures(-0.004, 0.5)
    np.testing.assert_allclose(seen.depth, [0.0, 0.004], atol=1e-9)
    # 16 edges; two meet at the pulled corner: 0.2 m -> 0.3 m along x, and across it hypot(0.2, 0.1) m, 11.8 % longer.
    np.testing.assert_allclose(seen.stretched, [0.0, 2 / 16])
    assert seen.stretch_max == pytest.approx(0.5)
    assert seen.finite


def test_badges_pass_and_fail_as_the_limits_say():
    config = ReportConfig(max_stretched=0.1)
    assert [b.passed for b in badges({"a": figures(-0.0009, 0.0)}, config)] == [True, True, True]
    assert [b.passed for b in badges({"a": figures(-0.0011, 0.0)}, config)] == [True, False, True]
    assert [b.passed for b in badges({"a": figures(0.01, 0.0), "b": figures(0.01, 0.5)}, config)] == [True, True, False]
    assert badges({"a": figures(-0.004, 0.5)}, config)[1].value == "4.00 mm"


def test_one_number_that_is_not_finite_fails_every_badge():
    moving, rest, faces = sheet_over_the_cube(0.01, 0.0)
    moving[1, 3, 1] = np.nan
    seen = measure(moving, rest, faces, np.stack([CUBE, CUBE]), CUBE_FACES, 0.1)
    assert [b.passed for b in badges({"good": figures(0.01, 0.0), "bad": seen}, ReportConfig())] == [False] * 3


def test_metric_tables_mark_the_winner_of_each_column():
    rows = [
        {
            "model": "SVAE",
            "set": "static",
            "held_out": True,
            "items": 12,
            "surface_mm": 8.0,
            "mask_iou": 0.9,
            "kl": 3.0,
        },
        {"model": "mean", "set": "static", "held_out": True, "items": 12, "surface_mm": 14.0, "mask_iou": 0.95},
        {"model": "DVAE", "set": "sequence", "held_out": False, "surface_mm": 2.0},
    ]
    static, sequence = metric_tables(rows)
    assert static.header == ["model", "surface [mm]", "mask IoU", "KL"]
    assert static.rows == [["SVAE", "8.00", "0.900", "3.0"], ["mean", "14.00", "0.950", "–"]]
    assert static.best == {(0, 1), (1, 2)}
    assert "12 held-out" in static.title
    assert "none was held out" in sequence.title
