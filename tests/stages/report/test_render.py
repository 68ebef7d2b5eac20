"""Pictures of scenes whose look is known beforehand."""

import numpy as np
import pytest

from stages.report.backdrop import bilinear
from stages.report.camera import Camera
from stages.report.light import BOUNCED, bake_dome, dome_radiance, fibonacci_sphere, key_directions
from stages.report.render import Mesh, Studio, linear, render, screen
from stages.report.sheet import contact_sheet

FRONT = -0.5 * np.pi
RED, GREEN = (0.8, 0.1, 0.1), (0.1, 0.8, 0.1)


def square(centre, side=1.0, away=(0.0, -1.0, 0.0), **look):
    """An upright square of `side` metres, its outside towards `away` (-y or +y)."""
    h = 0.5 * side
    corners = np.array([[-h, 0, -h], [h, 0, -h], [h, 0, h], [-h, 0, h]]) + centre
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return Mesh(vertices=corners, faces=faces if away[1] < 0 else faces[:, ::-1], **look)


def camera(span=2.0):
    """A level camera in front of the world's origin whose picture is `span` metres high there."""
    return Camera.around(np.zeros(3), FRONT, height=span, elevation=0.0)


def covered(picture, empty):
    """Where a picture differs from that of an empty scene."""
    return np.any(picture != empty, axis=2)


def empty_scene():
    return Mesh(vertices=np.array([[0, 90.0, 0], [1, 90, 0], [0, 90, 1]]), faces=np.array([[0, 1, 2]]))


def test_square_covers_its_share_of_the_picture():
    cam = camera()
    picture = render([square(np.zeros(3))], cam, 100, 100, floor=None)
    background = render([empty_scene()], Camera(position=(0, 5, 0), target=(0, 0, 0)), 100, 100, floor=None)
    shown = covered(picture, background)
    # 1 m of 2 m in both directions, up to the outline's antialiased pixels.
    assert abs(shown.mean() - 0.25) < 0.012
    rows, columns = np.nonzero(shown)
    assert abs(rows.mean() - 49.5) < 0.5
    assert abs(columns.mean() - 49.5) < 0.5


def test_nearer_mesh_hides_the_farther_one():
    near, far = square([0, -0.2, 0], 0.5, colour=GREEN), square([0, 0.2, 0], 1.0, colour=RED)
    for order in ([near, far], [far, near]):
        picture = render(order, camera(), 120, 120, floor=None)
        assert picture[60, 60, 1] > 2 * picture[60, 60, 0]
        assert picture[60, 35, 0] > 2 * picture[60, 35, 1]


def test_picture_is_not_mirrored_and_up_is_up():
    picture = render([square([0.5, 0, 0.5], 0.4, colour=RED)], camera(), 80, 80, floor=None).astype(int)
    reddest = np.unravel_index(np.argmax(picture[..., 0] - picture[..., 1]), (80, 80))
    # From the front, where -y is, +x is to the right.
    assert reddest[0] < 40 < reddest[1]


def test_both_sides_of_a_garment_are_lit():
    outside = render([square(np.zeros(3), colour=RED)], camera(), 40, 40, floor=None)[20, 20].astype(int)
    inside = render([square(np.zeros(3), away=(0, 1, 0), colour=RED)], camera(), 40, 40, floor=None)[20, 20]
    assert inside[0] > 100
    assert np.abs(outside - inside).max() <= 1


def test_hue_of_the_picture_is_the_colour_of_the_mesh():
    picture = render([square(np.zeros(3), colour=(0.2, 0.4, 0.6))], camera(), 40, 40, floor=None)
    light = linear(picture[20, 20] / 255.0)
    wanted = linear((0.2, 0.4, 0.6))
    np.testing.assert_allclose(light / light[2], wanted / wanted[2], atol=0.02)


def test_shadow_falls_on_what_lies_behind():
    wall = square([0, 0.3, 0], 2.0, colour=(0.7, 0.7, 0.7))
    # Out of sight above and to the left, between the lamp and the middle of the wall.
    lamp = key_directions(FRONT).mean(axis=0)
    blind = square(np.array([0, 0.3, 0]) + 1.6 * lamp, 0.5)
    cam = camera(1.2)
    lit = render([wall], cam, 60, 60, floor=None).astype(int)
    shaded = render([wall, blind], cam, 60, 60, floor=None).astype(int)
    assert lit[30, 30, 0] - shaded[30, 30, 0] > 25
    assert np.abs(lit[55, 55] - shaded[55, 55]).max() < 25


