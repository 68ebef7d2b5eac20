"""The garment layer: both topologies, its segments, and how it follows the body."""

import igl
import numpy as np
import pytest

from model.body import GENDERS, REST_POSE, load_free_body
from model.body.layer import TOPOLOGY, GarmentLayer, garment_layer
from model.body.smpl_file import parse_smpl
from model.mesh.geometry import edge_lengths, face_normals
from model.mesh.topology import (
    border_loops,
    component_labels,
    edge_list,
    euler_characteristic,
    is_edge_manifold,
)
from tests.model.body.smpl_files import as_python2, stranger_model


@pytest.fixture(scope="module", params=GENDERS)
def layer(request: pytest.FixtureRequest) -> GarmentLayer:
    return garment_layer(load_free_body(request.param))


def test_both_genders_share_the_layer() -> None:
    female, male = (garment_layer(load_free_body(gender)) for gender in GENDERS)
    assert 13_500 <= female.vertex_count <= 16_000
    for name in ("body_faces", "skirt_faces", "segments", "inner_leg"):
        np.testing.assert_array_equal(getattr(female, name), getattr(male, name))
    assert not np.allclose(female.model.v_template, male.model.v_template, atol=0.01)


def test_body_topology_is_a_tube_with_five_openings(layer: GarmentLayer) -> None:
    assert is_edge_manifold(layer.body_faces)
    assert len(border_loops(layer.body_faces)) == 5
    assert euler_characteristic(layer.body_faces) == 2 - 5
    assert len(np.unique(layer.body_faces)) == layer.vertex_count


def test_skirt_topology_joins_the_ankles_into_one_hem(layer: GarmentLayer) -> None:
    assert is_edge_manifold(layer.skirt_faces)
    loops = border_loops(layer.skirt_faces)
    assert len(loops) == 4
    assert euler_characteristic(layer.skirt_faces) == 2 - 4
    assert len(np.unique(layer.skirt_faces)) == layer.vertex_count
    heights = sorted(layer.model.v_template[loop, 1].mean() for loop in loops)
    ankles = [loop for loop in border_loops(layer.body_faces) if layer.model.v_template[loop, 1].max() < -0.5]
    assert heights[0] < -0.5 < heights[1]
    assert len(ankles) == 2
    hem = min(loops, key=lambda loop: layer.model.v_template[loop, 1].mean())
    assert set(hem.tolist()) == set(np.concatenate(ankles).tolist())


def test_skirt_topology_leaves_the_trunk_alone(layer: GarmentLayer) -> None:
    body, skirt = ({tuple(face) for face in faces.tolist()} for faces in (layer.body_faces, layer.skirt_faces))
    changed = np.unique(list(body ^ skirt))
    crotch = layer.model.v_template[~layer.inner_leg & (np.abs(layer.model.v_template[:, 0]) < 1e-6), 1].min()
    assert layer.model.v_template[changed, 1].max() < crotch + 0.01
    assert len(body - skirt) < 0.02 * len(body)


def test_bridges_face_outwards(layer: GarmentLayer) -> None:
    body = {tuple(face) for face in layer.body_faces.tolist()}
    bridges = np.array([face for face in layer.skirt_faces.tolist() if tuple(face) not in body])
    part = component_labels(edge_list(bridges), layer.vertex_count)[bridges[:, 0]]
    one, two = (bridges[part == label] for label in np.unique(part))
    template = layer.model.v_template
    front, back = (one, two) if template[one, 2].mean() > template[two, 2].mean() else (two, one)
    for bridge, outwards in ((front, 1.0), (back, -1.0)):
        below_crotch = np.ptp(template[bridge, 0], axis=1) > 0.04
        assert below_crotch.sum() > 80
        assert (outwards * face_normals(template, bridge)[below_crotch, 2] > 0.8).all()
    assert edge_lengths(template, edge_list(front)).max() > 0.15


def test_edges_are_even(layer: GarmentLayer) -> None:
    length = edge_lengths(layer.model.v_template, edge_list(layer.body_faces))
    low, middle, high = np.percentile(length, [2, 50, 99.9])
    assert low > 0.006
    assert 0.009 < middle < 0.013
    assert high < 0.022


