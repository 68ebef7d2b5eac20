"""Makes the garments of an outfit from its plan: shape, cut, sew, resize, clear, layer, finish."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from model.body import BodyModel
from model.body.free_twin import free_twin
from model.mesh.geometry import edge_lengths
from model.mesh.intersection import intersecting_faces, self_crossings
from model.mesh.topology import edge_list
from stages.fabrics import Fabric
from stages.outfit.blank import Blank, make_blank
from stages.outfit.clearance import clear
from stages.outfit.config import Config
from stages.outfit.finishing import Garment, Wearing, finish
from stages.outfit.layering import solid
from stages.outfit.obstacle import Gauge, Obstacle
from stages.outfit.own.load import OwnMesh
from stages.outfit.plan import OutfitPlan
from stages.outfit.resizing import tight_betas
from stages.outfit.spacing import space
from stages.outfit.template import rest_body
from stages.spec import DataError

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

TOLERANCE = 1e-4
"""How much of a margin may be missing after all pushing [m]."""

FIT_TRIES = 6
"""How often a garment is fitted anew while faces of it pass through the body or the garment below."""

STEP = 0.0015
"""Distance that the vertices of such faces keep in addition, each time [m]."""

EDGES = 0.5, 2.0
"""Lengths of edges that a garment may have, as shares of `outfit.edge_length` [1]; one's own may have any."""

NO_OWN: Mapping[str, OwnMesh] = {}


def make_outfit(
    plan: OutfitPlan,
    model: BodyModel,
    betas: Array,
    config: Config,
    fabrics: dict[str, Fabric],
    progress: Callable[[str], None],
    own: Mapping[str, OwnMesh] = NO_OWN,
) -> list[Garment]:
    """Makes the garments of an outfit.

    Args:
        plan: What to make.
        model: Body model of the wearer's gender.
        betas: Shape of the wearer, shape [B].
        config: Settings.
        fabrics: Fabrics by name.
        progress: Called with a short label before each step.
        own: Garments of one's own by name.

    Returns:
        The garments, from the inner one to the outer one, on the body of betas less tightness in the rest pose.

    Raises:
        DataError: A garment cannot be kept clear of the body or of a garment below it, meets itself, or has edges much
            too short or long.
    """
    tight, twin = tight_betas(betas, plan.tightness, model), free_twin(model)
    body_faces = model.faces.astype(np.int64)
    tight_body, body = rest_body(model, tight), rest_body(model, betas)
    skin = Obstacle(tight_body, body_faces, config.clearance)
    wearing = Wearing(body, tight_body, body_faces, plan.tightness)
    worn: list[Garment] = []
    for garment_plan in plan.garments:
        progress(f"{garment_plan.name}: cut")
        blank = make_blank(garment_plan, model.gender, config.edge_length, own)
        progress(f"{garment_plan.name}: resize")
        points = blank.surface.vertices + blank.displacement(twin, tight, config)
        points = _fit(points, blank, skin, worn, config)
        worn.append(finish(blank, points, wearing, fabrics[garment_plan.fabric]))
    return worn


def _fit(points: Array, blank: Blank, skin: Obstacle, below: list[Garment], config: Config) -> Array:
    """Keeps a garment clear of the tight body and of the garments below: all vertices, and no face passes through.

    Its edges keep to the lengths that they should have, but for one's own. Where a face still meets the body or a
    lower garment between its vertices, these keep more distance.
    """
    name, faces = blank.plan.name, blank.surface.faces
    layers = [solid(garment.vertices, garment.faces, config.layer_gap) for garment in below]
    gauges = [Gauge(obstacle, points) for obstacle in (skin, *layers)]
    extra = np.zeros(len(points))
    for number in range(FIT_TRIES):
        fitted, left = clear(points, faces, gauges, extra)
        # The last try is for being clear alone.
        if blank.own is None and left >= -TOLERANCE and number < FIT_TRIES - 1:
            fitted, spaced = space(fitted, faces, config.edge_length, blank.seam, gauges, extra)
            left = min(left, spaced)
        hit = [_met(fitted, faces, gauges[0], skin)]
        hit += [_met(fitted, faces, gauge, garment) for gauge, garment in zip(gauges[1:], below)]
        met = np.unique(np.concatenate(hit))
        if left >= -TOLERANCE and len(met) == 0:
            _refuse_crossings(fitted, faces, name)
            if blank.own is None:
                _refuse_edges(fitted, faces, name, config.edge_length)
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


def _met(points: Array, faces: Faces, gauge: Gauge, other: Obstacle | Garment) -> Faces:
    """Vertices of the faces that pass through the body or a garment below, whose distances the gauge holds."""
    suspects = faces[gauge.may_meet(points, faces)]
    return suspects[intersecting_faces(points, suspects, other.vertices, other.faces)[:, 0]].reshape(-1)


def _refuse_edges(points: Array, faces: Faces, name: str, wanted: float) -> None:
    """Where cloth is pushed or resized beyond what sliding can mend, its triangles are too uneven to simulate.

    Raises:
        DataError: An edge is out of `EDGES`.
    """
    share = edge_lengths(points, edge_list(faces)) / wanted
    count = int(((share < EDGES[0]) | (share > EDGES[1])).sum())
    if count:
        raise DataError(
            f"{name}: {count} edges are not {EDGES[0]:g} to {EDGES[1]:g} times {1e3 * wanted:g} mm long but "
            f"{share.min():.2f} to {share.max():.2f} times; draw another shape, or another outfit.edge_length"
        )


def _refuse_crossings(points: Array, faces: Faces, name: str) -> None:
    """Resizing may drive folds of a garment into each other, where the body has folds or an own garment layers.

    Raises:
        DataError: It meets itself.
    """
    crossing = self_crossings(points, faces)
    if len(crossing):
        raise DataError(
            f"{name}: passes through itself at {len(crossing)} pairs of triangles on this body; draw another shape, "
            "give an own garment more room between its layers, or raise outfit.smoothing_width"
        )
