"""The cuts that only upper garments have: necklines, armholes, a strapless upper border, and a front that is open.

Each is a field over the mean body's space: the distance to a smooth curve on the cloth, positive on what is kept. What
the wearer's height and build decide is read off the template; parameters are shares of what it has room for.
"""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from model.mesh.topology import border_loops
from stages.outfit.coordinates import smooth_step
from stages.outfit.plan import Piece
from stages.outfit.template import Template

Array = NDArray[np.float64]
Field = Callable[[Array], Array]

MARGIN = 0.008
"""Least width of what a cut takes off along a border of the template [m]: less would leave parts of that border."""

STRAP = 0.035
"""Least width of the cloth over the shoulder between neckline and armhole [m]."""

WIDTHS = {"round": 0.045, "v": 0.03, "boat": 0.06}
"""How much further than the template's neck a neckline may reach on either side [m]."""

DEPTHS = {"round": (0.0, 0.10), "v": (0.05, 0.13), "boat": (0.0, 0.025)}
"""How far below the template's neck a neckline ends in front [m]."""

BACK = 0.3
"""Depth at the back as a share of that in front, beyond the template's; a V is cut in front only."""

ROUNDNESS = {"round": 2.0, "v": 1.2, "boat": 2.5}
"""Exponent of the superellipse that a neckline is, seen from the front: 2 is an ellipse, 1 has straight sides."""

TIP = 0.006
"""Radius that rounds the tip of a V [m]: half an edge."""

BLEND = 0.012
"""Over what distance a neckline passes into the smallest one that takes off the template's border [m]."""

RIDGE = 0.02
"""Half the depth over which front passes into back on the shoulder [m]."""

ARMHOLE_ROUNDNESS = 3.0
"""Exponent of the superellipse that armholes are, seen from the front."""

ARMHOLE_DEPTH, ARMHOLE_SLOPE = 0.035, 0.030
"""How much lower and how much further in the largest armhole is than the smallest [m]."""

CHEST_DEPTH, CHEST_RISE = 0.025, 0.03
"""How much lower the lowest strapless border is than the highest, and how much further up it is in front [m]."""

SPREAD = 1.0
"""How much further an open front parts down to the longest hem than up to the neck."""

PLACKET_WIDTH, SLIT = 0.016, 0.8
"""How far a placket, or an open front where it is fastened, stands open [m], and half of it at least in edge lengths: a
narrower slit has no triangles."""


def upper_fields(template: Template, piece: Piece) -> list[Field]:
    """Fields of the cuts of an upper garment [m], positive on what is kept.

    Args:
        template: A t-shirt or a top; others have no such cuts.
        piece: What is made of it.

    Returns:
        One function of points [n, 3] each, the opening first, so that neckline and hem cross its borders.
    """
    parameters = piece.parameters
    open_front = opening(template, piece)
    fields = [open_front] if open_front else []
    for name in piece.cuts:
        if name in ("front_opening", "placket"):
            continue
        if name == "armholes":
            fields.append(_armholes(template, parameters["armhole_depth"]))
        elif name == "strapless":
            fields.append(_strapless(template, parameters["chest_height"]))
        elif name == "collar":
            fields.append(_neckline(template, "round", {"neck_depth": 0.0, "neck_width": 0.0}, None))
        else:
            kind = name.removesuffix("_neck")
            fields.append(_neckline(template, kind, parameters, parameters.get("armhole_depth")))
    return fields


def _neckline(template: Template, kind: str, parameters: Mapping[str, float], armhole: float | None) -> Field:
    """A superellipse seen from the front, shallower at the back, joined to the smallest that clears the template's."""
    border = _neck(template)
    front, back = _neck_heights(template, border)
    least = float(border[:, 0].max()) + MARGIN
    reach = _shoulder_end(template, armhole) - STRAP - least
    width = least + parameters["neck_width"] * float(np.clip(reach, 0.0, WIDTHS[kind]))
    low, high = DEPTHS[kind]
    depth = low + parameters["neck_depth"] * (high - low)
    behind = back - (0.0 if kind == "v" else BACK * depth)
    base = _superellipse(template, least, front, back, 2.0)
    wanted = _superellipse(template, width, front - depth, behind, ROUNDNESS[kind])

    def field(at: Array) -> Array:
        one, other = base(at), wanted(at)
        # Smooth minimum: https://iquilezles.org/articles/smin, quadratic polynomial.
        near = np.maximum(BLEND - np.abs(one - other), 0.0) / BLEND
        least_of_both: Array = np.minimum(one, other) - 0.25 * BLEND * near**2
        return least_of_both

    return field


def _neck(template: Template) -> Array:
    """Points of the template's own neckline [m], shape [n, 3]."""
    points = template.vertices
    return points[max(border_loops(template.faces), key=lambda loop: float(points[loop, 2].mean()))]


def _neck_heights(template: Template, border: Array) -> tuple[float, float]:
    """Where the smallest neckline is lowest in front and at the back [m]."""
    middle = border[np.abs(border[:, 0]) < 2 * template.edge]
    before = middle[:, 1] < border[:, 1].mean()
    return float(middle[before, 2].min()) - MARGIN, float(middle[~before, 2].min()) - MARGIN


