"""Cloth that has passed through cloth comes apart again."""

import numpy as np
import pytest

from model.mesh.intersection import self_intersecting_faces
from stages.simulate.patches import Patches
from stages.simulate.springs import unique_edges
from stages.simulate.untangle import Crossings, opposite_vertices
from tests.stages.simulate.small_scenes import garment, scene, sheet, stepper


def _poked() -> tuple[np.ndarray, np.ndarray]:
    """Two sheets of one garment, a corner of the upper pushed 8 mm through the lower."""
    vertices, faces = sheet(9, 9, 0.01)
    upper = vertices + np.array([0.023, 0.017, 0.006])
    corner = np.exp(-((vertices[:, :2] - vertices[0, :2]) ** 2).sum(1) / 0.02**2)
    upper[:, 2] -= 0.014 * corner
    return np.concatenate([vertices, upper]), np.concatenate([faces, faces + len(vertices)])


def test_a_corner_pushed_through_a_sheet_comes_out() -> None:
    vertices, faces = _poked()
    before = len(self_intersecting_faces(vertices, faces))
    assert before > 5, "the corner must cross the sheet to begin with"
    rest = vertices.copy()
    rest[len(vertices) // 2 :, 2] = 0.1
    s = stepper(scene(garment(rest, faces), start=vertices), gravity=0.0)
    s.advance_to(0.6, s.config.dt)
    assert len(self_intersecting_faces(s.x, faces)) == 0
    assert np.linalg.norm(s.v, axis=1).max() < 0.5, "taking apart must not fling the cloth"


def test_shortening_leaves_what_does_not_cross() -> None:
    vertices, faces = _poked()
    vertices[len(vertices) // 2 :, 2] += 0.05
    edges, _ = unique_edges(faces)
    c = Crossings(Patches(vertices, faces, edges), np.zeros(len(vertices), np.int32))
    c.edge, c.face = np.arange(8), np.arange(8) + 60
    x = vertices.copy()
    assert not c.shorten(x, np.ones(len(x)), np.zeros(len(x), np.int32))
    assert np.array_equal(x, vertices)


def test_fixed_vertices_stay_and_light_ones_move_more() -> None:
    vertices, faces = _poked()
    edges, _ = unique_edges(faces)
    half = len(vertices) // 2
    patches = Patches(vertices, faces, edges)
    c = Crossings(patches, np.zeros(len(vertices), np.int32))
    many = len(patches.layer)
    everything = np.tile(np.arange(many, dtype=np.int32), (many, 1))
    corners = vertices[patches.faces]
    centre = corners.mean(1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(1)
    c.find(vertices, centre, radius, np.ones(len(vertices), np.int32), False, np.full(many, many, np.int32), everything)
    assert len(c.edge) > 5
    mass, fixed = np.ones(len(vertices)), np.zeros(len(vertices), np.int32)
    mass[half:] = 0.1
    x = vertices.copy()
    assert c.shorten(x, mass, fixed)
    moved = np.linalg.norm(x - vertices, axis=1)
    assert moved[half:].max() > 3 * moved[:half].max() > 0
    fixed[:half] = 1
    x = vertices.copy()
    c.shorten(x, mass, fixed)
    assert np.array_equal(x[:half], vertices[:half])


@pytest.mark.parametrize("seed", [0, 1])
def test_opposite_vertices_are_those_of_the_faces_beside(seed: int) -> None:
    _, faces = sheet(4, 5, 0.01)
    edges, _ = unique_edges(faces)
    edges = np.random.default_rng(seed).permutation(edges)
    for edge, wings in zip(edges, opposite_vertices(edges, faces)):
        beside = [set(f) - set(edge) for f in faces.tolist() if set(edge) <= set(f)]
        assert {w for w in wings if w >= 0} == set().union(*beside)
