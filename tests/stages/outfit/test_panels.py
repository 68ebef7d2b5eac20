"""Panels and what they look like laid flat: true to size, nothing turned over or overlapping, seams with names."""

import itertools
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from model.body import load_free_body
from model.mesh.geometry import face_areas
from model.mesh.topology import border_halfedges, border_loops
from stages.fabrics import load_fabrics
from stages.outfit.config import Config
from stages.outfit.finishing import Garment
from stages.outfit.flattening import flatten, opened_faces, stretches
from stages.outfit.making import make_outfit
from stages.outfit.plan import draw_plan
from tests.stages.outfit.measures import tube

CONFIG = Config(edge_length=0.014)
UPPER = {f"{side}_{seam}" for side in ("left", "right") for seam in ("shoulder", "side")}
SLEEVED = UPPER | {f"{side}_{seam}" for side in ("left", "right") for seam in ("armhole", "underarm")}
LEGS = {f"{side}_{seam}" for side in ("left", "right") for seam in ("inseam", "outseam")} | {"front_rise", "back_rise"}
SKIRT = {"skirt_left_side", "skirt_right_side"}


@lru_cache(maxsize=8)
def made(gender: str, kind: str) -> list[Garment]:
    plan = draw_plan(kind, CONFIG, np.random.default_rng(2))
    betas = np.array([2.0, -2.0, *[0.0] * 8])
    return make_outfit(plan, load_free_body(gender), betas, CONFIG, load_fabrics(), lambda label: None)


CASES = [("female", "tshirt+trousers"), ("male", "top+skirt"), ("male", "jumpsuit"), ("female", "dress")]


@pytest.mark.parametrize(("gender", "kind"), CASES)
def test_panels_lie_flat_and_nearly_true_to_size(gender: str, kind: str) -> None:
    for garment in made(gender, kind):
        pattern = garment.pattern
        assert pattern is not None
        flat, points, faces = pattern.flat, garment.vertices, garment.faces
        stretch = stretches(points, faces, flat)
        assert stretch[:, 1].min() > 0.3
        area = face_areas(points, faces)
        assert np.abs(stretch.prod(axis=1) - 1) @ area / area.sum() < 0.03
        assert (stretch[:, 0] / stretch[:, 1] - 1) @ area / area.sum() < 0.04
        assert _area(flat.points, flat.faces).sum() == pytest.approx(area.sum(), rel=0.01)


@pytest.mark.parametrize(("gender", "kind"), CASES)
def test_no_two_triangles_overlap(gender: str, kind: str) -> None:
    """Nothing turned over, and outlines that do not cross: each outline goes once around as much as its faces cover."""
    for garment in made(gender, kind):
        assert garment.pattern is not None
        flat = garment.pattern.flat
        outlines = [flat.points[loop] for loop in border_loops(flat.faces)]
        for outline in outlines:
            assert _crossings(outline) == 0
        boxes = sorted((o[:, 0].min(), o[:, 0].max()) for o in outlines)
        assert all(after[0] > before[1] for before, after in itertools.pairwise(boxes))
        enclosed = sum(
            0.5 * np.cross(np.c_[o, 0 * o[:, 0]], np.c_[np.roll(o, -1, 0), 0 * o[:, 0]])[:, 2].sum() for o in outlines
        )
        assert enclosed == pytest.approx(_area(flat.points, flat.faces).sum(), rel=1e-6)


@pytest.mark.parametrize(("gender", "kind"), CASES)
def test_panels_and_seams_have_the_names_that_a_tailor_expects(gender: str, kind: str) -> None:
    for garment in made(gender, kind):
        assert garment.pattern is not None
        panels = garment.pattern.panels
        upper = {"tshirt": SLEEVED, "top": UPPER}
        pieces = [piece.template for piece in garment.plan.pieces]
        expected: set[str] = {"waist"} if len(pieces) == 2 else set()
        for piece in pieces:
            expected |= upper.get(
                piece, LEGS if piece == "trousers" else SKIRT if len(pieces) == 2 else {"left_side", "right_side"}
            )
        assert set(panels.seams) == expected
        assert set(panels.of_face.tolist()) == set(range(len(panels.names)))
        # One piece of cloth a panel, and every seam is where the pattern is open.
        assert len(border_loops(garment.pattern.flat.faces)) == len(panels.names)
        for name, edges in panels.seams.items():
            if name.startswith(("left_", "right_")):
                sides = np.sign(garment.vertices[np.unique(edges), 0])
                assert (sides == (1 if name.startswith("left") else -1)).mean() > 0.95
        if len(pieces) == 2:
            assert set(np.unique(panels.seams["waist"])) == set(garment.attrs["seams"]["waist"]["vertices"])


