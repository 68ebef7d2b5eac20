"""Names a garment's borders, and marks the elastics and the waistband that run along them."""

from collections.abc import Callable
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

BELOW_SHOULDERS = 0.04
"""An upper border that ends this far below the shoulder joints has no straps: it is the chest's, not the neck's [m]."""

ON_OPENING = 2.5e-3
"""Distance within which a vertex of a border lies on the side of an open front [m]: edges cut its curve short."""

FASTENING = 0.04
"""Length of the part of an open front that is fastened [m]."""

CHEST_SNUGNESS = 0.92
"""Girth of the band of a strapless top as a share of the wearer's: a waistband rests on the hips, this one on nothing,
and with the arms down the chest is narrower than at rest."""

ELASTIC_RINGS = 1
"""Rings of vertices beside a border or seam that belong to its elastic."""


@dataclass(frozen=True, eq=False)
class Border:
    """One border of a garment."""

    name: str
    """`neck`, `chest`, `left_sleeve`, `right_armhole`, `left_front_opening`, `placket`, `waist`, `left_leg`, `hem` and
    their mirror images."""
    loop: Faces
    """Its vertices in the faces' direction, shape [n]; a part of a loop has those of its neighbours at its ends."""
    closed: bool = True
    """Whether it is a loop of its own: an open front joins the neck to the hem."""

    def length(self, points: Array) -> float:
        """Its length [m] on vertices [m], shape [N, 3]."""
        return loop_length(points, self.loop) if self.closed else path_length(points, self.loop)


def name_borders(
    garment: str, points: Array, faces: Faces, axes: Axes, opening: Callable[[Array], Array] | None = None
) -> list[Border]:
    """Names the borders of a garment by where they lie on the mean body.

    Args:
        garment: Type of the garment.
        points: Its vertices on the mean body [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        axes: Arms and legs of the mean body.
        opening: Distance of points to the borders of an open front [m]; None without one.

    Returns:
        The borders, from the highest to the lowest.
    """
    loops = sorted(
        border_loops(faces), key=lambda loop: (-round(float(points[loop, 2].mean()), 2), -points[loop, 0].mean())
    )
    borders: list[Border] = []
    for loop in loops:
        aside = np.abs(opening(points[loop])) < ON_OPENING if opening is not None else np.zeros(len(loop), dtype=bool)
        if aside.any():
            borders += _parts(points, loop, aside)
        else:
            borders.append(Border(_name(garment, points[loop], axes, loop is loops[-1]), loop))
    return borders


def _parts(points: Array, loop: Faces, aside: NDArray[np.bool_]) -> list[Border]:
    """Neck, hem and the two sides of an open front [`aside`, shape [n]], or neck and placket, which are one loop."""
    # The ends of neck and hem lie on the opening's sides, too: a step belongs to a side if both its ends do.
    step = aside & np.roll(aside, -1)
    changes = np.flatnonzero(step != np.roll(step, 1))
    paths = [
        (bool(step[start]), loop[np.arange(start, start + (end - start) % len(loop) + 1) % len(loop)])
        for start, end in zip(changes, np.roll(changes, -1))
    ]
    across = sorted((path for side, path in paths if not side), key=lambda path: -float(points[path, 2].mean()))
    sides = sorted((path for side, path in paths if side), key=lambda path: -float(points[path, 0].mean()))
    names = ("neck", "hem", "left_front_opening", "right_front_opening") if len(sides) == 2 else ("neck", "placket")
    return [Border(name, path, closed=False) for name, path in zip(names, [*across, *sides], strict=True)]


def _name(garment: str, loop: Array, axes: Axes, lowest: bool) -> str:
    """Name of the border at some points [m], shape [n, 3]."""
    centre = loop.mean(axis=0)
    side = "left" if centre[0] > 0 else "right"
    off_centre = abs(centre[0]) > 0.3 * axes.hip[0]
    if off_centre and centre[2] > axes.hip[2] + 0.1:
        return f"{side}_{'sleeve' if abs(centre[0]) > axes.shoulder[0] + 0.3 * 0.15 * axes.arm_length else 'armhole'}"
    if off_centre:
        return f"{side}_leg"
    if lowest:
        return "hem"
    if garment in ("trousers", "skirt"):
        return "waist"
    return "neck" if loop[:, 2].max() > axes.shoulder[2] - BELOW_SHOULDERS else "chest"


def loop_length(points: Array, loop: Faces) -> float:
    """Length of a closed loop of vertices [m]."""
    return float(np.linalg.norm(points[loop] - points[np.roll(loop, -1)], axis=1).sum())


def path_length(points: Array, path: Faces) -> float:
    """Length of a path of vertices from end to end [m]."""
    return float(np.linalg.norm(np.diff(points[path], axis=0), axis=1).sum())


def tape_girth(points: Array) -> float:
    """What a tape measure around a horizontal ring of points reads [m]: the perimeter of their convex hull."""
    hull = points[:, :2][ConvexHull(points[:, :2]).vertices]
    return float(np.linalg.norm(hull - np.roll(hull, -1, axis=0), axis=1).sum())
