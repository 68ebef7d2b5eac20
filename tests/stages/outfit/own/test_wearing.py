"""Own garments as part of outfits: resized, kept clear of body and layers, described, and taken by the next stages."""

import hashlib
from functools import lru_cache

import igl
import numpy as np
import pytest

from model.body import load_free_body
from model.mesh.intersection import intersecting_faces, self_intersecting_faces
from stages.fabrics import load_fabrics
from stages.outfit.borders import loop_length
from stages.outfit.config import Config
from stages.outfit.finishing import Garment
from stages.outfit.making import TOLERANCE, make_outfit
from stages.outfit.own.load import OwnMesh, load_own
from stages.outfit.plan import OutfitPlan, draw_plan
from stages.outfit.resizing import tight_betas
from stages.outfit.template import rest_body
from tests.stages.outfit.measures import area
from tests.stages.outfit.own.garments import as_obj, kilt, kilt_settings

CONFIG = Config(edge_length=0.014)


@lru_cache(maxsize=4)
def kilt_mesh() -> OwnMesh:
    settings = kilt_settings(fabrics=("denim",), elastics={"hem": 0.8})
    return load_own(as_obj(*kilt()).encode(), settings, "kilt.obj")


@lru_cache(maxsize=8)
def made(kind: str, gender: str, betas: tuple[float, ...], tightness: tuple[float, float]) -> list[Garment]:
    mesh = kilt_mesh()
    plan = draw_plan(kind, CONFIG, np.random.default_rng(1), {"kilt": mesh.settings})
    plan = OutfitPlan(plan.kind, tightness, plan.garments)
    shape = np.resize(np.array(betas), 10)
    own = {"kilt": mesh}
    return make_outfit(plan, load_free_body(gender), shape, CONFIG, load_fabrics(), lambda label: None, own)


def test_on_the_body_that_it_was_made_on_it_stays_as_it_is() -> None:
    (garment,) = made("kilt", "female", (0.0,), (0.0, 0.0))
    np.testing.assert_allclose(garment.vertices, kilt_mesh().vertices, atol=1e-6)
    np.testing.assert_array_equal(garment.faces, kilt()[1])


@pytest.mark.parametrize(("gender", "betas"), [("female", (3.0, 3.0, -3.0)), ("male", (-3.0, -3.0, 3.0))])
def test_it_fits_other_bodies_of_either_gender(gender: str, betas: tuple[float, ...]) -> None:
    (garment,) = made("kilt", gender, betas, (0.4, -0.3))
    model = load_free_body(gender)
    body = rest_body(model, tight_betas(np.resize(np.array(betas), 10), (0.4, -0.3)))
    faces = model.faces.astype(np.int64)
    distance = np.sqrt(igl.point_mesh_squared_distance(garment.vertices, body, faces)[0])
    assert distance.min() > CONFIG.clearance - TOLERANCE
    assert igl.winding_number(body, faces, garment.vertices[::3].copy()).max() < 0.5
    assert len(intersecting_faces(garment.vertices, garment.faces, body, faces)) == 0
    assert len(self_intersecting_faces(garment.vertices, garment.faces)) == 0
    # Size and fatness of the body are the garment's.
    plain = made("kilt", "female", (0.0,), (0.0, 0.0))[0].attrs["area_m2"]
    ratio = garment.attrs["area_m2"] / plain
    assert ratio > 1.15 if betas[0] > 0 else ratio < 0.9, ratio


def test_positive_tightness_makes_it_smaller() -> None:
    loose, tight = (made("kilt", "female", (0.0,), (t, t))[0] for t in (-1.0, 0.5))
    assert area(loose.vertices, loose.faces) > 1.05 * area(tight.vertices, tight.faces)


