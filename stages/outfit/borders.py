"""Names a garment's borders, and marks the elastics and the waistband that run along them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from model.mesh.topology import border_loops
from stages.outfit.coordinates import Axes

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

WAISTBAND_WIDTH = 0.025
"""Height of a waistband [m]."""

ELASTIC_RINGS = 1
"""Rings of vertices beside a border or seam that belong to its elastic."""


@dataclass(frozen=True, eq=False)
class Border:
    """One border of a garment."""

    name: str
    """`neck`, `left_sleeve`, `right_armhole`, `waist`, `left_leg`, `hem` and their mirror images."""
    loop: Faces
    """Its vertices in the faces' direction, shape [n]."""


def name_borders(garment: str, points: Array, faces: Faces, axes: Axes) -> list[Border]:
    """Names the borders of a garment by where they lie on the mean body.

    Args:
        garment: Type of the garment.
        points: Its vertices on the mean body [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        axes: Arms and legs of the mean body.

    Returns:
        The borders, from the highest to the lowest.
    """
    loops = sorted(
        border_loops(faces), key=lambda loop: (-round(float(points[loop, 2].mean()), 2), -points[loop, 0].mean())
    )
    return [Border(_name(garment, points[loop].mean(axis=0), axes, loop is loops[-1]), loop) for loop in loops]


def _name(garment: str, centre: Array, axes: Axes, lowest: bool) -> str:
    """Name of the border around `centre` [m], shape [3]."""
    side = "left" if centre[0] > 0 else "right"
    off_centre = abs(centre[0]) > 0.3 * axes.hip[0]
    if off_centre and centre[2] > axes.hip[2] + 0.1:
        return f"{side}_{'sleeve' if abs(centre[0]) > axes.shoulder[0] + 0.3 * 0.15 * axes.arm_length else 'armhole'}"
    if off_centre:
        return f"{side}_leg"
    if lowest:
        return "hem"
    return "waist" if garment in ("trousers", "skirt") else "neck"


def loop_length(points: Array, loop: Faces) -> float:
    """Length of a closed loop of vertices [m]."""
    return float(np.linalg.norm(points[loop] - points[np.roll(loop, -1)], axis=1).sum())


def tape_girth(points: Array) -> float:
    """What a tape measure around a horizontal ring of points reads [m]: the perimeter of their convex hull."""
    hull = points[:, :2][ConvexHull(points[:, :2]).vertices]
    return float(np.linalg.norm(hull - np.roll(hull, -1, axis=0), axis=1).sum())
