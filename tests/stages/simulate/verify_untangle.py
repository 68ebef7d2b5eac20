"""Cloth that has passed through cloth comes apart again."""

import numpy as np
import pytest

from model.mesh.intersection import self_intersecting_faces
from stages.simulate.patches import Patches
from stages.simulate.solve import presentable
from stages.simulate.springs import unique_edges
from stages.simulate.stepper import Stepper
from stages.simulate.tidy import FURTHEST, Tidy
from stages.simulate.untangle import PACE, Crossings, opposite_vertices
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
    stored = _elastic_energy(s)
    s.advance_to(0.6, s.config.dt)
    assert len(self_intersecting_faces(s.x, faces)) == 0
    moving = 0.5 * (s.springs.mass[:, None] * s.v**2).sum()
    assert moving + _elastic_energy(s) < stored, "taking apart must not fling the cloth"


def test_a_record_shows_it_apart_before_it_has_come_out() -> None:
    vertices, faces = _poked()
    rest = vertices.copy()
    rest[len(vertices) // 2 :, 2] = 0.1
    s = stepper(scene(garment(rest, faces), start=vertices), gravity=0.0)
    s.step(1e-4)
    assert len(self_intersecting_faces(s.x, faces)) > 5
    x = presentable(s)
    assert len(self_intersecting_faces(x, faces)) == 0
    moved = np.linalg.norm(x - s.x, axis=1)
    assert (moved > 0).sum() < 0.4 * len(x) and moved.max() <= FURTHEST + 1e-9
    assert len(self_intersecting_faces(s.x, faces)) > 5, "the simulation's own positions stay"
    # What is fixed is moved past, or stays crossed.
    still, fixed = s.x.copy(), np.repeat([1, 0], len(vertices) // 2).astype(np.int32)
    before, after = Tidy(s.pairs, s.contact)(still, fixed, 0.001)
    assert after < before and (still[fixed == 1] == s.x[fixed == 1]).all()


def test_what_is_moved_apart_stays_out_of_the_skin() -> None:
    # The lower sheet lies a little above a plate's floor, and a corner of the upper is pushed 1.2 mm through it.
    vertices, faces = _poked()
    rest, half = vertices.copy(), len(vertices) // 2
    rest[half:, 2] = 0.1
    start = vertices * [1.0, 1.0, 0.15] + [0.0, 0.0, 0.0024]
    plate = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    s = stepper(scene(garment(rest, faces), start=start, body=plate), gravity=0.0)
    s.step(1e-6)
    s.contact.tuck(s.x.copy(), 1.0)
    x, before, floor = s.x.copy(), s.x[:, 2].copy(), 0.0022
    assert s.tidy is not None
    crossed, left = s.tidy(x, s.fixed, floor)
    assert left < crossed and (x != s.x).any()
    assert (x[:, 2] >= np.minimum(before, floor) - 1e-9).all()


def _elastic_energy(s: Stepper) -> float:
    """What stretched edges hold [J], stiffening left out."""
    ends = s.x[s.springs.edges]
    longer = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) - s.springs.rest_length
    return float(0.5 * (s.springs.stiffness * longer**2).sum())


def _crossings(vertices: np.ndarray, faces: np.ndarray) -> Crossings:
    """All crossings of the sheets."""
    edges, _ = unique_edges(faces)
    patches = Patches(vertices, faces, edges)
    c = Crossings(patches, np.zeros(len(vertices), np.int32))
    many = len(patches.layer)
    everything = np.tile(np.arange(many, dtype=np.int32), (many, 1))
    corners = vertices[patches.faces]
    centre = corners.mean(1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(1)
    c.find(vertices, centre, radius, np.ones(len(vertices), np.int32), False, np.full(many, many, np.int32), everything)
    return c


def test_nothing_pulls_at_what_crosses_no_longer() -> None:
    vertices, faces = _poked()
    c = _crossings(vertices, faces)
    assert 10 < len(c.ways(vertices)[0]) <= 2 * len(c.edge)
    vertices[len(vertices) // 2 :, 2] += 0.05
    assert len(c.ways(vertices)[0]) == 0


def test_a_blade_is_drawn_out_of_a_sheet_along_its_cut() -> None:
    """The contour goes on to both sides of the edges within the blade: only that at its end has a way to go."""
    lower, faces = sheet(9, 9, 0.01)
    upright = lower[:, [0, 2, 1]] + [0.0513, 0.0337, -0.0423]
    c = _crossings(np.concatenate([lower, upright]), np.concatenate([faces, faces + len(lower)]))
    x = np.concatenate([lower, upright])
    vertices, way, pace = c.ways(x)
    first = x[vertices[:, 0], 0] < upright[:, 0].min() + 1e-6
    other = np.tile(c.patches.edges[c.edge], (2, 1))
    rim = (vertices[:, 0] >= len(lower)) & first & (x[other, 0] < upright[:, 0].min() + 1e-6).all(axis=1)
    assert rim.any()
    assert (way[rim, 0] > 0.9).all()
    assert 1e-3 < pace[rim].min() <= pace.max() <= PACE


@pytest.mark.parametrize("seed", [0, 1])
def test_opposite_vertices_are_those_of_the_faces_beside(seed: int) -> None:
    _, faces = sheet(4, 5, 0.01)
    edges, _ = unique_edges(faces)
    edges = np.random.default_rng(seed).permutation(edges)
    for edge, wings in zip(edges, opposite_vertices(edges, faces)):
        beside = [set(f) - set(edge) for f in faces.tolist() if set(edge) <= set(f)]
        assert {w for w in wings if w >= 0} == set().union(*beside)
