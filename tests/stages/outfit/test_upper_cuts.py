"""Necklines, vests, strapless tops and open fronts: on their curve, clean, in one piece, and named."""

from functools import lru_cache

import numpy as np
import pytest

from model.body import load_free_body
from model.mesh.intersection import self_intersecting_faces
from model.mesh.topology import border_loops, border_vertices, euler_characteristic, is_edge_manifold
from stages.fabrics import load_fabrics
from stages.outfit.borders import Border, name_borders
from stages.outfit.config import Config
from stages.outfit.making import Garment, make_outfit
from stages.outfit.pieces import make_piece
from stages.outfit.plan import CUTS, PARAMETERS, OutfitPlan, Piece, draw_plan
from stages.outfit.surface import Surface
from stages.outfit.template import load_template
from stages.outfit.upper_cuts import opening, upper_fields
from tests.stages.outfit.measures import angles, components, edge_lengths

EDGE = 0.014

SHIRTS = [
    ("tshirt", ("round_neck",), {"neck", "left_sleeve", "right_sleeve", "hem"}),
    ("tshirt", ("v_neck",), {"neck", "left_sleeve", "right_sleeve", "hem"}),
    ("tshirt", ("boat_neck", "armholes"), {"neck", "left_armhole", "right_armhole", "hem"}),
    ("tshirt", ("v_neck", "front_opening"), {"left_sleeve", "right_sleeve"}),
    ("tshirt", ("round_neck", "armholes", "front_opening"), {"left_armhole", "right_armhole"}),
    ("tshirt", ("collar",), {"neck", "left_sleeve", "right_sleeve", "hem"}),
    ("tshirt", ("collar", "placket"), {"left_sleeve", "right_sleeve", "hem"}),
    ("top", ("v_neck",), {"neck", "left_armhole", "right_armhole", "hem"}),
    ("top", ("strapless",), {"chest", "hem"}),
]
"""Template, cuts, and the borders that are loops of their own."""


def piece(template: str, cuts: tuple[str, ...], share: float, length: float = 0.6) -> Piece:
    values = {"sleeve_length": 0.3, "torso_length": length, "sleeve_offset": 0.5, "opening_width": 0.04 + 0.08 * share}
    values |= {"placket_length": 0.08 + 0.08 * share, "fastening_height": 0.1 + 0.2 * share}
    sleeves = 0 if "armholes" in cuts else 1
    names = [name for name in PARAMETERS[template] if sleeves or not name.startswith("sleeve")]
    of_cuts = {name: values.get(name, share) for cut in cuts for name in CUTS[cut]}
    return Piece(template, {**{name: values.get(name, 0.0) for name in names}, **of_cuts}, cuts)


@lru_cache(maxsize=32)
def cut_piece(gender: str, template: str, cuts: tuple[str, ...], share: float) -> Surface:
    return make_piece(load_template(template, gender, EDGE), piece(template, cuts, share))


def named(gender: str, template: str, cuts: tuple[str, ...], share: float) -> dict[str, Border]:
    made, pattern = cut_piece(gender, template, cuts, share), load_template(template, gender, EDGE)
    side = opening(pattern, piece(template, cuts, share))
    return {b.name: b for b in name_borders(template, made.vertices, made.faces, pattern.axes, side)}


@pytest.mark.parametrize("gender", ["female", "male"])
@pytest.mark.parametrize(("template", "cuts", "loops"), SHIRTS)
@pytest.mark.parametrize("share", [0.0, 1.0])
def test_every_cut_leaves_one_clean_piece(
    gender: str, template: str, cuts: tuple[str, ...], loops: set[str], share: float
) -> None:
    made = cut_piece(gender, template, cuts, share)
    v, f = made.vertices, made.faces
    assert is_edge_manifold(f) and components(v, f) == 1
    holes = len(loops) + bool({"front_opening", "placket"} & set(cuts))
    assert len(border_loops(f)) == holes and euler_characteristic(f) == 2 - holes
    assert angles(v, f).min() > 18
    assert edge_lengths(v, f).min() > 0.35 * EDGE and edge_lengths(v, f).max() < 2 * EDGE
    assert len(self_intersecting_faces(v, f)) == 0
    closed = {name for name, border in named(gender, template, cuts, share).items() if border.closed}
    assert closed == loops


