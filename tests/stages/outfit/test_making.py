"""Whole outfits: clean meshes that fit their body and do not meet each other, whatever the shape."""

from functools import lru_cache

import igl
import numpy as np
import pytest

from model.body import BodyModel, load_free_body
from model.mesh.intersection import intersecting_faces, self_intersecting_faces
from model.mesh.topology import border_loops, is_edge_manifold
from stages.fabrics import load_fabrics
from stages.outfit.borders import loop_length
from stages.outfit.config import Config
from stages.outfit.making import TOLERANCE, Garment, make_outfit
from stages.outfit.plan import KINDS, OutfitPlan, draw_plan
from stages.outfit.resizing import tight_betas
from stages.outfit.template import rest_body
from stages.spec import DataError
from tests.stages.outfit.measures import angles, area, components, edge_lengths

EDGE = 0.014
CONFIG = Config(edge_length=EDGE)
LOOPS = {"tshirt": 4, "top": 4, "trousers": 3, "skirt": 2, "dress": 4, "jumpsuit": 5}

CORNERS = [
    ("female", "tshirt+trousers", (-3.0, 3.0)),
    ("male", "top+trousers", (3.0, 3.0)),
    ("female", "tshirt+skirt", (3.0, -3.0)),
    ("male", "top+skirt", (-3.0, -3.0)),
    ("female", "jumpsuit", (3.0, 3.0)),
    ("male", "jumpsuit", (-3.0, 3.0)),
    ("male", "dress", (3.0, -3.0)),
    ("female", "dress", (-3.0, -3.0)),
]
"""Shapes at the corners of size and fatness, with all other betas at one of +-3 too."""


@lru_cache(maxsize=32)
def made(
    gender: str, kind: str, corner: tuple[float, float], seed: int = 0
) -> tuple[OutfitPlan, list[Garment], np.ndarray]:
    rng = np.random.default_rng(seed)
    betas = rng.choice([-3.0, 3.0], 10)
    betas[:2] = corner
    plan = draw_plan(kind, CONFIG, rng)
    model = load_free_body(gender)
    garments = make_outfit(plan, model, betas, CONFIG, load_fabrics(), lambda label: None)
    return plan, garments, betas


@pytest.mark.parametrize(("gender", "kind", "corner"), CORNERS)
def test_every_garment_is_a_clean_mesh(gender: str, kind: str, corner: tuple[float, float]) -> None:
    _, garments, _ = made(gender, kind, corner)
    for garment in garments:
        v, f = garment.vertices, garment.faces
        assert is_edge_manifold(f)
        assert components(v, f) == 1
        assert len(border_loops(f)) == LOOPS[garment.plan.name]
        assert angles(v, f).min() > 10
        assert np.mean(angles(v, f) > 15) > 0.999
        lengths = edge_lengths(v, f)
        assert lengths.min() > 0.5 * EDGE
        assert lengths.max() < 2 * EDGE
        assert len(self_intersecting_faces(v, f)) == 0


@pytest.mark.parametrize(("gender", "kind", "corner"), CORNERS)
def test_no_garment_enters_the_body_it_is_made_for(gender: str, kind: str, corner: tuple[float, float]) -> None:
    plan, garments, betas = made(gender, kind, corner)
    model = load_free_body(gender)
    body, faces = rest_body(model, tight_betas(betas, plan.tightness)), model.faces.astype(np.int64)
    for garment in garments:
        # Exact distances, signs from the exact winding number: neither is what the stage itself uses.
        distance = np.sqrt(igl.point_mesh_squared_distance(garment.vertices, body, faces)[0])
        assert distance.min() > CONFIG.clearance - TOLERANCE
        assert igl.winding_number(body, faces, garment.vertices[::7].copy()).max() < 0.5
        assert len(intersecting_faces(garment.vertices, garment.faces, body, model.faces)) == 0


@pytest.mark.parametrize(("gender", "kind", "corner"), [c for c in CORNERS if "+" in c[1]])
def test_layers_do_not_meet(gender: str, kind: str, corner: tuple[float, float]) -> None:
    _, (inner, outer), _ = made(gender, kind, corner)
    assert len(intersecting_faces(inner.vertices, inner.faces, outer.vertices, outer.faces)) == 0
    distance = np.sqrt(igl.point_mesh_squared_distance(outer.vertices, inner.vertices, inner.faces)[0])
    assert distance.min() > CONFIG.layer_gap - TOLERANCE
    assert inner.plan.name in ("trousers", "skirt")


