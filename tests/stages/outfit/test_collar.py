"""A collar stands on the neckline: sewn to it all around, of the height asked for, and clean on whoever wears it."""

from functools import lru_cache

import numpy as np
import pytest

from model.body import load_free_body
from model.mesh.geometry import edge_lengths
from model.mesh.intersection import intersecting_faces, self_intersecting_faces
from model.mesh.topology import border_loops, is_edge_manifold
from stages.fabrics import load_fabrics
from stages.outfit.blank import Blank, make_blank
from stages.outfit.config import Config
from stages.outfit.flattening import flatten, stretches
from stages.outfit.making import make_outfit
from stages.outfit.plan import GarmentPlan, OutfitPlan, Piece
from stages.outfit.resizing import tight_betas
from stages.outfit.template import rest_body
from tests.stages.outfit.measures import angles, components

EDGE = 0.010
HEIGHT = 0.03
PARAMETERS = {"sleeve_length": 0.3, "torso_length": 0.6, "sleeve_narrowing": 0.0, "sleeve_widening": 0.0,
              "sleeve_offset": 0.5, "opening_width": 0.06, "placket_length": 0.12, "fastening_height": 0.2}  # fmt: skip
CUTS = [(), ("placket",), ("front_opening",)]


def shirt(cuts: tuple[str, ...]) -> GarmentPlan:
    return GarmentPlan(
        "tshirt", "tshirt", (Piece("tshirt", PARAMETERS | {"collar_height": HEIGHT}, cuts),), "cotton", {}
    )


@lru_cache(maxsize=8)
def blank(cuts: tuple[str, ...]) -> Blank:
    return make_blank(shirt(cuts), "female", EDGE, {})


@pytest.mark.parametrize("cuts", CUTS)
def test_a_collar_is_a_band_of_its_height_sewn_to_the_neckline(cuts: tuple[str, ...]) -> None:
    with_one = blank(("collar", *cuts))
    v, f = with_one.surface.vertices, with_one.surface.faces
    assert is_edge_manifold(f) and components(v, f) == 1
    assert len(border_loops(f)) == 4 - ("front_opening" in cuts)
    panels = with_one.panels
    assert panels is not None
    number = panels.names.index("collar")
    band = np.unique(f[panels.of_face == number])
    top = next(border.loop for border in with_one.borders if border.name == "neck")
    base = np.unique(panels.seams["collar"])
    assert set(top.tolist()) | set(base.tolist()) < set(band.tolist()) and not set(top.tolist()) & set(base.tolist())
    assert v[top, 2].mean() - v[base, 2].mean() == pytest.approx(HEIGHT, abs=2e-3)
    assert len(top) == len(base)
    assert edge_lengths(v, panels.seams["collar"]).sum() > edge_lengths(v, np.stack([top[:-1], top[1:]], 1)).sum()
    assert angles(v, f[panels.of_face == number]).min() > 20


def test_a_collar_lies_flat_as_one_strip() -> None:
    """It is opened at the back if nothing else opens it."""
    made = blank(("collar",))
    panels = made.panels
    assert panels is not None and "collar_back" in panels.seams
    v, f = made.surface.vertices, made.surface.faces
    flat = flatten(v, f, panels.of_face, panels.cut_edges())
    mine = panels.of_face == panels.names.index("collar")
    stretch = stretches(v, f, flat)[mine]
    assert np.median(np.abs(stretch - 1)) < 0.05 and stretch[:, 1].min() > 0.7
    size = np.ptp(flat.points[np.unique(flat.faces[mine])], axis=0)
    assert size.max() > 0.35 and size.min() < 0.2
    assert "collar_back" not in blank(("collar", "placket")).panels.seams  # type: ignore[union-attr]


@pytest.mark.parametrize(("gender", "size", "fatness"), [("male", -3.0, -3.0), ("female", 3.0, 3.0)])
def test_collars_fit_whoever_wears_them(gender: str, size: float, fatness: float) -> None:
    betas = np.array([size, fatness, 3.0, -3.0, 3.0, 3.0, -3.0, -3.0, 3.0, 3.0])
    model = load_free_body(gender)
    plan = OutfitPlan("tshirt", (0.0, 0.0), (shirt(("collar", "placket")),))
    (made,) = make_outfit(plan, model, betas, Config(), load_fabrics(), lambda label: None)
    v, f = made.vertices, made.faces
    assert len(self_intersecting_faces(v, f)) == 0
    body = rest_body(model, tight_betas(betas, plan.tightness))
    assert len(intersecting_faces(v, f, body, model.faces)) == 0
    assert angles(v, f).min() > 15
    assert made.attrs["borders"]["placket"]["length_m"] > 0.2 and made.attrs["panels"][-1] == "collar"
    assert made.attrs["panel_seams"]["collar"]["length_m"] > 0.3