@pytest.mark.parametrize("gender", ["female", "male"])
@pytest.mark.parametrize(("template", "cuts", "loops"), SHIRTS)
def test_borders_lie_on_their_curves(gender: str, template: str, cuts: tuple[str, ...], loops: set[str]) -> None:
    """Each border of a cut lies on the zero line of its field, which is a distance, and nothing of the template's."""
    borders = named(gender, template, cuts, 0.7)
    v = cut_piece(gender, template, cuts, 0.7).vertices
    fields = upper_fields(load_template(template, gender, EDGE), piece(template, cuts, 0.7))
    curves = {"front_opening": "front_opening", "armholes": "armhole", "strapless": "chest", "placket": "placket"}
    # The opening's field comes first.
    order = sorted(cuts, key=lambda cut: cut not in ("front_opening", "placket"))
    for cut, field in zip(order, fields, strict=True):
        found = [b for name, b in borders.items() if name.endswith(curves.get(cut, "neck"))]
        assert len(found) == (2 if cut in ("front_opening", "armholes") else 1)
        for border in found:
            at = v[border.loop]
            slope = np.stack([field(at + step) - field(at) for step in 1e-6 * np.eye(3)], axis=1) / 1e-6
            off = np.abs(field(at)) / np.linalg.norm(slope, axis=1)
            # A corner lies on the edge, a chord of the opening's curve, where the later cut has crossed it.
            assert off[1:-1].max() < 5e-4 and off.max() < (5e-4 if border.closed else 2e-3), cut
            middles = (at[1:] + at[:-1]) / 2
            # An edge of 14 mm cuts off the tip of a V.
            assert np.abs(field(middles)).max() < 4e-3, cut
            assert np.median(np.abs(field(middles))) < 5e-4, cut


def test_an_open_front_joins_neck_and_hem_and_its_sides_face_each_other() -> None:
    cuts = ("round_neck", "front_opening")
    borders = named("female", "tshirt", cuts, 0.5)
    v = cut_piece("female", "tshirt", cuts, 0.5).vertices
    left, right = borders["left_front_opening"], borders["right_front_opening"]
    # An edge of 14 mm cuts off what is narrower than 0.8 of it on either side.
    assert v[left.loop, 0].min() > 0.01 and v[right.loop, 0].max() < -0.01
    assert v[left.loop, 1].max() < 0 and v[right.loop, 1].max() < 0
    assert left.length(v) == pytest.approx(right.length(v), rel=0.02)
    ends = [set(borders[name].loop[[0, -1]].tolist()) for name in ("neck", "hem")]
    assert {*left.loop[[0, -1]].tolist(), *right.loop[[0, -1]].tolist()} == ends[0] | ends[1]
    around = np.zeros(len(v), dtype=bool)
    for border in borders.values():
        around[border.loop] = True
    assert np.array_equal(around, border_vertices(cut_piece("female", "tshirt", cuts, 0.5).faces, len(v)))
    pattern = load_template("tshirt", "female", EDGE)
    top, bottom = pattern.axes.shoulder[2], pattern.bottom

    def gap(share: float) -> float:
        """Distance of the sides at a height: 0 for the shoulders, 1 for the longest hem [m]."""
        z = top + share * (bottom - top)
        at = [np.interp(z, *v[b.loop][np.argsort(v[b.loop, 2])][:, [2, 0]].T) for b in (left, right)]
        return float(at[0] - at[1])

    assert gap(0.2) == pytest.approx(1.6 * EDGE, abs=1e-3), "side by side where it is fastened"
    assert gap(0.2) + 0.005 < gap(0.1) < gap(0.5) < gap(0.6), "and apart above and below, most towards the hem"


def test_a_placket_is_a_slit_from_the_neck_down() -> None:
    for share, length in ((0.0, 0.08), (1.0, 0.16)):
        borders = named("male", "tshirt", ("collar", "placket"), share)
        v = cut_piece("male", "tshirt", ("collar", "placket"), share).vertices
        slit, neck = borders["placket"].loop, borders["neck"].loop
        assert {*slit[[0, -1]].tolist()} == {*neck[[0, -1]].tolist()} and v[slit, 1].max() < 0
        assert np.ptp(v[slit, 2]) == pytest.approx(length, abs=0.008)
        assert np.ptp(v[slit, 0]) == pytest.approx(1.6 * EDGE, abs=2e-3)