@pytest.mark.parametrize(
    ("gender", "kind"), [("female", "tshirt+trousers"), ("male", "tshirt+trousers"), ("male", "dress")]
)
def test_positive_tightness_makes_a_smaller_garment_for_both_genders(gender: str, kind: str) -> None:
    sizes = [_sizes(gender, kind, tightness) for tightness in ((-1.5, -1.5), (0.0, 0.0), (0.5, 0.5))]
    assert len(sizes[0]) >= 2
    for name in sizes[0]:
        loose, fitting, tight = (size[name] for size in sizes)
        assert loose > 1.02 * fitting > 1.02 * 1.005 * tight, name


@pytest.mark.parametrize("tightness", [(1.0, 0.0), (0.0, 1.0)])
def test_either_component_of_tightness_makes_a_garment_smaller(tightness: tuple[float, float]) -> None:
    assert _sizes("female", "dress", tightness)["area"] < 0.99 * _sizes("female", "dress", (0.0, 0.0))["area"]


@lru_cache(maxsize=16)
def _sizes(gender: str, kind: str, tightness: tuple[float, float]) -> dict[str, float]:
    """Areas of an outfit's garments [m^2] and lengths of their hems and legs [m]."""
    plan = draw_plan(kind, CONFIG, np.random.default_rng(3))
    plan = OutfitPlan(plan.kind, tightness, plan.garments)
    garments = make_outfit(plan, load_free_body(gender), np.zeros(10), CONFIG, load_fabrics(), lambda label: None)
    sizes = {"area": sum(area(g.vertices, g.faces) for g in garments)}
    for garment in garments:
        for name, border in garment.attrs["borders"].items():
            if name in ("hem", "left_leg"):
                sizes[f"{garment.plan.name}/{name}"] = border["length_m"]
    return sizes


@pytest.mark.parametrize(("gender", "kind", "corner"), [c for c in CORNERS if "+" in c[1]])
def test_the_waistband_has_the_girth_of_the_wearer(gender: str, kind: str, corner: tuple[float, float]) -> None:
    plan, (lower, upper), betas = made(gender, kind, corner)
    assert not upper.waistband.any()
    assert upper.attrs["waistband"] is None
    loop = next(loop for loop in border_loops(lower.faces) if int(loop.min()) == min(_border(lower, "waist").tolist()))
    assert lower.waistband[loop].all()
    band = lower.vertices[lower.waistband]
    assert np.ptp(band[:, 2]) < 0.08
    girth = lower.attrs["waistband"]["girth_m"]
    model = load_free_body(gender)
    # The wearer, not the tight body: measure it again as the hull of a slab of the body at the band's share of height.
    assert girth == pytest.approx(_slab_girth(model, betas, plan, loop, lower), rel=0.06)
    assert lower.attrs["waistband"]["rest_ratio"] == pytest.approx(girth / loop_length(lower.vertices, loop))


def _border(garment: Garment, name: str) -> np.ndarray:
    start = garment.attrs["borders"][name]["vertex"]
    return next(loop for loop in border_loops(garment.faces) if start in loop)


def _slab_girth(model: BodyModel, betas: np.ndarray, plan: OutfitPlan, loop: np.ndarray, garment: Garment) -> float:
    """Girth of the wearer where the band sits [m]: the hull of body vertices around the border's height."""
    from scipy.spatial import ConvexHull

    tight = rest_body(model, tight_betas(betas, plan.tightness))
    own = rest_body(model, betas)
    near = np.abs(tight[:, 2] - garment.vertices[loop, 2].mean()) < 0.012
    near &= np.abs(tight[:, 0]) < 1.2 * np.abs(garment.vertices[loop, 0]).max()
    ring = own[near][:, :2]
    hull = ring[ConvexHull(ring).vertices]
    return float(np.linalg.norm(hull - np.roll(hull, -1, axis=0), axis=1).sum())


