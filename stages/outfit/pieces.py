"""A template shaped and cut to its parameters, still on the mean body."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from model.mesh.geometry import vertex_normals
from model.mesh.topology import border_vertices
from stages.outfit.cutting import cut
from stages.outfit.plan import Piece
from stages.outfit.shaping import shape
from stages.outfit.surface import Surface
from stages.outfit.template import Template
from stages.outfit.upper_cuts import Field, upper_fields

Array = NDArray[np.float64]

HIP_RISE = 0.04
"""Lowest waist border above the hip joints [m]: trousers that sit lower would not hold."""

STITCH = 0.87
"""Height of the strip of triangles that joins two pieces, in edge lengths: that of an equilateral triangle."""

OFF_CURVE = 0.2
"""How far off the curve a new border's vertices may be, in edge lengths; others of the border are older."""

OFF_PLACKET = 0.45
"""The same for plackets, which turn around within an edge at their end."""

PROBE = 1e-5
"""Step that slopes of fields are measured with [m]."""

FAR = 1.0
"""Field value of what is not cut [m]."""


def waist_height(template: Template, share: float) -> float:
    """Height of a waist border or seam [m]: 0 is just above the hips, 1 the template's waist border."""
    low = template.axes.hip[2] + HIP_RISE
    high = template.waist - 0.02
    return float(low + share * (high - low))


def make_piece(template: Template, piece: Piece) -> Surface:
    """Shapes and cuts a template.

    Args:
        template: The garment to start from.
        piece: What to make of it; with `seam_height` it ends where it is to be sewn.

    Returns:
        The piece on the mean body.
    """
    surface = Surface.whole(shape(template, piece.parameters), template.faces)
    # Before lengths and heights, so that these cross the borders of an open front.
    for number, field in enumerate(upper_fields(template, piece)):
        surface = cut(surface, field(surface.vertices), template.edge)
        off = OFF_PLACKET if number == 0 and "placket" in piece.cuts else OFF_CURVE
        surface = _onto(surface, field, off * template.edge)
    for values in cut_fields(template, piece.parameters):
        surface = cut(surface, surface.rows @ values, template.edge)
    return surface


def _onto(surface: Surface, field: Field, off: float) -> Surface:
    """Moves border vertices less than `off` [m] off the curve onto it, along the cloth: cut edges are straight."""
    points = surface.vertices.copy()
    border = np.flatnonzero(border_vertices(surface.faces, len(points)))
    border = border[np.abs(field(points[border])) < off]
    normals = vertex_normals(points, surface.faces)[border]
    for _ in range(2):
        at = points[border]
        value = field(at)
        slope = np.stack([field(at + step) - value for step in np.eye(3) * PROBE], axis=1) / PROBE
        slope -= (slope * normals).sum(axis=1, keepdims=True) * normals
        points[border] -= (value / np.maximum((slope**2).sum(axis=1), 0.1))[:, None] * slope
    return replace(surface, vertices=points)


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
