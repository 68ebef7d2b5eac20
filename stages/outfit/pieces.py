"""A template shaped and cut to its parameters, still on the mean body."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stages.outfit.cutting import cut
from stages.outfit.shaping import shape
from stages.outfit.surface import Surface
from stages.outfit.template import Template

Array = NDArray[np.float64]

HIP_RISE = 0.04
"""Lowest waist border above the hip joints [m]: trousers that sit lower would not hold."""

STITCH = 0.87
"""Height of the strip of triangles that joins two pieces, in edge lengths: that of an equilateral triangle."""

FAR = 1.0
"""Field value of what is not cut [m]."""


def waist_height(template: Template, share: float) -> float:
    """Height of a waist border or seam [m]: 0 is just above the hips, 1 the template's waist border."""
    low = template.axes.hip[2] + HIP_RISE
    high = template.waist - 0.02
    return float(low + share * (high - low))


def make_piece(template: Template, parameters: Mapping[str, float]) -> Surface:
    """Shapes and cuts a template.

    Args:
        template: The garment to start from.
        parameters: See `stages.outfit.plan.PARAMETERS`; with `seam_height` the piece ends where it is to be sewn.

    Returns:
        The piece on the mean body.
    """
    surface = Surface.whole(shape(template, parameters), template.faces)
    for field in cut_fields(template, parameters):
        surface = cut(surface, surface.rows @ field, template.edge)
    return surface


def cut_fields(template: Template, parameters: Mapping[str, float]) -> list[Array]:
    """Signed distances to the cuts on the template's vertices [m], positive on what is kept, each shape [N]."""
    points, axes = template.vertices, template.axes
    height = points[:, 2]
    fields: list[Array] = []
    if "sleeve_length" in parameters:
        field = (parameters["sleeve_length"] - axes.along_arm(points)) * axes.arm_length
        # The hips may be as far out as a short sleeve ends.
        fields.append(np.where(height > axes.shoulder[2] - 0.2, field, FAR))
    if "torso_length" in parameters:
        share = parameters["torso_length"]
        fields.append(height - ((1 - share) * template.waist + share * template.bottom))
    if "leg_length" in parameters:
        fields.append((parameters["leg_length"] - axes.along_leg(points)) * axes.leg_length)
    if "skirt_length" in parameters:
        fields.append(height - (template.top + parameters["skirt_length"] * (template.bottom - template.top)))
    if "waist_height" in parameters:
        fields.append(waist_height(template, parameters["waist_height"]) - height)
    if "seam_height" in parameters:
        seam = waist_height(template, parameters["seam_height"])
        above = template.garment in ("tshirt", "top")
        half = STITCH * template.edge / 2
        fields.append(height - (seam + half) if above else (seam - half) - height)
    return fields