def _superellipse(template: Template, width: float, front: float, back: float, power: float) -> Field:
    """Distance to a neckline of half a width [m] that ends at heights `front` and `back` [m]."""
    ridge_y, ridge_z = _ridge(template, width)

    def field(at: Array) -> Array:
        behind = smooth_step(at[:, 1], ridge_y - RIDGE, ridge_y + RIDGE)
        depth = ridge_z - front + behind * (front - back)
        u = (np.sqrt(at[:, 0] ** 2 + TIP**2) - TIP) / (np.sqrt(width**2 + TIP**2) - TIP)
        v = np.maximum(ridge_z - at[:, 2], 0.0) / depth
        return _distance(u, v, width, depth, power)

    return field


def _distance(u: Array, v: Array, width: Array | float, depth: Array | float, power: float) -> Array:
    """About the distance [m] to the superellipse u^p + v^p = 1: the function over the length of its slope."""
    radius = np.maximum((u**power + v**power) ** (1.0 / power), 1e-3)
    slope = np.hypot((u / radius) ** (power - 1) / width, (v / radius) ** (power - 1) / depth)
    away: Array = (radius - 1.0) / np.maximum(slope, 1e-3)
    return away


def _ridge(template: Template, x: float) -> tuple[float, float]:
    """Depth y and height z of the top of the shoulder at a distance x from the mid-plane [m]."""
    points = template.vertices
    strip = points[np.abs(np.abs(points[:, 0]) - x) < template.edge]
    top = strip[np.argsort(strip[:, 2])[-4:]].mean(axis=0)
    return float(top[1]), float(top[2])


def _shoulder_end(template: Template, armhole: float | None) -> float:
    """Where the cloth over the shoulder ends, or the sleeve begins: distance from the mid-plane [m]."""
    if armhole is not None:
        return template.axes.shoulder[0] - ARMHOLE_SLOPE * armhole
    if template.garment == "top":
        return float(np.abs(_left_armhole(template)[:, 0]).min())
    return float(template.axes.shoulder[0] + STRAP)


def _left_armhole(template: Template) -> Array:
    """Points of a top's left armhole [m], shape [n, 3]."""
    loops = [template.vertices[loop] for loop in border_loops(template.faces)]
    return max(loops, key=lambda loop: float(loop[:, 0].mean()))


def _armholes(template: Template, share: float) -> Field:
    """Superellipses around the shoulders, seen from the front, that take the whole sleeves off."""
    points, shoulder = template.vertices, template.axes.shoulder
    x, z = np.abs(points[:, 0]), points[:, 2]
    near = z > shoulder[2] - 0.2
    underside = float(z[near & (np.abs(x - shoulder[0] - 0.07) < template.edge)].min())
    low = underside - 0.015 - share * ARMHOLE_DEPTH
    side = float(x[np.abs(z - low + 0.02) < template.edge].max())
    middle = shoulder[2] - 0.02
    height = middle - low
    # At the top of the shoulder the curve is this far in.
    top = (_ridge(template, shoulder[0])[1] - middle) / height
    inwards = side - (shoulder[0] - share * ARMHOLE_SLOPE)
    width = inwards / (1.0 - top**ARMHOLE_ROUNDNESS) ** (1.0 / ARMHOLE_ROUNDNESS)

    def field(at: Array) -> Array:
        u = np.maximum(side - np.abs(at[:, 0]), 0.0) / width
        v = np.abs(at[:, 2] - middle) / height
        return _distance(u, v, width, height, ARMHOLE_ROUNDNESS)

    return field


def _strapless(template: Template, share: float) -> Field:
    """A level line below the armholes that rises a little in front."""
    shoulder = template.axes.shoulder
    low = float(_left_armhole(template)[:, 2].min()) - MARGIN - (1.0 - share) * CHEST_DEPTH

    def field(at: Array) -> Array:
        front = 1.0 - smooth_step(at[:, 1], -0.08, 0.0)
        aside = smooth_step(np.abs(at[:, 0]), 0.0, shoulder[0])
        line: Array = low + CHEST_RISE * front * (1.0 - aside) - at[:, 2]
        return line

    return field


def opening(template: Template, piece: Piece) -> Field | None:
    """Distance to the sides of an open front [m], which part from its fastening on, or of a placket; None without."""
    if "placket" in piece.cuts:
        return _placket(template, piece.parameters["placket_length"])
    if "front_opening" not in piece.cuts:
        return None
    width, fastened = piece.parameters["opening_width"], piece.parameters["fastening_height"]
    top, bottom = template.axes.shoulder[2], template.bottom
    closed = _slit(template)

    def field(at: Array) -> Array:
        t = np.clip((top - at[:, 2]) / (top - bottom), 0.0, None)
        above, below = np.maximum(1.0 - t / fastened, 0.0), np.maximum(t - fastened, 0.0) / (1.0 - fastened)
        half = closed + max(0.5 * width - closed, 0.0) * (above**2 + (1.0 + SPREAD) * below**2)
        # No opening at the back: behind the shoulders everything is kept.
        away: Array = np.abs(at[:, 0]) - half + 10.0 * np.maximum(at[:, 1], 0.0)
        return away

    return field


def _slit(template: Template) -> float:
    """Half the least width of an opening [m]."""
    return max(PLACKET_WIDTH / 2, SLIT * template.edge)


def _placket(template: Template, length: float) -> Field:
    """A slit in front that ends in half a circle [m]."""
    half = _slit(template)
    end = _neck_heights(template, _neck(template))[0] - length + half

    def field(at: Array) -> Array:
        away: Array = np.hypot(at[:, 0], np.maximum(end - at[:, 2], 0.0)) - half + 10.0 * np.maximum(at[:, 1], 0.0)
        return away

    return field