def test_floor_shows_a_shadow_at_the_feet_and_nothing_far_away():
    cam = Camera.around(np.array([0, 0, 0.5]), FRONT, height=2.0, elevation=0.3)
    box = square([0, 0, 0.5], 0.8, colour=RED)
    with_floor, without = (render([box], cam, 200, 200, floor=f).astype(int) for f in (0.0, None))
    drop = (without - with_floor).sum(axis=2)
    assert drop.max() > 60
    assert np.all(drop[:40] == 0)


def test_smooth_and_flat_shading_differ_only_within_a_mesh():
    angle = np.linspace(-1.2, 1.2, 8)
    arc = np.stack([np.sin(angle), -np.cos(angle)], axis=1) * 0.5
    vertices = np.concatenate([np.column_stack([arc, np.full(8, z)]) for z in (-0.5, 0.5)])
    i = np.arange(7)
    faces = np.concatenate([np.stack([i, i + 1, i + 9], 1), np.stack([i, i + 9, i + 8], 1)])
    flat, smooth = (
        render([Mesh(vertices=vertices, faces=faces, smooth=s)], camera(), 100, 100, floor=None).astype(int)[50]
        for s in (False, True)
    )
    # A row across seven flat facets has few grey levels; interpolated normals give many more.
    inside = slice(30, 70)
    assert len(np.unique(flat[inside, 0])) < 14 < len(np.unique(smooth[inside, 0]))


def test_pictures_have_equal_bits_at_every_run():
    rng = np.random.default_rng(3)
    mesh = Mesh(vertices=rng.normal((0, 0, 1), 0.4, (60, 3)), faces=rng.integers(0, 60, (90, 3)))
    cam = Camera.around(np.array([0, 0, 1.0]), 0.4)
    first = render([mesh], cam, 90, 120)
    assert all(np.array_equal(render([mesh], cam, 90, 120), first) for _ in range(3))
    studio = Studio([mesh])
    assert np.array_equal(studio.picture(cam, 90, 120), first)


def test_camera_directions_and_projection_are_inverse():
    cam = Camera.around(np.array([0.3, -0.2, 1.1]), 0.7, height=1.7, elevation=0.2)
    pixels = np.array([[10.0, 20.0], [100.5, 3.25], [0.0, 200.0]])
    points = np.asarray(cam.position) + 4.2 * cam.directions(pixels, 120, 200)
    np.testing.assert_allclose(cam.project(points, 120, 200), pixels, atol=1e-3)


def test_picture_spans_the_height_asked_for():
    cam = Camera.around(np.array([1.0, 2.0, 3.0]), 0.0, height=2.0, elevation=0.0)
    ends = cam.project(np.array([[1.0, 2.0, 4.0], [1.0, 2.0, 2.0]]), 100, 100)
    np.testing.assert_allclose(ends[:, 1], [0.0, 100.0], atol=1e-9)


def test_dome_light_on_an_open_surface_is_one_and_under_a_roof_less():
    up = np.array([[0.0, 0.0, 1.0]])
    nothing = bake_dome(np.zeros((1, 3)), up, lambda o, d: np.zeros(len(o), dtype=bool))
    np.testing.assert_allclose(nothing, 1.0, rtol=1e-12)
    # A roof that hides everything within 45 degrees of the zenith.
    roof = bake_dome(np.zeros((1, 3)), up, lambda o, d: d[:, 2] > np.sqrt(0.5))
    directions = fibonacci_sphere(20000)
    seen = dome_radiance(directions) * np.maximum(directions[:, 2], 0.0)
    share = seen[directions[:, 2] <= np.sqrt(0.5)].sum() / seen.sum()
    assert roof[0] == pytest.approx(BOUNCED + (1.0 - BOUNCED) * share, abs=0.08)


def test_screen_curve_is_inverse_of_linear():
    levels = np.arange(256)
    np.testing.assert_array_equal(screen(linear(levels / 255.0)), levels)


def test_bilinear_is_exact_on_a_plane_and_holds_the_border():
    i, j = np.meshgrid(np.arange(4.0), np.arange(5.0), indexing="ij")
    cells = np.array([[0.25, 3.5], [2.9, 0.1], [3.0, 4.0], [9.0, -1.0]])
    inside = np.clip(cells, 0, [3, 4])
    np.testing.assert_allclose(bilinear(2 * i - 3 * j, cells), 2 * inside[:, 0] - 3 * inside[:, 1], atol=1e-12)


def test_contact_sheet_places_pictures_in_rows():
    pictures = [np.full((2, 3, 3), k, dtype=np.uint8) for k in range(3)]
    sheet = contact_sheet(pictures, 2, gap=1)
    assert sheet.shape == (5, 7, 3)
    assert np.all(sheet[:2, :3] == 0)
    assert np.all(sheet[:2, 4:] == 1)
    assert np.all(sheet[3:, :3] == 2)
    assert np.all(sheet[3:, 4:] == 255)
    assert np.all(sheet[2] == 255)
