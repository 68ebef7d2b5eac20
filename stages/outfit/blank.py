"""A garment on the body that it was made on, before it is resized: shaped, cut and sewn, or one's own."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.body import BodyModel
from stages.outfit.borders import Border, name_borders
from stages.outfit.collar import add_collar
from stages.outfit.config import Config
from stages.outfit.own.load import OwnMesh
from stages.outfit.panels import Panels, cut_out
from stages.outfit.pieces import make_piece
from stages.outfit.plan import GarmentPlan
from stages.outfit.resizing import averaging_matrix, smooth_field, transferred_shape
from stages.outfit.sewing import sew
from stages.outfit.surface import Surface, grown
from stages.outfit.template import load_template
from stages.outfit.upper_cuts import opening

Array = NDArray[np.float64]

SEAM_SMOOTHINGS = 20
"""Averaging steps of the shape's displacement over a sewn garment: the two pieces' own fields meet at the seam."""


@dataclass(frozen=True, eq=False)
class Blank:
    """A garment on the body that it was made on."""

    plan: GarmentPlan
    """What it is made from."""
    surface: Surface
    """Its mesh in the rest frame."""
    seam: NDArray[np.bool_]
    """Vertices on the waist seam, shape [N]."""
    borders: list[Border]
    """Its borders by name."""
    panels: Panels | None = None
    """Its panels; none if it is one's own."""
    own: OwnMesh | None = None
    """The file that it comes from, if it is one's own."""

    def displacement(self, model: BodyModel, tight: Array, config: Config) -> Array:
        """How its vertices move to the body that the outfit is made for.

        Args:
            model: Body model of the wearer's gender.
            tight: Shape of that body, shape [B].
            config: Settings.

        Returns:
            Displacements in the rest frame [m], shape [N, 3].
        """
        if self.own is not None:
            return self.own.displacement(model, tight, config.smoothing_width)
        fields = [
            transferred_shape(model, tight, piece.template, config.edge_length, config.smoothing_width)
            for piece in self.plan.pieces
        ]
        field = self.surface.rows @ np.concatenate(fields)
        if len(fields) == 1:
            return field
        near = grown(self.seam, self.surface.faces, 5)
        averaging = averaging_matrix(self.surface.faces, len(field))
        local = sp.diags(near.astype(float)) @ averaging + sp.diags((~near).astype(float))
        return smooth_field(field, local.tocsr(), SEAM_SMOOTHINGS)


def make_blank(plan: GarmentPlan, gender: str, edge: float, own: Mapping[str, OwnMesh]) -> Blank:
    """Shapes, cuts and sews a garment on the mean body of a gender, or takes one's own as it is.

    Args:
        plan: The garment.
        gender: Gender of the templates.
        edge: Edge length of the templates [m].
        own: Garments of one's own by name.

    Returns:
        The blank.
    """
    if plan.name in own:
        mesh = own[plan.name]
        surface = Surface.whole(mesh.vertices, mesh.faces)
        return Blank(plan, surface, np.zeros(len(mesh.vertices), dtype=bool), mesh.borders, own=mesh)
    templates = [load_template(piece.template, gender, edge) for piece in plan.pieces]
    surfaces = [make_piece(template, piece) for template, piece in zip(templates, plan.pieces)]
    if len(surfaces) == 2:
        surface, seam = sew(surfaces[0], surfaces[1], edge)
    else:
        surface, seam = surfaces[0], np.zeros(len(surfaces[0].vertices), dtype=bool)
    upper, side = plan.pieces[0], opening(templates[0], plan.pieces[0])

    def borders() -> list[Border]:
        return name_borders(plan.type, surface.vertices, surface.faces, templates[0].axes, side)

    panels = cut_out(templates, surface, seam, sleeveless="armholes" in upper.cuts)
    if "collar" in upper.cuts:
        neck = next(border for border in borders() if border.name == "neck")
        surface, panels = add_collar(surface, panels, neck, upper.parameters["collar_height"], edge)
        seam = np.concatenate([seam, np.zeros(len(surface.vertices) - len(seam), dtype=bool)])
    return Blank(plan, surface, seam, borders(), panels)
