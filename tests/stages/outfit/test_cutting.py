"""Cuts leave a border on the line, good triangles beside it, and everything else alone."""

import numpy as np
import pytest

from model.mesh.topology import border_loops, euler_characteristic, is_edge_manifold
from stages.outfit.cutting import cut
from stages.outfit.surface import Surface
from stages.outfit.template import load_template
from tests.stages.outfit.measures import angles, area, components, edge_lengths, tube

EDGE = 0.01


@pytest.mark.parametrize("height", np.linspace(0.081, 0.119, 9).tolist())
def test_a_tube_is_cut_at_any_height(height: float) -> None:
    points, faces = tube(0.1, 0.2, EDGE)
    cut_tube = cut(Surface.whole(points, faces), height - points[:, 2], EDGE)
    v, f = cut_tube.vertices, cut_tube.faces
    assert is_edge_manifold(f)
    assert components(v, f) == 1
    loops = border_loops(f)
    assert len(loops) == 2
    upper = max(loops, key=lambda loop: v[loop, 2].mean())
    assert np.abs(v[upper, 2] - height).max() < 5e-4
    assert v[:, 2].max() < height + 5e-4
    assert angles(v, f).min() > 20
    assert edge_lengths(v, f).min() > 0.45 * EDGE
    assert edge_lengths(v, f).max() < 2 * EDGE
    assert area(v, f) == pytest.approx(2 * np.pi * 0.1 * height, rel=0.01)


def test_a_slanted_wavy_line_on_a_tube() -> None:
    points, faces = tube(0.1, 0.2, EDGE)

    def line(p: np.ndarray) -> np.ndarray:
        return 0.1 + 0.3 * p[:, 0] + 0.01 * np.cos(3 * np.arctan2(p[:, 1], p[:, 0])) - p[:, 2]

    cut_tube = cut(Surface.whole(points, faces), line(points), EDGE)
    border = max(border_loops(cut_tube.faces), key=lambda loop: cut_tube.vertices[loop, 2].mean())
    assert np.abs(line(cut_tube.vertices[border])).max() < 5e-4
    assert angles(cut_tube.vertices, cut_tube.faces).min() > 20


def test_vertices_away_from_the_cut_stay_and_rows_say_where_the_others_come_from() -> None:
    points, faces = tube(0.1, 0.2, EDGE)
    cut_tube = cut(Surface.whole(points, faces), 0.1 - points[:, 2], EDGE)
    remembered = cut_tube.rows @ points
    assert np.asarray(cut_tube.rows.sum(axis=1)).ravel() == pytest.approx(1.0)
    # Means of points on a tube lie inside of it by the height of a chord's arc; tangential steps keep to the surface.
    assert np.linalg.norm(remembered - cut_tube.vertices, axis=1).max() < 2e-3
    far = cut_tube.vertices[:, 2] < 0.1 - 5 * EDGE
    assert far.sum() > 100
    assert np.array_equal(remembered[far], cut_tube.vertices[far])


def test_a_field_that_is_positive_everywhere_cuts_nothing() -> None:
    points, faces = tube(0.1, 0.2, EDGE)
    assert cut(Surface.whole(points, faces), 1.0 + points[:, 2], EDGE).vertices is points


@pytest.mark.parametrize("gender", ["female", "male"])
@pytest.mark.parametrize("share", [0.13, 0.37, 0.62, 0.9])
def test_sleeves_of_any_length(gender: str, share: float) -> None:
    template = load_template("tshirt", gender, 0.014)
    field = np.where(
        template.vertices[:, 2] > template.axes.shoulder[2] - 0.2,
        (share - template.axes.along_arm(template.vertices)) * template.axes.arm_length,
        1.0,
    )
    shirt = cut(Surface.whole(template.vertices, template.faces), field, template.edge)
    assert is_edge_manifold(shirt.faces)
    assert euler_characteristic(shirt.faces) == 2 - 4
    loops = border_loops(shirt.faces)
    assert len(loops) == 4
    ends = [loop for loop in loops if abs(shirt.vertices[loop, 0].mean()) > template.axes.shoulder[0]]
    assert len(ends) == 2
    for loop in ends:
        off = (share - template.axes.along_arm(shirt.vertices[loop])) * template.axes.arm_length
        assert np.abs(off).max() < 5e-4
    assert angles(shirt.vertices, shirt.faces).min() > 18