def test_layer_lies_on_the_body_for_any_shape(layer: GarmentLayer) -> None:
    body = load_free_body(layer.model.gender)
    betas = np.array([2.0, -1.5, 1.0, 0.5, -1.0, 0.0, 2.0, 0.0, 0.0, -2.0])
    vertices = body.shape(betas)[0].astype(np.float64)
    points = layer.model.shape(betas)[0].astype(np.float64)
    distance = np.sqrt(igl.point_mesh_squared_distance(points, vertices, body.faces.astype(np.int64))[0])
    assert distance.max() < 1e-5
    posed = layer.model.pose(betas, REST_POSE[None], np.zeros((1, 3)))[0]
    assert np.abs(posed[:, 0].mean()) < 0.01
    assert 1.2 < np.ptp(posed[:, 2]) < 1.7


def test_each_segment_is_one_piece_in_both_topologies(layer: GarmentLayer) -> None:
    labels = layer.segments
    assert set(labels.tolist()) == set(range(21))
    for faces in (layer.body_faces, layer.skirt_faces):
        edges = edge_list(faces)
        inside = edges[labels[edges[:, 0]] == labels[edges[:, 1]]]
        assert len(np.unique(component_labels(inside, layer.vertex_count))) == 21


def test_inner_legs_hold_every_bridge(layer: GarmentLayer) -> None:
    body = {tuple(sorted(face)) for face in layer.body_faces.tolist()}
    bridges = np.unique([face for face in layer.skirt_faces.tolist() if tuple(sorted(face)) not in body])
    crotch = layer.model.v_template[bridges][:, 1].max()
    low = bridges[layer.model.v_template[bridges, 1] < crotch - 0.02]
    assert layer.inner_leg[low].all()
    assert 0.1 < layer.inner_leg.mean() < 0.35
    assert layer.model.v_template[layer.inner_leg, 1].max() < 0.0


def test_every_garment_type_has_a_topology(layer: GarmentLayer) -> None:
    for topology in TOPOLOGY.values():
        assert len(layer.faces(topology)) > 25_000
    assert TOPOLOGY["dress"] == TOPOLOGY["skirt"] == "skirt"
    assert TOPOLOGY["trousers"] == TOPOLOGY["jumpsuit"] == "body"


def test_stored_layer_is_what_the_build_makes() -> None:
    from model.body.layer import FREE_LAYER, load_template
    from tools.build_layer import free_template

    stored, built = load_template(FREE_LAYER), free_template()
    for name in ("body_faces", "skirt_faces", "segments", "inner_leg", "corners"):
        np.testing.assert_array_equal(getattr(stored, name), getattr(built, name))
    np.testing.assert_allclose(stored.barycentric, built.barycentric, atol=1e-5)


@pytest.mark.parametrize("gender", GENDERS)
def test_any_body_of_the_schema_wears_the_same_layer(gender: str) -> None:
    """Files of both genders, whatever their faces, share topologies and segments with the free body and each other."""
    free = garment_layer(load_free_body("female"))
    body = parse_smpl(as_python2(stranger_model(gender)), "stranger.pkl", gender, 10)
    layer = garment_layer(body)
    assert garment_layer(body) is layer
    for topology in ("body", "skirt"):
        np.testing.assert_array_equal(layer.faces(topology), free.faces(topology))
    np.testing.assert_array_equal(layer.segments, free.segments)
    np.testing.assert_array_equal(layer.inner_leg, free.inner_leg)
    betas = np.linspace(-1.5, 1.5, 10)
    points, skin = (model.shape(betas)[0].astype(np.float64) for model in (layer.model, body))
    distance = np.sqrt(igl.point_mesh_squared_distance(points, skin, body.faces.astype(np.int64))[0])
    assert np.percentile(distance, 99.5) < 0.003 and distance.max() < 0.008, "chords of 15 mm across the body's folds"
    own = face_normals(points, layer.body_faces)
    near = igl.point_mesh_squared_distance(points[layer.body_faces].mean(axis=1), skin, body.faces.astype(np.int64))[1]
    assert ((own * face_normals(skin, body.faces)[near]).sum(axis=1) > 0).mean() > 0.998, "it looks outwards"
    edges = edge_lengths(points, edge_list(layer.body_faces))
    assert np.percentile(edges, 99.9) < 2.5 * np.median(edges)
