"""Outfits for bodies from files: another topology, another build, and betas of another order and other signs."""

from functools import lru_cache
from itertools import pairwise

import igl
import numpy as np
import pytest

from model.body import BodyModel
from model.body.smpl_file import parse_smpl
from model.mesh.intersection import intersecting_faces, self_intersecting_faces
from model.mesh.topology import is_edge_manifold
from stages.fabrics import load_fabrics
from stages.outfit.config import Config
from stages.outfit.making import TOLERANCE, Garment, make_outfit
from stages.outfit.plan import OutfitPlan, draw_plan
from stages.outfit.resizing import tight_betas
from stages.outfit.template import rest_body
from tests.model.body.smpl_files import as_python2, stranger_model
from tests.stages.outfit.measures import angles, area, components, edge_lengths

EDGE = 0.014
CONFIG = Config(edge_length=EDGE)


@lru_cache(maxsize=2)
def stranger(gender: str) -> BodyModel:
    return parse_smpl(as_python2(stranger_model(gender)), "stranger.pkl", gender, 10)


def made(gender: str, kind: str, betas: np.ndarray, tightness: tuple[float, float]) -> list[Garment]:
    plan = draw_plan(kind, CONFIG, np.random.default_rng(5))
    plan = OutfitPlan(plan.kind, tightness, plan.garments)
    return make_outfit(plan, stranger(gender), betas, CONFIG, load_fabrics(), lambda label: None)


@pytest.mark.parametrize(
    ("gender", "kind", "betas"),
    [
        ("female", "tshirt+trousers", (2.5, -2.5)),
        ("male", "tshirt+skirt", (2.5, -2.5)),
        ("male", "top+trousers", (0, 0)),
    ],
)
def test_a_stranger_is_dressed_as_well_as_the_free_body(gender: str, kind: str, betas: tuple[float, float]) -> None:
    model, shape = stranger(gender), np.array([*betas, *[1.0, -1.0] * 4])
    garments = made(gender, kind, shape, (0.5, -1.0))
    body, faces = rest_body(model, tight_betas(shape, (0.5, -1.0), model)), model.faces.astype(np.int64)
    for garment in garments:
        v, f = garment.vertices, garment.faces
        distance = np.sqrt(igl.point_mesh_squared_distance(v, body, faces)[0])
        assert distance.min() > CONFIG.clearance - TOLERANCE
        assert np.median(distance) < 0.06, "it hangs on the body"
        assert igl.winding_number(body, faces, v[::7].copy()).max() < 0.5
        assert len(intersecting_faces(v, f, body, model.faces)) == 0
        assert is_edge_manifold(f) and components(v, f) == 1 and len(self_intersecting_faces(v, f)) == 0
        assert np.mean(angles(v, f) > 15) > 0.999
        lengths = edge_lengths(v, f)
        assert np.mean((lengths > 0.5 * EDGE) & (lengths < 2 * EDGE)) > 0.99
    inner, outer = garments
    assert len(intersecting_faces(inner.vertices, inner.faces, outer.vertices, outer.faces)) == 0


@pytest.mark.parametrize("gender", ["female", "male"])
def test_positive_tightness_makes_a_smaller_garment_whatever_the_signs(gender: str) -> None:
    """Of this model, size is the second beta and fatness the first, and signs differ between its genders."""
    size = [
        sum(area(g.vertices, g.faces) for g in made(gender, "top+skirt", np.zeros(10), tightness))
        for tightness in ((-1.5, -1.5), (-1.5, 0.0), (0.0, 0.0), (0.0, 0.5), (0.5, 0.5))
    ]
    assert all(tighter < 0.99 * looser for looser, tighter in pairwise(size)), size
    sign = {"female": (1.0, -1.0), "male": (-1.0, 1.0)}[gender]
    tight = tight_betas(np.zeros(10), (0.25, 0.75), stranger(gender))
    np.testing.assert_array_equal(tight, [-0.75 * sign[0], -0.25 * sign[1], *[0.0] * 8])