def test_elastics_run_along_their_ends() -> None:
    config = Config(edge_length=EDGE, elastic_chance=1.0)
    plan = draw_plan("jumpsuit", config, np.random.default_rng(2))
    assert plan.garments[0].pieces[0].template == "tshirt"
    (suit,) = make_outfit(plan, load_free_body("female"), np.zeros(10), config, load_fabrics(), lambda label: None)
    kinds = {e["kind"]: (int(n), e["rest_ratio"]) for n, e in suit.attrs["elastics"].items()}
    assert set(kinds) == {"left_sleeve", "right_sleeve", "left_leg", "right_leg", "waist"}
    for name, (number, ratio) in kinds.items():
        assert 0.7 <= ratio <= 0.9
        marked = suit.vertices[suit.elastic == number]
        assert len(marked) > 20
        if name != "waist":
            loop = _border(suit, name)
            assert (suit.elastic[loop] == number).all()
            away = np.linalg.norm(marked[:, None] - suit.vertices[loop][None], axis=2).min(axis=1)
            assert away.max() < 2 * EDGE
            assert (marked[:, 0].mean() > 0) == name.startswith("left")
    waist = suit.vertices[suit.elastic == kinds["waist"][0]]
    assert np.ptp(waist[:, 2]) < 0.10
    assert np.ptp(np.arctan2(waist[:, 1], waist[:, 0])) > 6.0


@pytest.mark.parametrize(
    ("gender", "kind", "edges"),
    [("male", "tshirt+trousers", (0.010, 0.014)), ("female", "top+skirt", (0.005, 0.010, 0.020))],
)
def test_mass_is_area_times_density_and_hardly_changes_with_the_mesh(
    gender: str, kind: str, edges: tuple[float, ...]
) -> None:
    plan = draw_plan(kind, CONFIG, np.random.default_rng(11))
    masses = []
    for edge in edges:
        config = Config(edge_length=edge)
        garments = make_outfit(plan, load_free_body(gender), np.zeros(10), config, load_fabrics(), lambda label: None)
        for garment in garments:
            fabric = load_fabrics()[garment.plan.fabric]
            assert garment.attrs["mass_kg"] == pytest.approx(area(garment.vertices, garment.faces) * fabric.density)
        masses.append([garment.attrs["mass_kg"] for garment in garments])
    for mass in masses[1:]:
        assert mass == pytest.approx(masses[0], rel=0.01)


@pytest.mark.parametrize(("edge", "kind"), [(0.007, "dress"), (0.025, "jumpsuit"), (0.020, "tshirt+trousers")])
def test_outfits_of_other_edge_lengths_are_clean_and_off_the_body(edge: float, kind: str) -> None:
    config, model = Config(edge_length=edge), load_free_body("male")
    plan = draw_plan(kind, config, np.random.default_rng(5))
    betas = np.array([-3.0, 3.0, *[0.0] * 8])
    body, faces = rest_body(model, tight_betas(betas, plan.tightness)), model.faces.astype(np.int64)
    for garment in make_outfit(plan, model, betas, config, load_fabrics(), lambda label: None):
        v, f = garment.vertices, garment.faces
        assert is_edge_manifold(f)
        assert components(v, f) == 1
        assert len(border_loops(f)) == LOOPS[garment.plan.name]
        assert np.mean(angles(v, f) > 15) > 0.999
        lengths = edge_lengths(v, f)
        assert lengths.min() > 0.5 * edge
        assert lengths.max() < 2 * edge
        assert len(self_intersecting_faces(v, f)) == 0
        assert len(intersecting_faces(v, f, body, faces)) == 0
        assert igl.winding_number(body, faces, v[::7].copy()).max() < 0.5


def test_the_same_plan_gives_the_same_bits() -> None:
    _, first, _ = made("female", "jumpsuit", (3.0, 3.0))
    _, again, _ = made.__wrapped__("female", "jumpsuit", (3.0, 3.0))
    assert np.array_equal(first[0].vertices, again[0].vertices)
    assert np.array_equal(first[0].faces, again[0].faces)
    assert np.array_equal(first[0].elastic, again[0].elastic)


def test_every_kind_can_be_made_for_the_mean_body() -> None:
    for kind in KINDS:
        _, garments, _ = made("female", kind, (0.5, -0.5), 4)
        assert "+".join(sorted(g.plan.name for g in garments)) == "+".join(sorted(kind.split("+")))


def test_a_garment_whose_edges_stay_too_long_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stages.outfit.making.EDGES", (0.5, 1.3))
    with pytest.raises(DataError, match=r"^skirt: \d+ edges are not 0.5 to 1.3 times 14 mm long but 0"):
        make_outfit(
            draw_plan("top+skirt", CONFIG, np.random.default_rng(0)), load_free_body("female"), np.zeros(10), CONFIG,
            load_fabrics(), lambda label: None,
        )  # fmt: skip
