"""Makes the garments of an outfit from its plan: shape, cut, sew, resize, clear, layer, fit the bands."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.body import BodyModel
from model.mesh.geometry import face_areas
from model.mesh.intersection import intersecting_faces
from stages.fabrics import Fabric
from stages.outfit.borders import (
    ELASTIC_RINGS,
    WAISTBAND_WIDTH,
    Border,
    loop_length,
    name_borders,
    tape_girth,
)
from stages.outfit.clearance import Obstacle, clear
from stages.outfit.config import Config
from stages.outfit.layering import solid
from stages.outfit.pieces import make_piece
from stages.outfit.plan import GarmentPlan, OutfitPlan
from stages.outfit.resizing import averaging_matrix, smooth_field, tight_betas, transferred_shape
from stages.outfit.sewing import sew
from stages.outfit.surface import Surface, grown
from stages.outfit.template import load_template, rest_body
from stages.spec import DataError

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

SEAM_SMOOTHINGS = 20
"""Averaging steps of the shape's displacement over a sewn garment: the two pieces' own fields meet at the seam."""

TOLERANCE = 1e-4
"""How much of a margin may be missing after all pushing [m]."""

FIT_TRIES = 6
"""How often a garment is fitted anew while faces of it pass through the body or the garment below."""

STEP = 0.0015
"""Distance that the vertices of such faces keep in addition, each time [m]."""

CLOSE = 0.02
"""Faces with no vertex nearer to the body than this are not tested against it [m]."""


@dataclass(frozen=True, eq=False)
class Garment:
    """One finished garment in the rest frame."""

    plan: GarmentPlan
    """What it was made from."""
    vertices: Array
    """Positions [m], shape [N, 3]."""
    faces: Faces
    """Triangles, shape [F, 3]."""
    elastic: NDArray[np.int8]
    """0, or the number of the elastic that each vertex belongs to, shape [N]."""
    waistband: NDArray[np.bool_]
    """Vertices of the band that holds the garment up, shape [N]."""
    attrs: dict[str, Any]
    """What the shard says about it, as JSON values."""


@dataclass(frozen=True, eq=False)
class _Blank:
    """A garment on the mean body, before it is resized."""

    plan: GarmentPlan
    surface: Surface
    seam: NDArray[np.bool_]
    borders: list[Border]


def make_outfit(
    plan: OutfitPlan,
    model: BodyModel,
    betas: Array,
    config: Config,
    fabrics: dict[str, Fabric],
    progress: Callable[[str], None],
) -> list[Garment]:
    """Makes the garments of an outfit.

    Args:
        plan: What to make.
        model: Body model of the wearer's gender.
        betas: Shape of the wearer, shape [B].
        config: Settings.
        fabrics: Fabrics by name.
        progress: Called with a short label before each step.

    Returns:
        The garments, from the inner one to the outer one, on the body of betas less tightness in the rest pose.

    Raises:
        DataError: A garment cannot be kept clear of the body or of the garment below it.
    """
    tight = tight_betas(betas, plan.tightness)
    body_faces = model.faces.astype(np.int64)
    tight_body, body = rest_body(model, tight), rest_body(model, betas)
    skin = Obstacle(tight_body, body_faces, config.clearance)
    worn: list[Garment] = []
    for garment_plan in plan.garments:
        progress(f"{garment_plan.name}: cut")
        blank = _blank(garment_plan, model.gender, config.edge_length)
        progress(f"{garment_plan.name}: resize")
        points = blank.surface.vertices + _displacement(blank, model, tight, config)
        points = _fit(points, blank, skin, worn[-1:], config)
        worn.append(_finish(blank, points, body, tight_body, body_faces, fabrics[garment_plan.fabric]))
    return worn


def _blank(plan: GarmentPlan, gender: str, edge: float) -> _Blank:
    """Shapes, cuts and sews a garment on the mean body."""
    templates = [load_template(piece.template, gender, edge) for piece in plan.pieces]
    surfaces = [make_piece(template, piece.parameters) for template, piece in zip(templates, plan.pieces)]
    if len(surfaces) == 2:
        surface, seam = sew(surfaces[0], surfaces[1], edge)
    else:
        surface, seam = surfaces[0], np.zeros(len(surfaces[0].vertices), dtype=bool)
    borders = name_borders(plan.name, surface.vertices, surface.faces, templates[0].axes)
    return _Blank(plan, surface, seam, borders)


def _displacement(blank: _Blank, model: BodyModel, tight: Array, config: Config) -> Array:
    """How a garment's vertices move from the mean body to the tight one [m], shape [N, 3]."""
    fields = [
        transferred_shape(model, tight, piece.template, config.edge_length, config.smoothing_width)
        for piece in blank.plan.pieces
    ]
    field = blank.surface.rows @ np.concatenate(fields)
    if len(fields) == 1:
        return field
    near = grown(blank.seam, blank.surface.faces, 5)
    averaging = averaging_matrix(blank.surface.faces, len(field))
    local = sp.diags(near.astype(float)) @ averaging + sp.diags((~near).astype(float))
    return smooth_field(field, local.tocsr(), SEAM_SMOOTHINGS)