def test_what_a_tailor_measures_follows_the_parameters() -> None:
    def front(cuts: tuple[str, ...], share: float, template: str = "tshirt") -> float:
        """Height of the neckline in front [m]."""
        v = cut_piece("male", template, cuts, share).vertices
        loop = v[named("male", template, cuts, share)["neck"].loop]
        return float(loop[(np.abs(loop[:, 0]) < 0.02) & (loop[:, 1] < 0), 2].min())

    assert front(("round_neck",), 0.0) - front(("round_neck",), 1.0) == pytest.approx(0.10, abs=0.008)
    assert front(("v_neck",), 1.0) < front(("round_neck",), 1.0) - 0.02 < front(("boat_neck", "armholes"), 1.0) - 0.06
    wide = [np.ptp(_neck("female", "boat_neck", share)[:, 0]) for share in (0.0, 1.0)]
    assert wide[1] > wide[0] + 0.09
    lower = [cut_piece("male", "top", ("strapless",), share).vertices[:, 2].max() for share in (0.0, 1.0)]
    assert lower[1] - lower[0] == pytest.approx(0.025, abs=2e-3)
    vest = [cut_piece("female", "tshirt", ("boat_neck", "armholes"), share) for share in (0.0, 1.0)]
    shoulders = [np.abs(made.vertices[made.vertices[:, 2] > 0.45, 0]).max() for made in vest]
    assert shoulders[0] == pytest.approx(0.16, abs=0.01) and shoulders[1] < shoulders[0] - 0.02


def _neck(gender: str, kind: str, share: float) -> np.ndarray:
    cuts = (kind,)
    return cut_piece(gender, "tshirt", cuts, share).vertices[named(gender, "tshirt", cuts, share)["neck"].loop]


def worn(kind: str, seed: int = 3, **settings: object) -> tuple[OutfitPlan, list[Garment]]:
    config = Config(edge_length=EDGE, **settings)  # type: ignore[arg-type]
    plan = draw_plan(kind, config, np.random.default_rng(seed))
    betas = np.array([3.0, 3.0, -3.0, 3.0, 3.0, -3.0, 3.0, 3.0, -3.0, 3.0])
    return plan, make_outfit(plan, load_free_body("female"), betas, config, load_fabrics(), lambda label: None)


def test_a_strapless_top_is_held_by_a_band_of_the_wearers_girth() -> None:
    _, (_, top) = worn("top+skirt", strapless_chance=1.0)
    assert top.attrs["cuts"] == {"top": ["strapless"]}
    assert set(top.attrs["borders"]) == {"chest", "hem"}
    band = top.attrs["waistband"]
    assert 0.6 < band["rest_ratio"] < 1.05 and band["girth_m"] > 0.8
    high = top.vertices[top.waistband]
    assert high[:, 2].min() > top.vertices[:, 2].max() - 0.12 and len(high) > 100
    assert len(self_intersecting_faces(top.vertices, top.faces)) == 0


def test_dresses_and_jumpsuits_take_the_cuts_but_are_never_open() -> None:
    for kind in ("dress", "jumpsuit"):
        plan, (garment,) = worn(kind, seed=7, strapless_chance=1.0, vest_chance=1.0, open_front_chance=1.0)
        upper = plan.garments[0].pieces[0]
        assert "front_opening" not in upper.cuts
        assert garment.attrs["cuts"][upper.template] == list(upper.cuts)
        assert "sleeve" not in plan.garments[0].elastics
        assert components(garment.vertices, garment.faces) == 1 and is_edge_manifold(garment.faces)


def test_an_open_shirt_is_worn_over_trousers() -> None:
    _, (_, shirt) = worn("tshirt+trousers", open_front_chance=1.0, vest_chance=0.0)
    assert {"left_front_opening", "right_front_opening", "neck", "hem"} < set(shirt.attrs["borders"])
    assert len(border_loops(shirt.faces)) == 3
    cords, length = shirt.attrs["fastenings"]["front"]["cords"], shirt.attrs["fastenings"]["front"]["length_m"]
    sides = shirt.border[np.array(cords)]
    assert (sides == [shirt.attrs["borders"][f"{side}_front_opening"]["number"] for side in ("left", "right")]).all()
    ends = shirt.vertices[np.array(cords)]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) == pytest.approx(length)
    assert max(length) < 0.04 and 0.02 < np.ptp(ends[..., 2]) < 0.06
    assert len(self_intersecting_faces(shirt.vertices, shirt.faces)) == 0


def test_cuts_are_refused_where_a_recipe_is_wrong() -> None:
    with pytest.raises(ValueError, match="necklines must name at least one neckline, got none"):
        Config(necklines=())
    with pytest.raises(ValueError, match=r"opening_width must run from low to high, got \[0.1, 0.05\]"):
        Config(opening_width=(0.1, 0.05))
