"""The four garments: which body parts each one wraps, with how much ease, and where it is open."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.outfit.coordinates import Axes
from tools.template_asset.volume import Ease, Grid, Volume, hull_field
from tools.template_asset.wearer import Wearer

Array = NDArray[np.float64]

SPACING = 0.005
"""Distance of the grid's nodes [m]."""

ROUNDING = 0.011
"""Standard deviation of the blur that joins hulls [m]: the radius of the fillets at armpits and crotch."""


@dataclass(frozen=True, eq=False)
class Design:
    """One garment on its wearer."""

    volume: Volume
    """Closed solid around the body."""
    openings: list[Callable[[Array], Array]]
    """Fields [m] that are negative where the solid is cut away: neck, sleeve ends, waist, leg ends, hem."""
    top: float
    """Height of the waist border of a lower garment, or of the shoulder of an upper one [m]."""
    bottom: float
    """Height of the lowest border [m]."""
    flare: float
    """Growth of a skirt's width from waist to hem that the template already has, as a share of the waist's width."""


def _ramp(low: float, high: float, bottom: float, top: float, axis: int = 2) -> Ease:
    """Ease that goes smoothly from `low` [m] at and below height `bottom` to `high` at and above `top`."""

    def ease(points: Array) -> Array:
        t = np.clip((points[:, axis] - bottom) / (top - bottom), 0.0, 1.0)
        return low + (high - low) * t * t * (3 - 2 * t)

    return ease


