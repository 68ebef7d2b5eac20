"""Changes the width of sleeves, legs and skirts along their axes (CLOTH3D, Eq. 1)."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stages.outfit.coordinates import smooth_step
from stages.outfit.template import Template

Array = NDArray[np.float64]

SLEEVE_NEAR, SLEEVE_FAR = 0.10, 0.16
"""Distance from the arm's axis [m] within which a vertex belongs to the sleeve, and beyond which to the torso."""


def width(x: Array, alpha_1: float, alpha_2: float, offset: float) -> Array:
    """Width at position x of an axis as a share of the width at 0: W(x) / W_0 (CLOTH3D, Eq. 1).

    Args:
        x: Position along the axis, 0 at shoulder, crotch or waist, 1 at wrist, ankle or shin, shape [n].
        alpha_1: Growth per axis length: at most 0 for sleeves and legs, positive for skirts.
        alpha_2: Further growth per axis length beyond `offset`: at least 0, and 0 for skirts.
        offset: x_offset, where the widening starts.

    Returns:
        The share, shape [n].
    """
    return 1.0 + alpha_1 * x + alpha_2 * np.maximum(0.0, x - offset)


def shape(template: Template, parameters: Mapping[str, float]) -> Array:
    """The template's vertices with the widths asked for.

    Args:
        template: The garment; tops and vests have no part with a width of its own.
        parameters: The piece's parameters, see `stages.outfit.plan.PARAMETERS`.

    Returns:
        Vertices [m], shape [N, 3].
    """
    points = template.vertices
    if template.garment == "tshirt" and "sleeve_narrowing" in parameters:
        x = np.clip(template.axes.along_arm(points), 0.0, 1.0)
        share = width(x, parameters["sleeve_narrowing"], parameters["sleeve_widening"], parameters["sleeve_offset"])
        centre = template.axes.arm_centre(points)
        distance = np.linalg.norm(points - centre, axis=1)
        share = 1.0 + (share - 1.0) * (1.0 - smooth_step(distance, SLEEVE_NEAR, SLEEVE_FAR))
        return centre + share[:, None] * (points - centre)
    if template.garment == "trousers":
        crotch = template.crotch_along_leg
        x = np.clip((template.axes.along_leg(points) - crotch) / (1.0 - crotch), 0.0, 1.0)
        share = width(x, parameters["leg_narrowing"], parameters["leg_widening"], parameters["leg_offset"])
        centre = template.axes.leg_centre(points)
        return centre + share[:, None] * (points - centre)
    if template.garment == "skirt":
        x = np.clip((template.top - points[:, 2]) / (template.top - template.bottom), 0.0, 1.0)
        share = width(x, parameters["skirt_widening"], 0.0, 1.0) / width(x, template.flare, 0.0, 1.0)
        return np.stack([share * points[:, 0], share * points[:, 1], points[:, 2]], axis=1)
    return points.copy()
