"""Offsets and their pose-invariant form: exact inverses, invariance, weights of a skirt."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model.body import REST_POSE, load_free_body
from model.body.layer import GarmentLayer, garment_layer
from model.mesh.topology import edge_list
from model.offsets import apply_offsets, extract_offsets, garment_weights, rest_to_pose

BETAS = np.array([1.0, -0.5, 0.3, 0.0, 0.7, 0.0, 0.0, 0.0, -1.0, 0.0])


@pytest.fixture(scope="module")
def layer() -> GarmentLayer:
    return garment_layer(load_free_body("female"))


@pytest.fixture(scope="module")
def pose() -> np.ndarray:
    rng = np.random.default_rng(5)
    pose = REST_POSE[None] + 0.35 * rng.standard_normal((3, 24, 3))
    pose[1, 4] = (2.4, 0.0, 0.0)  # a knee bent by 138 degrees
    return pose


@pytest.fixture(scope="module")
def static(layer: GarmentLayer) -> np.ndarray:
    rest = layer.model.pose(BETAS, REST_POSE[None], np.zeros((1, 3)))[0].astype(np.float64)
    return rest * (1.1, 1.2, 1.0) + (0.0, 0.01, 0.02)


@pytest.mark.parametrize("topology", ["body", "skirt"])
def test_unpose_is_inverted_exactly(layer: GarmentLayer, pose: np.ndarray, static: np.ndarray, topology: str) -> None:
    carrier = rest_to_pose(layer, BETAS, pose, topology)
    noise = 0.05 * np.random.default_rng(1).standard_normal((len(pose), layer.vertex_count, 3))
    dynamic = carrier.carry(static) + noise
    offsets = carrier.unpose(dynamic, static)
    assert np.abs(carrier.repose(offsets, static) - dynamic).max() < 1e-9
    # Isometric: as long as the difference it stands for.
    np.testing.assert_allclose(np.linalg.norm(offsets, axis=2), np.linalg.norm(noise, axis=2), atol=1e-9)
    exact = carrier.unpose_exactly(dynamic, static)
    assert np.abs(carrier.repose_exactly(exact, static) - dynamic).max() < 1e-9
    # At the bent knee K shrinks by up to cos(69 degrees) = 0.36, so its inverse magnifies.
    assert (np.linalg.norm(exact, axis=2) / np.linalg.norm(noise, axis=2)).max() > 2.0


def test_map_takes_the_rest_layer_to_the_posed_layer(layer: GarmentLayer, pose: np.ndarray) -> None:
    rest = layer.model.pose(BETAS, REST_POSE[None], np.zeros((1, 3)))[0]
    posed = layer.model.pose(BETAS, pose, np.zeros((len(pose), 3)))
    carried = rest_to_pose(layer, BETAS, pose, "body").carry(rest)
    assert np.abs(carried - posed).max() < 2e-6
    assert np.abs(posed - rest).max() > 0.3


def test_turning_the_whole_person_leaves_pose_free_offsets_alone(
    layer: GarmentLayer, pose: np.ndarray, static: np.ndarray
) -> None:
    turn = Rotation.from_rotvec([0.4, -1.0, 2.0])
    turned = pose.copy()
    turned[:, 0] = (turn * Rotation.from_rotvec(pose[:, 0])).as_rotvec()
    before, after = rest_to_pose(layer, BETAS, pose, "skirt"), rest_to_pose(layer, BETAS, turned, "skirt")
    dynamic = before.carry(static) + 0.03 * np.sin(40 * static)
    world = dynamic @ turn.as_matrix().T
    expected = before.unpose(dynamic, static)
    assert np.abs(after.unpose(world, static) - expected).max() < 1e-8
    assert np.abs(world - dynamic).max() > 0.3


def test_skirt_weights_are_smooth_across_the_legs(layer: GarmentLayer) -> None:
    body, skirt = garment_weights(layer, "body"), garment_weights(layer, "skirt")
    np.testing.assert_allclose(skirt.sum(axis=1), 1.0)
    np.testing.assert_array_equal(skirt[~layer.inner_leg], body[~layer.inner_leg])
    edges = edge_list(layer.skirt_faces)
    edges = edges[layer.inner_leg[edges].all(axis=1)]
    assert np.abs(body[edges[:, 0]] - body[edges[:, 1]]).max() > 0.9
    assert np.abs(skirt[edges[:, 0]] - skirt[edges[:, 1]]).max() < 0.25


def test_offsets_are_zero_outside_the_mask(layer: GarmentLayer, static: np.ndarray) -> None:
    rest = layer.model.pose(BETAS, REST_POSE[None], np.zeros((1, 3)))[0].astype(np.float64)
    mask = layer.segments < 5
    offsets = extract_offsets(static, rest, mask)
    assert not offsets[~mask].any()
    assert (np.linalg.norm(offsets[mask], axis=1) > 1e-3).all()
    np.testing.assert_allclose(apply_offsets(rest, offsets)[mask], static[mask], atol=1e-12)