def _ring(centre: Array, normal: Array, radius: float, stretch: float = 1.0) -> Array:
    """Points of an ellipse [m] across `normal`, shape [48, 3]; `stretch` is its depth (y) by its width."""
    angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    side = np.cross(normal, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    depth = np.array([0.0, 1.0, 0.0])
    return centre + radius * (np.cos(angle)[:, None] * side + stretch * np.sin(angle)[:, None] * depth)


def _ellipsoid(centre: Array, radii: tuple[float, float, float]) -> Callable[[Array], Array]:
    """About the distance to an ellipsoid [m], positive outside."""

    def field(points: Array) -> Array:
        q = (points - centre) / np.array(radii)
        length = np.linalg.norm(q, axis=1)
        slope = np.linalg.norm(q / np.array(radii), axis=1) / np.maximum(length, 1e-9)
        return (length - 1) / np.maximum(slope, 1e-9)

    return field


def _above(height: float) -> Callable[[Array], Array]:
    """Distance above a horizontal plane [m]."""
    return lambda points: points[:, 2] - height


def _below(height: float) -> Callable[[Array], Array]:
    """Distance below a horizontal plane [m]."""
    return lambda points: height - points[:, 2]


def _trunk(wearer: Wearer, nodes: Array, bottom: float, ease: Ease, straightness: float) -> Array:
    """Field of the torso part of an upper garment: between a fitted and a straight cut.

    `straightness` 1 wraps shoulders to hem in one hull, which hangs straight from chest and shoulder blades; 0 wraps
    the parts above and below the waist apart, which follows the waist.
    """
    points = wearer.points
    shoulder, neck = wearer.joint("left_shoulder"), wearer.joint("neck")
    near = (points[:, 2] > bottom - 0.03) & (points[:, 2] < neck[2] + 0.005)
    near &= (np.abs(points[:, 0]) < shoulder[0] + 0.005) | (points[:, 2] < shoulder[2] - 0.22)
    near &= np.abs(points[:, 0]) < 0.3
    points = points[near]
    waist = wearer.girth_height(0.05, 0.3, narrowest=True)
    # The cloth falls straight from the seat instead of following the thighs.
    seat = points[(points[:, 2] < 0.04) & (points[:, 2] > wearer.crotch)]
    points = np.concatenate([points, seat * [1, 1, 0] + [0, 0, bottom - 0.03]])
    straight = hull_field(nodes, points, ease)
    upper = hull_field(nodes, points[points[:, 2] > waist - 0.03], ease)
    lower = hull_field(nodes, points[points[:, 2] < waist + 0.03], ease)
    return straightness * straight + (1 - straightness) * np.minimum(upper, lower)


def tshirt(wearer: Wearer, grid_of: Callable[[Array], Grid]) -> Design:
    """Long sleeves, round neck, a straight body that ends below the hips."""
    shoulder, wrist, neck = (wearer.joint(n) for n in ("left_shoulder", "left_wrist", "neck"))
    bottom = wearer.crotch - 0.05
    points = wearer.points
    grid = grid_of(
        points[
            (points[:, 2] > bottom - 0.05) & (points[:, 2] < neck[2] + 0.04) & (np.abs(points[:, 0]) < wrist[0] + 0.05)
        ]
    )
    nodes = grid.nodes()
    trunk = _trunk(wearer, nodes, bottom, _ramp(0.024, 0.006, shoulder[2] - 0.15, shoulder[2] + 0.03), 0.7)
    arm = points[
        (points[:, 0] > shoulder[0] - 0.03) & (points[:, 2] > shoulder[2] - 0.085) & (points[:, 0] < wrist[0] + 0.02)
    ]
    cuff = _ring(wrist + np.array([0.02, 0.0, 0.0]), np.array([1.0, 0, 0]), 0.046)
    sleeve = hull_field(nodes, np.concatenate([arm, cuff]), _ramp(0.018, 0.007, shoulder[2] - 0.06, shoulder[2] + 0.05))
    axes = Axes.of(wearer.joints)
    return Design(
        volume=Volume.smoothed(grid, np.minimum(trunk, sleeve), ROUNDING),
        openings=[
            _ellipsoid(np.array([0.0, neck[1] - 0.012, neck[2] + 0.035]), (0.088, 0.085, 0.095)),
            lambda p: (1.0 - axes.along_arm(p)) * axes.arm_length,
            _above(bottom),
        ],
        top=float(shoulder[2]),
        bottom=bottom,
        flare=0.0,
    )


def top(wearer: Wearer, grid_of: Callable[[Array], Grid]) -> Design:
    """Sleeveless, wide straps, a lower neck, a body that follows the waist a little."""
    shoulder, neck = wearer.joint("left_shoulder"), wearer.joint("neck")
    bottom = wearer.crotch - 0.05
    points = wearer.points
    grid = grid_of(
        points[(points[:, 2] > bottom - 0.05) & (points[:, 2] < neck[2] + 0.04) & (np.abs(points[:, 0]) < 0.28)]
    )
    nodes = grid.nodes()
    trunk = _trunk(wearer, nodes, bottom, _ramp(0.014, 0.006, shoulder[2] - 0.15, shoulder[2] + 0.03), 0.3)
    return Design(
        volume=Volume.smoothed(grid, trunk, ROUNDING),
        openings=[
            _ellipsoid(np.array([0.0, neck[1] - 0.02, neck[2] + 0.02]), (0.082, 0.11, 0.125)),
            lambda p: _ellipsoid(shoulder + np.array([0.035, 0.0, -0.02]), (0.085, 0.16, 0.095))(
                np.stack([np.abs(p[:, 0]), p[:, 1], p[:, 2]], axis=1)
            ),
            _above(bottom),
        ],
        top=float(shoulder[2]),
        bottom=bottom,
        flare=0.0,
    )


def trousers(wearer: Wearer, grid_of: Callable[[Array], Grid]) -> Design:
    """Full length, snug at the waist, straight legs from the widest of the thigh."""
    ankle, hip = wearer.joint("left_ankle"), wearer.joint("left_hip")
    waist = wearer.girth_height(0.05, 0.3, narrowest=True) - 0.02
    points = wearer.points[np.abs(wearer.points[:, 0]) < 0.42]
    grid = grid_of(points[(points[:, 2] > ankle[2] - 0.06) & (points[:, 2] < waist + 0.06)])
    nodes = grid.nodes()
    pelvis = points[(points[:, 2] > wearer.crotch - 0.01) & (points[:, 2] < waist + 0.05)]
    seat = hull_field(nodes, pelvis, _ramp(0.010, 0.005, 0.0, waist))
    leg = points[(points[:, 0] > 0.004) & (points[:, 2] < 0.0) & (points[:, 2] > ankle[2] + 0.02)]
    direction = (ankle - hip) / np.linalg.norm(ankle - hip)
    end = _ring(ankle + 0.04 * direction, direction, 0.068)
    legs = hull_field(nodes, np.concatenate([leg, end]), _ramp(0.012, 0.008, -0.35, -0.1))
    axes = Axes.of(wearer.joints)
    return Design(
        volume=Volume.smoothed(grid, np.minimum(seat, legs), ROUNDING),
        openings=[_below(waist), lambda p: (1.0 - axes.along_leg(p)) * axes.leg_length],
        top=waist,
        bottom=float(ankle[2]),
        flare=0.0,
    )


def skirt(wearer: Wearer, grid_of: Callable[[Array], Grid]) -> Design:
    """Waist to shin, snug at the waist, falling in an A-line."""
    ankle, knee = wearer.joint("left_ankle"), wearer.joint("left_knee")
    waist = wearer.girth_height(0.05, 0.3, narrowest=True) - 0.02
    bottom = float(knee[2] + 0.7 * (ankle[2] - knee[2]))
    points = wearer.points[np.abs(wearer.points[:, 0]) < 0.42]
    points = points[(points[:, 2] > bottom - 0.03) & (points[:, 2] < waist + 0.05)]
    width = np.abs(points[points[:, 2] < bottom + 0.02, 0]).max() + 0.01
    hem = _ring(np.array([0.0, -0.01, bottom - 0.04]), np.array([0.0, 0.0, 1.0]), width, 0.8)
    around = np.concatenate([points, hem])
    grid = grid_of(around)
    field = hull_field(grid.nodes(), around, _ramp(0.014, 0.005, 0.0, waist))
    ring = points[np.abs(points[:, 2] - waist) < 0.01]
    return Design(
        volume=Volume.smoothed(grid, field, ROUNDING),
        openings=[_below(waist), _above(bottom)],
        top=waist,
        bottom=bottom,
        flare=float(width / np.abs(ring[:, 0]).max() - 1.0),
    )


DESIGNS: dict[str, Callable[[Wearer, Callable[[Array], Grid]], Design]] = {
    "tshirt": tshirt,
    "top": top,
    "trousers": trousers,
    "skirt": skirt,
}
"""The designs by garment type."""


def default_grid(points: Array) -> Grid:
    """The grid of `SPACING` around some points, with room for ease and blur."""
    return Grid.around(points, 0.06, SPACING)