def test_three_layers_do_not_meet_in_the_order_of_the_name() -> None:
    """`kilt+tshirt+trousers`: trousers inside, the kilt over both."""
    garments = made("kilt+tshirt+trousers", "female", (0.5,), (-0.5, -0.5))
    assert [garment.plan.name for garment in garments] == ["trousers", "tshirt", "kilt"]
    inside, middle, outer = garments
    for one, other in ((inside, middle), (inside, outer), (middle, outer)):
        assert len(intersecting_faces(one.vertices, one.faces, other.vertices, other.faces)) == 0
        distance = np.sqrt(igl.point_mesh_squared_distance(other.vertices, one.vertices, one.faces)[0])
        assert distance.min() > CONFIG.layer_gap - TOLERANCE


def test_all_is_told_of_it_that_is_told_of_others() -> None:
    own, other = made("kilt+top+trousers", "female", (0.0,), (-0.5, 0.0))[::-2]
    assert set(own.attrs) - set(other.attrs) == {"own"}
    assert own.attrs["type"] == "skirt" and own.attrs["fabric"]["name"] == "denim"
    assert own.attrs["parameters"] == {} and own.attrs["tightness"] == [-0.5, 0.0]
    assert own.attrs["mass_kg"] == pytest.approx(0.4 * area(own.vertices, own.faces))
    told = own.attrs["own"]
    assert (told["file"], told["unit"], told["up"], told["origin"]) == ("kilt.obj", "m", "z", "root")
    assert (told["gender"], told["betas"], told["unused_vertices"]) == ("female", [], 0)
    assert told["sha256"] == hashlib.sha256(as_obj(*kilt()).encode()).hexdigest()
    ((number, elastic),) = own.attrs["elastics"].items()
    hem = kilt_mesh().borders[1].loop
    assert elastic["kind"] == "hem" and elastic["rest_ratio"] == 0.8
    assert elastic["length_m"] == pytest.approx(loop_length(own.vertices, hem))
    assert (own.elastic[hem] == int(number)).all() and (own.elastic > 0).sum() == 2 * len(hem)
    waist = kilt_mesh().borders[0].loop
    assert own.waistband[waist].all() and own.waistband.sum() < 3 * len(waist)
    assert own.attrs["waistband"]["rest_ratio"] < 1


def test_without_a_waistband_nothing_holds_it() -> None:
    mesh = load_own(as_obj(*kilt()).encode(), kilt_settings(waistband=False), "kilt.obj")
    plan = draw_plan("kilt", CONFIG, np.random.default_rng(1), {"kilt": mesh.settings})
    own = {"kilt": mesh}
    model = load_free_body("female")
    (garment,) = make_outfit(plan, model, np.zeros(10), CONFIG, load_fabrics(), lambda label: None, own)
    assert not garment.waistband.any() and garment.attrs["waistband"] is None


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("kilts", r"got 'kilts'; did you mean 'kilt'\?"),
        ("toga", r"or garments joined by \+ with one at least of your own \(kilt\), got 'toga'"),
        ("tshirt+top", r"got 'tshirt\+top'"),
        ("kilt+kilt", r"must name each garment once, and at most 4 own ones, got 'kilt\+kilt'"),
        ("kilt+", r"got 'kilt\+'"),
    ],
)
def test_outfits_of_unknown_garments_are_refused(kind: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        draw_plan(kind, CONFIG, np.random.default_rng(0), {"kilt": kilt_settings()})


def test_its_fabric_is_drawn_from_its_own_list_or_that_of_its_type() -> None:
    def drawn(**changes: object) -> set[str]:
        own = {"kilt": kilt_settings(**changes)}
        config = Config(fabrics={"skirt": ("silk", "denim")})
        return {draw_plan("kilt", config, np.random.default_rng(s), own).garments[0].fabric for s in range(60)}

    assert drawn(fabrics=("leather", "cotton")) == {"leather", "cotton"}
    assert drawn() == {"silk", "denim"}


def test_an_own_garment_beside_templates_leaves_their_choices_as_they_were() -> None:
    own = {"kilt": kilt_settings()}
    for seed in range(5):
        with_it = draw_plan("kilt+tshirt+trousers", CONFIG, np.random.default_rng(seed), own)
        without = draw_plan("tshirt+trousers", CONFIG, np.random.default_rng(seed))
        assert with_it.garments[:2] == without.garments and with_it.tightness == without.tightness
