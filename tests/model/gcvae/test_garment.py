"""From a mask to a garment: speckle removed, one piece, borders smooth, no vertex left in the body."""

import igl
import numpy as np
import pytest

from model.body import REST_POSE, load_free_body
from model.body.layer import garment_layer
from model.gcvae.garment import clean_mask, garment_mesh, lift_out, smooth_borders
from model.mesh.geometry import vertex_normals
from model.mesh.topology import border_loops, component_labels, edge_list

Mesh = tuple[np.ndarray, np.ndarray]


def test_speckle_goes_and_the_garment_stays(sphere: Mesh) -> None:
    vertices, faces = sphere
    garment = vertices[:, 2] > 0.0
    noisy = garment.copy()
    noisy[[700, 701, 900]] = True  # an island and a speck in the lower half
    noisy[[300, 301, 333]] = False  # a hole in the upper half
    assert (noisy != garment).sum() == 6
    assert np.array_equal(clean_mask(noisy, faces), garment)


def test_a_hole_of_any_size_is_filled_but_no_opening(sphere: Mesh) -> None:
    vertices, faces = sphere
    garment = vertices[:, 2] < 0.7  # the opening above leads to the sphere's border
    torn = garment & (np.linalg.norm(vertices - [1.0, 0.0, 0.0], axis=1) > 0.6)
    assert (garment & ~torn).sum() > 60
    differs = clean_mask(torn, faces) != garment
    assert not differs[np.abs(vertices[:, 2] - 0.7) > 0.1].any()


def test_the_mesh_is_one_piece_of_the_layer(sphere: Mesh) -> None:
    vertices, faces = sphere
    island = (vertices[:, 2] < -0.2) & (vertices[:, 0] > 0.3)
    assert island.sum() > 100
    mask = (vertices[:, 2] > 0.4) | island
    points, own = garment_mesh(vertices, mask, faces)
    assert component_labels(edge_list(own), len(points)).max() == 0
    assert points[:, 2].min() > 0.3
    assert len(border_loops(own)) == 2  # the pole and the hem
    assert np.array_equal(np.unique(own), np.arange(len(points)))


def test_smoothing_moves_the_border_only_and_flattens_it(sphere: Mesh) -> None:
    vertices, faces = sphere
    ragged = vertices[:, 2] > 0.1 * np.sign(np.sin(40 * np.arctan2(vertices[:, 1], vertices[:, 0])))
    own = faces[ragged[faces].all(axis=1)]
    used = np.unique(own)
    smoothed = smooth_borders(vertices, own, 10)
    loop = border_loops(own)
    border = np.concatenate(loop)
    inner = np.setdiff1d(used, border)
    assert np.array_equal(smoothed[inner], vertices[inner])

    def roughness(points: np.ndarray) -> float:
        ring = points[loop[0]]
        return float(np.linalg.norm(ring - 0.5 * (np.roll(ring, 1, 0) + np.roll(ring, -1, 0)), axis=1).mean())

    assert roughness(smoothed) < 0.3 * roughness(vertices)


def test_a_constant_is_kept_by_smoothing(sphere: Mesh) -> None:
    vertices, faces = sphere
    constant = np.full_like(vertices, 2.5)
    assert np.allclose(smooth_borders(constant, faces, 10), constant)


def test_an_empty_mask_is_refused(sphere: Mesh) -> None:
    vertices, faces = sphere
    with pytest.raises(ValueError, match="covers no face"):
        garment_mesh(vertices, np.zeros(len(vertices), bool), faces)


def test_no_vertex_stays_inside() -> None:
    body = load_free_body("female")
    skin = body.pose(np.zeros(10), REST_POSE[None])[0]
    layer = garment_layer(body)  # no fingers and toes, between which a garment has no room
    worn = layer.model.pose(np.zeros(10), REST_POSE[None])[0]
    cloth = worn + (0.004 + 0.016 * np.sin(9 * worn[:, 2:])) * vertex_normals(worn, layer.body_faces)
    lifted, share = lift_out(cloth, layer.body_faces, skin, body.faces)
    assert 0.2 < share < 0.6
    distance = igl.signed_distance(lifted.astype(float), skin.astype(float), body.faces.astype(np.int64))[0]
    assert distance.min() > 0.0
    far = np.linalg.norm(cloth - lifted, axis=1)
    assert 0.2 < (far < 1e-6).mean() < 0.7
    assert far.max() < 0.03
