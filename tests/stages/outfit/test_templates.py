"""The templates that come with the project: clean meshes, symmetric, off the skin, and what the builder makes."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from model.body import load_free_body
from model.mesh.intersection import self_intersecting_faces
from model.mesh.topology import border_loops, is_edge_manifold
from stages.outfit.borders import loop_length
from stages.outfit.obstacle import Obstacle
from stages.outfit.template import ASSET_FOLDER, EDGE_LENGTHS, GARMENT_TYPES, load_template, rest_body
from tests.stages.outfit.measures import angles, area, components, edge_lengths
from tools.template_asset.designs import DESIGNS, default_grid
from tools.template_asset.wearer import Wearer

GENDERS = ("female", "male")
LOOPS = {"tshirt": 4, "top": 4, "trousers": 3, "skirt": 2}


@pytest.mark.parametrize("gender", GENDERS)
@pytest.mark.parametrize("garment", GARMENT_TYPES)
@pytest.mark.parametrize("edge", EDGE_LENGTHS)
def test_every_template_is_a_clean_mesh(garment: str, gender: str, edge: float) -> None:
    template = load_template(garment, gender, edge)
    v, f = template.vertices, template.faces
    assert is_edge_manifold(f)
    assert components(v, f) == 1
    assert len(border_loops(f)) == LOOPS[garment]
    assert angles(v, f).min() > 15
    assert np.mean(angles(v, f) > 30) > 0.995
    lengths = edge_lengths(v, f)
    assert lengths.mean() == pytest.approx(edge, rel=0.03)
    assert np.mean((lengths > 0.5 * edge) & (lengths < 2 * edge)) > 0.999


REMESHED = [("tshirt", 0.025), ("trousers", 0.0173), ("skirt", 0.012), ("top", 0.007), ("top", 0.005)]


@pytest.mark.parametrize(("garment", "edge"), REMESHED)
def test_any_edge_length_gives_a_clean_mesh_on_the_same_surface(garment: str, edge: float) -> None:
    template, source = (load_template(garment, "male", e) for e in (edge, 0.010 if edge < 0.012 else 0.014))
    v, f = template.vertices, template.faces
    assert is_edge_manifold(f)
    assert components(v, f) == 1
    assert angles(v, f).min() > 15
    assert np.mean(angles(v, f) > 30) > 0.99
    lengths = edge_lengths(v, f)
    assert lengths.mean() == pytest.approx(edge, rel=0.05)
    assert np.mean((lengths > 0.5 * edge) & (lengths < 2 * edge)) > 0.999
    assert area(v, f) == pytest.approx(area(source.vertices, source.faces), rel=0.005)
    # The borders lie on the left half of the source's or are mirror images of it, and are as long.
    curves = [source.vertices[loop] for loop in border_loops(source.faces)]
    loops = border_loops(f)
    assert len(loops) == LOOPS[garment] == len(curves)
    fine = np.concatenate([c + t * (np.roll(c, -1, axis=0) - c) for c in curves for t in np.linspace(0, 1, 20)])
    for loop in loops:
        assert cKDTree(fine).query(np.abs(v[loop]) * [1, 0, 0] + v[loop] * [0, 1, 1])[0].max() < 6e-4
    total = sum(loop_length(source.vertices, loop) for loop in border_loops(source.faces))
    assert sum(loop_length(v, loop) for loop in loops) == pytest.approx(total, rel=0.02)


@pytest.mark.parametrize(("garment", "edge"), REMESHED)
def test_the_triangles_of_a_remeshed_template_are_mirrored(garment: str, edge: float) -> None:
    template = load_template(garment, "male", edge)
    away, opposite = cKDTree(template.vertices).query(template.vertices * [-1, 1, 1])
    assert away.max() < 1e-12
    assert (opposite[opposite] == np.arange(len(opposite))).all()
    turned = np.sort(opposite[template.faces], axis=1)
    assert {tuple(face) for face in turned.tolist()} == {tuple(f) for f in np.sort(template.faces, axis=1).tolist()}


def test_remeshing_gives_the_same_bits_again() -> None:
    again = load_template.__wrapped__("top", "male", 0.02)
    assert np.array_equal(again.vertices, load_template("top", "male", 0.02).vertices)
    assert np.array_equal(again.faces, load_template("top", "male", 0.02).faces)


@pytest.mark.parametrize("edge", [0.0049, 0.026])
def test_an_edge_length_out_of_range_is_refused(edge: float) -> None:
    with pytest.raises(ValueError, match=r"edge length must be 0.005 to 0.025 m, got 0.0"):
        load_template("top", "female", edge)


@pytest.mark.parametrize("gender", GENDERS)
@pytest.mark.parametrize("garment", GARMENT_TYPES)
def test_every_template_stands_off_the_mean_body_and_looks_outwards(garment: str, gender: str) -> None:
    model, template = load_free_body(gender), load_template(garment, gender, 0.014)
    body = Obstacle(rest_body(model, np.zeros(model.beta_count)), model.faces, 0.0)
    v, f = template.vertices, template.faces
    distance, outwards = body.distance(v)
    assert distance.min() > 0.0045
    normals = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    near = (distance[f] < 0.02).all(axis=1)
    agree = (normals * outwards[f].mean(axis=1)).sum(axis=1)[near] > 0
    assert near.sum() > 30
    assert agree.mean() > 0.98


@pytest.mark.parametrize("garment", GARMENT_TYPES)
def test_left_is_the_mirror_image_of_right(garment: str) -> None:
    template = load_template(garment, "female", 0.014)
    centres = template.vertices[template.faces].mean(axis=1)
    tree = cKDTree(np.concatenate([template.vertices, centres]))
    away, nearest = tree.query(template.vertices * [-1, 1, 1])
    # The meshes of the two sides differ; their surfaces do not: most of the way to the nearest point is along them.
    normals = np.cross(
        *[template.vertices[template.faces[:, k]] - template.vertices[template.faces[:, 0]] for k in (1, 2)]
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    on_face = nearest >= len(template.vertices)
    step = (template.vertices * [-1, 1, 1])[on_face] - centres[nearest[on_face] - len(template.vertices)]
    off = np.abs((step * normals[nearest[on_face] - len(template.vertices)]).sum(axis=1))
    assert np.percentile(off, 99) < 1e-3
    assert away.max() < 0.014


@pytest.mark.parametrize("garment", GARMENT_TYPES)
def test_no_template_passes_through_itself(garment: str) -> None:
    template = load_template(garment, "male", 0.014)
    assert len(self_intersecting_faces(template.vertices, template.faces)) == 0


def test_garments_have_ease() -> None:
    """A shirt is a garment, not a second skin: half of it is centimetres away from the body."""
    for gender in GENDERS:
        model = load_free_body(gender)
        body = Obstacle(rest_body(model, np.zeros(model.beta_count)), model.faces, 0.0)
        least = {"tshirt": 0.025, "top": 0.015, "trousers": 0.025, "skirt": 0.04}
        for garment, ease in least.items():
            assert np.median(body.distance(load_template(garment, gender, 0.014).vertices)[0]) > ease


def test_the_assets_are_small() -> None:
    assert sum(path.stat().st_size for path in ASSET_FOLDER.glob("*.npz")) < 2.5e6


def test_the_builder_makes_the_skirt_that_is_there() -> None:
    wearer = Wearer.of(load_free_body("female"))
    design = DESIGNS["skirt"](wearer, default_grid)
    template = load_template("skirt", "female", 0.014)
    projected = design.volume.project(template.vertices)
    assert np.linalg.norm(projected - template.vertices, axis=1).max() < 1e-3
    assert (template.top, template.bottom, template.flare) == pytest.approx((design.top, design.bottom, design.flare))


def test_an_unknown_template_is_refused() -> None:
    with pytest.raises(ValueError, match=r"no template female_toga_10mm.npz: garment must be one of tshirt, top"):
        load_template("toga", "female", 0.010)
