"""Registration of garments whose correspondences and cut are known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from model.body.layer import GarmentLayer
from model.mesh.topology import border_loops, component_labels, edge_list, edges_with_counts
from stages.register.config import RegisterConfig
from stages.register.cover import cover
from stages.register.fit import Gate, fit
from stages.register.garment import Registration, register_garment
from stages.register.source import source_surface
from stages.register.target import Target

CONFIG = RegisterConfig()

Made = Any
"""A garment of `conftest.make`: vertices, faces, true, inside."""


def register(made: Made, layer: GarmentLayer, kind: str) -> Registration:
    rng = np.random.default_rng(0)
    return register_garment(made.vertices, made.faces, layer, np.zeros(10), kind, CONFIG, rng)


@pytest.fixture(scope="module")
def results(
    tshirt: Made, skirt: Made, trousers: Made, layer: GarmentLayer
) -> dict[str, tuple[Made, str, Registration]]:
    return {
        "tshirt": (tshirt, "skirt", register(tshirt, layer, "tshirt")),
        "skirt": (skirt, "skirt", register(skirt, layer, "skirt")),
        "trousers": (trousers, "body", register(trousers, layer, "trousers")),
    }


@pytest.mark.parametrize("name", ["tshirt", "skirt", "trousers"])
def test_error_is_below_the_bar(results: dict[str, tuple[Made, str, Registration]], name: str) -> None:
    quality = results[name][2].quality
    assert quality.error_mean_m < 0.5e-3
    assert quality.error_p95_m < 1.5e-3
    assert quality.coverage > 0.995
    assert quality.longest_edge_m < 0.06
    assert quality.turned_faces == 0


@pytest.mark.parametrize("name", ["tshirt", "skirt", "trousers"])
def test_correspondences_are_those_of_the_making(results: dict[str, tuple[Made, str, Registration]], name: str) -> None:
    made, _, result = results[name]
    sure = result.cover.mask & (made.inside > 0.015)
    away = np.linalg.norm(result.registered - made.true, axis=1)[sure]
    assert np.median(away) < 3e-3
    assert np.percentile(away, 95) < 10e-3


@pytest.mark.parametrize("name", ["tshirt", "skirt", "trousers"])
def test_mask_is_the_cut(results: dict[str, tuple[Made, str, Registration]], name: str) -> None:
    made, _, result = results[name]
    mask, truth = result.cover.mask, made.inside > 0
    assert (mask & truth).sum() / (mask | truth).sum() > 0.96
    assert not (~mask & truth & (made.inside > 0.006)).any()
    # A hem across the crease of the seat may take in a few vertices of the crease.
    assert (mask & (made.inside < -0.02)).sum() < 0.002 * mask.sum()


@pytest.mark.parametrize(("name", "borders"), [("tshirt", 4), ("skirt", 2), ("trousers", 3)])
def test_covered_faces_are_one_piece_that_ends_on_the_borders(
    results: dict[str, tuple[Made, str, Registration]], layer: GarmentLayer, name: str, borders: int
) -> None:
    made, topology, result = results[name]
    faces = layer.faces(topology)
    covered = faces[result.cover.mask[faces].all(axis=1)]
    used = np.unique(covered)
    assert len(np.unique(component_labels(edge_list(covered), layer.vertex_count)[used])) == 1
    loops = border_loops(covered)
    assert len(loops) == borders
    edges, counts = edges_with_counts(made.faces)
    rim = edges[counts == 1]
    ends, heads = made.vertices[rim[:, 0]], made.vertices[rim[:, 1]]
    for loop in loops:
        for point in result.registered[loop]:
            t = np.clip(((point - ends) * (heads - ends)).sum(1) / ((heads - ends) ** 2).sum(1), 0, 1)[:, None]
            assert np.linalg.norm(ends + t * (heads - ends) - point, axis=1).min() < 1e-6


def test_an_upper_garment_below_the_crotch_hangs_as_one_tube(long_shirt: Made, layer: GarmentLayer) -> None:
    result = register(long_shirt, layer, "top")
    assert (result.cover.mask & layer.inner_leg).sum() > 300
    assert result.quality.longest_edge_m < 0.05
    assert result.quality.coverage > 0.995
    forked = register(long_shirt, layer, "trousers")
    assert forked.quality.longest_edge_m > 0.05 or forked.quality.coverage < 0.99


def test_nothing_is_said_outside_the_mask(results: dict[str, tuple[Made, str, Registration]]) -> None:
    for made, _, result in results.values():
        found = result.cover
        assert (found.face[~found.mask] == -1).all() and (found.face[found.mask] >= 0).all()
        assert found.face.max() < len(made.faces)
        assert not result.registered[~found.mask].any()
        np.testing.assert_allclose(found.barycentric[found.mask].sum(axis=1), 1.0, atol=1e-6)
        assert found.barycentric.min() >= 0


def test_rigid_motion_commutes(tshirt: Made, layer: GarmentLayer) -> None:
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    move = np.array([0.7, -2.0, 0.4])
    gate = Gate(reach=CONFIG.reach, turn=CONFIG.turn)

    def run(source: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        target = Target(vertices, tshirt.faces)
        fitted = fit(source, layer.skirt_faces, target, gate, CONFIG.coarse, CONFIG.fine)
        return fitted, cover(fitted, layer.skirt_faces, target, CONFIG.tolerance).mask

    source = source_surface(layer, np.zeros(10), "skirt")
    fitted, mask = run(source, tshirt.vertices)
    moved, moved_mask = run(source @ turn.T + move, tshirt.vertices @ turn.T + move)
    # A match that lies on a gate's limit may fall either way by rounding, and moves its neighbours by a little.
    away = np.linalg.norm(moved - (fitted @ turn.T + move), axis=1)[mask]
    assert np.percentile(away, 99) < 1e-5
    assert away.max() < 2e-3
    assert (mask != moved_mask).sum() <= 3
    assert np.abs(fitted - source).max() > 0.01


def test_numbering_of_the_garment_does_not_matter(
    results: dict[str, tuple[Made, str, Registration]], layer: GarmentLayer
) -> None:
    made, _, before = results["tshirt"]
    rng = np.random.default_rng(2)
    order, face_order = rng.permutation(len(made.vertices)), rng.permutation(len(made.faces))
    place = np.argsort(order)
    again = replace(made, vertices=made.vertices[order], faces=place[made.faces][face_order])
    after = register(again, layer, "tshirt")
    assert (before.cover.mask != after.cover.mask).sum() <= 3
    both = before.cover.mask & after.cover.mask
    away = np.linalg.norm(before.registered - after.registered, axis=1)[both]
    assert np.percentile(away, 99.5) < 1e-5


def test_same_input_gives_the_same_bits(
    results: dict[str, tuple[Made, str, Registration]], layer: GarmentLayer
) -> None:
    made, _, before = results["skirt"]
    after = register(made, layer, "skirt")
    assert np.array_equal(before.registered, after.registered)
    assert np.array_equal(before.cover.face, after.cover.face)
    assert before.quality == after.quality


def test_mask_tells_the_cut_whatever_the_body_is(tshirt: Made, layer: GarmentLayer) -> None:
    """A garment moved along with its body covers the same vertices."""
    betas = np.array([1.5, -1.0, 0, 0, 0, 0, 0, 0, 0, 0])
    bigger = source_surface(layer, betas, "skirt")
    growth = bigger - source_surface(layer, np.zeros(10), "skirt")
    _, nearest = cKDTree(tshirt.true).query(tshirt.vertices, k=8)
    vertices = tshirt.vertices + growth[nearest].mean(axis=1)
    rng = np.random.default_rng(0)
    fitted = register_garment(vertices, tshirt.faces, layer, betas, "tshirt", CONFIG, rng)
    truth = tshirt.inside > 0
    mask = fitted.cover.mask
    assert (mask & truth).sum() / (mask | truth).sum() > 0.95
    own = register_garment(vertices, tshirt.faces, layer, np.zeros(10), "tshirt", CONFIG, np.random.default_rng(0))
    assert fitted.quality.error_mean_m < own.quality.error_mean_m + 1e-4
