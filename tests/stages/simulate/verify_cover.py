"""What is recorded covers skin that stands out between the vertices of the cloth on it."""

import igl
import numpy as np
import pytest
from small_scenes import PLAIN, ball, garment, scene, sheet, stepper

from stages.simulate.cover import CLEARANCE, FURTHEST
from stages.simulate.solve import presentable
from stages.simulate.stepper import Stepper

RADIUS, EDGE, MARGIN = 0.075, 0.03, 0.002


def capped(inside_out: bool = False) -> tuple[Stepper, np.ndarray, np.ndarray]:
    """A ball under a sheet of long edges whose vertices keep the margin: its corners, and the sheet's faces upwards."""
    vertices, faces = sheet(4, 4, EDGE)
    flat = vertices - vertices.mean(axis=0) + [1e-3, 2e-3, 0]
    far = np.linalg.norm(flat, axis=1)
    around = flat / far[:, None] * (RADIUS * np.sin(far / RADIUS))[:, None] + np.outer(
        RADIUS * np.cos(far / RADIUS), [0, 0, 1]
    )
    start = around * (1 + MARGIN / RADIUS)
    cloth = faces[:, ::-1].copy() if inside_out else faces
    skin, skin_faces = ball(RADIUS, 4)
    s = stepper(scene(garment(start, cloth, PLAIN), start=start, body=(skin, skin_faces)), gravity=0.0)
    s.advance_to(1e-3, 1e-3)
    return s, skin, faces.astype(np.int64)


def above(skin: np.ndarray, x: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Height [m] of those corners of the skin over the cloth that lie below or above the inside of a face."""
    _, face, foot = igl.point_mesh_squared_distance(skin, x, faces)
    a, b, c = (np.ascontiguousarray(x[faces[face, k]]) for k in range(3))
    up = np.cross(b - a, c - a)
    inner = (igl.barycentric_coordinates(foot, a, b, c) > 1e-3).all(axis=1)
    return np.asarray(((skin - foot) * up / np.linalg.norm(up, axis=1)[:, None]).sum(axis=1)[inner & (skin[:, 2] > 0)])


def test_skin_between_vertices_is_covered_in_the_record() -> None:
    s, skin, faces = capped()
    before = s.x.copy()
    assert above(skin, s.x, faces).max() > 5e-4
    x = presentable(s)
    assert above(skin, x, faces).max() < -0.5 * CLEARANCE
    moved = np.linalg.norm(x - s.x, axis=1)
    assert 5e-4 < moved.max() <= FURTHEST and np.linalg.norm(x, axis=1).min() > RADIUS + s.config.floor
    assert (s.x == before).all(), "the simulation goes on from its own positions"


def test_what_is_fixed_and_cloth_that_shows_its_back_stay() -> None:
    s, _, _ = capped()
    x = s.x.copy()
    assert s.cover(x, np.ones(len(x), np.int32), s.config.floor) == 0 and (x == s.x).all()
    s, skin, faces = capped(inside_out=True)
    assert above(skin, s.x, faces).max() > 5e-4
    x = s.x.copy()
    assert s.cover(x, s.fixed, s.config.floor) == 0 and (x == s.x).all()


def test_without_a_body_or_on_triangles_larger_than_the_cloth_there_is_nothing_to_cover() -> None:
    vertices, faces = sheet(3, 3, EDGE)
    ground = np.array([[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, -9.0]])
    sides = np.array([[0, 1, 2], [1, 0, 3], [2, 1, 3], [0, 2, 3]], np.int32)
    for body in (None, (ground, sides)):
        s = stepper(scene(garment(vertices, faces), start=vertices + np.array([0, 0, MARGIN]), body=body))
        s.advance_to(1e-3, 1e-3)
        assert s.cover(s.x.copy(), s.fixed, s.config.floor) == 0
        assert presentable(s) == pytest.approx(s.x)