def test_vests_have_no_sleeves_strapless_tops_no_shoulders_and_open_shirts_two_fronts() -> None:
    config = replace(CONFIG, vest_chance=1.0, strapless_chance=1.0, open_front_chance=1.0)
    seams = {"tshirt": UPPER, "top": {"left_side", "right_side"}}
    for kind, parts in (("tshirt+skirt", 3), ("top+skirt", 2)):
        plan = draw_plan(kind, config, np.random.default_rng(2))
        upper = make_outfit(plan, load_free_body("female"), np.zeros(10), config, load_fabrics(), lambda label: None)[1]
        assert upper.pattern is not None
        assert upper.pattern.panels.names == ["front", "back"]
        assert set(upper.pattern.panels.seams) == seams[upper.plan.name]
        assert len(border_loops(upper.pattern.flat.faces)) == parts
        assert stretches(upper.vertices, upper.faces, upper.pattern.flat)[:, 1].min() > 0.3


def test_left_panels_are_as_large_as_right_ones() -> None:
    for garment in made("male", "jumpsuit"):
        assert garment.pattern is not None
        panels, area = garment.pattern.panels, face_areas(garment.vertices, garment.faces)
        size = {name: area[panels.of_face == k].sum() for k, name in enumerate(panels.names)}
        for name in size:
            assert size[name] == pytest.approx(size[name.replace("left", "right")], rel=0.04)


def test_borders_are_marked() -> None:
    for garment in made("male", "jumpsuit"):
        for border in garment.attrs["borders"].values():
            assert (garment.border == border["number"]).sum() == border["vertices"]
            assert garment.border[border["vertex"]] == border["number"]
        assert set(np.flatnonzero(garment.border)) == set(np.unique(border_halfedges(garment.faces)))
        assert set(garment.attrs["borders"]) == {"neck", "left_sleeve", "right_sleeve", "left_leg", "right_leg"}


def test_a_tube_unrolls_exactly() -> None:
    points, faces = tube(0.1, 0.4, 0.02)
    seam = [v for v in range(len(points)) if abs(np.arctan2(points[v, 1], points[v, 0])) < 0.11]
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    low = {round(points[v, 2], 6): v for v in sorted(seam, key=lambda v: -points[v, 1])}
    path = [low[z] for z in sorted(low)]
    cut = np.sort(np.stack([path[:-1], path[1:]], axis=1), axis=1)
    assert {tuple(e) for e in cut.tolist()} <= {tuple(e) for e in edges.tolist()}
    assert opened_faces(faces, cut, len(points))[0].max() + 1 == len(points) + len(path)
    flat = flatten(points, faces, np.zeros(len(faces), dtype=np.int64), cut)
    assert np.abs(stretches(points, faces, flat) - 1).max() < 0.02
    assert np.ptp(flat.points[:, 1]) == pytest.approx(0.4, rel=0.01)
    assert np.ptp(flat.points[:, 0]) == pytest.approx(2 * np.pi * 0.1, rel=0.06)


def _area(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Signed areas of flat triangles."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def _crossings(loop: np.ndarray) -> int:
    """Pairs of edges of a closed polygon that cross."""
    a, b = loop, np.roll(loop, -1, axis=0)

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        return np.sign((q - p)[..., 0] * (r - p)[..., 1] - (q - p)[..., 1] * (r - p)[..., 0])

    p, q, r, s = a[:, None], b[:, None], a[None], b[None]
    return int(((side(p, q, r) * side(p, q, s) < 0) & (side(r, s, p) * side(r, s, q) < 0)).sum())