def _fit(points: Array, blank: _Blank, skin: Obstacle, below: list[Garment], config: Config) -> Array:
    """Keeps a garment clear of the tight body and of the garment below it: all vertices, and no face passes through.

    Where a face still meets the body or the lower garment between its vertices, these keep more distance.
    """
    name, faces = blank.plan.name, blank.surface.faces
    layers = [solid(garment.vertices, garment.faces, config.layer_gap) for garment in below]
    extra = np.zeros(len(points))
    for _ in range(FIT_TRIES):
        fitted, left = clear(points, faces, [skin, *layers], extra)
        close = faces[(skin.distance(fitted)[0] < CLOSE)[faces].any(axis=1)]
        hit = [close[intersecting_faces(fitted, close, skin.vertices, skin.faces)[:, 0]]]
        hit += [faces[intersecting_faces(fitted, faces, g.vertices, g.faces)[:, 0]] for g in below]
        met = np.unique(np.concatenate(hit))
        if left >= -TOLERANCE and len(met) == 0:
            return fitted
        extra[met] += STEP
        points = fitted
    if left < -TOLERANCE:
        raise DataError(
            f"{name}: a vertex stays {-left * 1e3:.2f} mm inside its margin of the body or of the garment below; "
            "draw another shape, or lower outfit.clearance or outfit.layer_gap"
        )
    raise DataError(
        f"{name}: faces around {len(met)} vertices pass through the body or the garment below after {FIT_TRIES} "
        "tries; draw another shape, or raise outfit.clearance or outfit.layer_gap"
    )


def _finish(blank: _Blank, points: Array, body: Array, tight_body: Array, body_faces: Faces, fabric: Fabric) -> Garment:
    """Marks elastics and waistband, and collects what the shard says about a garment."""
    plan, faces = blank.plan, blank.surface.faces
    elastic = np.zeros(len(points), dtype=np.int8)
    elastics: dict[str, dict[str, Any]] = {}
    for end, ratio in plan.elastics.items():
        lines = {b.name: _marked(b.loop, len(points)) for b in blank.borders if b.name.endswith(f"_{end}")}
        if end == "waist":
            lines = {"waist": blank.seam}
        for name, line in lines.items():
            number = len(elastics) + 1
            elastic[grown(line, faces, ELASTIC_RINGS)] = number
            elastics[str(number)] = {"kind": name, "rest_ratio": ratio}
    waistband = np.zeros(len(points), dtype=bool)
    band: dict[str, float] | None = None
    for border in blank.borders:
        if border.name == "waist":
            height = blank.surface.vertices[:, 2]
            waistband = height > height[border.loop].mean() - WAISTBAND_WIDTH
            worn = _carried(points[border.loop], tight_body, body, body_faces)
            girth = tape_girth(worn) + 2 * np.pi * fabric.thickness
            band = {"girth_m": girth, "rest_ratio": girth / loop_length(points, border.loop)}
    area = float(face_areas(points, faces).sum())
    attrs = {
        "type": plan.name,
        "fabric": fabric.as_attrs(),
        "parameters": {piece.template: dict(piece.parameters) for piece in plan.pieces},
        "elastics": elastics,
        "waistband": band,
        "borders": {
            b.name: {"vertex": int(b.loop[0]), "vertices": len(b.loop), "length_m": loop_length(points, b.loop)}
            for b in blank.borders
        },
        "area_m2": area,
        "mass_kg": area * fabric.density,
    }
    return Garment(plan, points, faces, elastic, waistband, attrs)


def _marked(loop: Faces, count: int) -> NDArray[np.bool_]:
    marked = np.zeros(count, dtype=bool)
    marked[loop] = True
    return marked


def _carried(points: Array, start: Array, end: Array, faces: Faces) -> Array:
    """Nearest points of one body to some points, carried over to another shape of it [m], shape [n, 3]."""
    _, face, foot = igl.point_mesh_squared_distance(np.ascontiguousarray(points), start, faces)
    weights = igl.barycentric_coordinates(foot, *[np.ascontiguousarray(start[faces[face, k]]) for k in range(3)])
    return np.einsum("nk,nkd->nd", weights, end[faces[face]])
