"""What is written down of every garment is what can be measured on its mesh."""

from functools import lru_cache

import numpy as np
import pytest

from model.body import load_free_body
from model.mesh.topology import edge_list
from stages.fabrics import load_fabrics
from stages.outfit.config import Config
from stages.outfit.finishing import Garment, seam_loop
from stages.outfit.making import make_outfit
from stages.outfit.plan import OutfitPlan, draw_plan
from stages.simulate.fabric import Fabric
from tests.stages.outfit.measures import area, tube

CONFIG = Config(edge_length=0.014, elastic_chance=1.0)


@lru_cache(maxsize=2)
def made(kind: str) -> tuple[OutfitPlan, list[Garment]]:
    plan = draw_plan(kind, CONFIG, np.random.default_rng(2))
    return plan, make_outfit(plan, load_free_body("female"), np.zeros(10), CONFIG, load_fabrics(), lambda label: None)


@pytest.mark.parametrize("kind", ["jumpsuit", "tshirt+skirt"])
def test_every_garment_says_what_it_is(kind: str) -> None:
    plan, garments = made(kind)
    for garment in garments:
        told = garment.attrs
        assert told["type"] == garment.plan.name and told["tightness"] == list(plan.tightness)
        assert told["fabric"]["name"] == garment.plan.fabric
        assert told["parameters"] == {piece.template: piece.parameters for piece in garment.plan.pieces}
        assert told["area_m2"] == pytest.approx(area(garment.vertices, garment.faces))
        assert told["mass_kg"] == pytest.approx(told["area_m2"] * told["fabric"]["density"])
        edges = edge_list(garment.faces)
        lengths = np.linalg.norm(garment.vertices[edges[:, 0]] - garment.vertices[edges[:, 1]], axis=1)
        assert told["edge_m"] == pytest.approx(lengths.mean())
        assert set(told["seams"]) == ({"waist"} if len(garment.plan.pieces) == 2 else set())


def test_the_seam_runs_once_around_the_waist() -> None:
    _, (suit,) = made("jumpsuit")
    seam = suit.attrs["seams"]["waist"]
    loop = np.array(seam["vertices"])
    known = {tuple(edge) for edge in edge_list(suit.faces).tolist()}
    steps = np.sort(np.stack([loop, np.roll(loop, -1)], axis=1), axis=1)
    assert all(tuple(step) in known for step in steps.tolist()) and len(set(loop.tolist())) == len(loop)
    points = suit.vertices[loop]
    turn = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert abs(turn[-1] - turn[0]) > 6.0
    length = np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1).sum()
    assert seam["length_m"] == pytest.approx(length) and 0.5 < length < 1.3
    assert suit.attrs["elastics"]["5"]["length_m"] == pytest.approx(length)


def test_elastics_tell_their_lengths() -> None:
    _, (suit,) = made("jumpsuit")
    for number, elastic in suit.attrs["elastics"].items():
        assert elastic["rest_length_m"] == pytest.approx(elastic["rest_ratio"] * elastic["length_m"])
        modulus = Fabric.of(suit.attrs["fabric"], "jumpsuit").sheet_stiffness
        assert elastic["tension_n"] == pytest.approx(modulus * elastic["width_m"] * (1 - elastic["rest_ratio"]))
        assert 0.05 < elastic["tension_n"] < 20
        if elastic["kind"] != "waist":
            assert elastic["length_m"] == suit.attrs["borders"][elastic["kind"]]["length_m"]
        # A ring of triangles on one side of a border, on both sides of a seam.
        rings = 2 if elastic["kind"] == "waist" else 1
        assert elastic["width_m"] == pytest.approx(rings * 0.87 * 0.014, rel=0.25), (number, elastic)


def test_a_seam_that_is_no_closed_line_is_refused() -> None:
    points, faces = tube(0.1, 0.2, 0.02)
    around = int((points[:, 2] == 0).sum())
    ring = np.zeros(len(points), dtype=bool)
    ring[around : 2 * around] = True
    loop = seam_loop(ring, faces)
    assert loop[0] == around and sorted(loop.tolist()) == list(range(around, 2 * around))
    ring[around + 3] = False
    with pytest.raises(ValueError, match="must be one closed line"):
        seam_loop(ring, faces)
    ring[around : 3 * around] = True
    with pytest.raises(ValueError, match="must be one closed line"):
        seam_loop(ring, faces)
