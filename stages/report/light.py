"""The studio's light: a dome that is baked into the vertices and a key lamp that each picture traces.

Both are sums over fixed directions, so a picture has no noise and is the same at every run.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Occluded = Callable[[Array, Array], NDArray[np.bool_]]

DOME_DIRECTIONS = 48
# Rays leave the surface from this far outside [m]: more than the rounding of a fold, less than a cloth's distance
# to the body would let through.
RAY_START = 2e-3
# What other surfaces throw back into a place that sees nothing of the dome, as a share of the dome's light.
BOUNCED = 0.10
KEY_AZIMUTH, KEY_ELEVATION = np.radians(-48.0), np.radians(44.0)
KEY_SPREAD = np.radians(5.0)
KEY_DIRECTIONS = 8
# How much light an open level surface takes from the dome, and one that faces the lamp from the lamp.
DOME_SHARE, KEY_SHARE = 0.55, 0.80


def fibonacci_sphere(count: int) -> Array:
    """`count` unit vectors spread evenly over the sphere, shape [count, 3] (a Fibonacci lattice)."""
    index = np.arange(count) + 0.5
    z = 1.0 - 2.0 * index / count
    turn = np.pi * (1.0 + 5.0**0.5) * index
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def dome_radiance(directions: Array) -> Array:
    """Light that comes from each direction, shape [N]: bright above, a lit wall around, a dim floor below."""
    z = directions[:, 2]
    return np.where(z > 0.0, 0.62 + 0.9 * np.maximum(z, 0.0), 0.30)


def bake_dome(points: Array, normals: Array, occluded: Occluded) -> Array:
    """Light of the dome that reaches points of a surface, with the shadows that the scene casts.

    E = sum_d L(d) max(0, n.d) V(d) over fixed directions d, divided by the same sum for an unshadowed level surface,
    and a little light from elsewhere where V hides the dome.

    Args:
        points: Points of the surface [m], shape [N, 3].
        normals: Unit normals towards the lit side, shape [N, 3].
        occluded: Whether rays (origins, directions) hit anything.

    Returns:
        Relative irradiance, 1 for an open level surface, shape [N]; where nothing is seen of the dome, `BOUNCED`.
    """
    directions = fibonacci_sphere(DOME_DIRECTIONS)
    radiance = dome_radiance(directions)
    reference = float(radiance @ np.maximum(directions[:, 2], 0.0))
    total = np.zeros(len(points))
    origins = points + RAY_START * normals
    for direction, light in zip(directions, radiance):
        cosine = normals @ direction
        faces_it = np.flatnonzero(cosine > 0.0)
        if len(faces_it) == 0:
            continue
        rays = np.broadcast_to(direction, (len(faces_it), 3))
        open_sky = ~occluded(origins[faces_it], rays)
        total[faces_it] += light * cosine[faces_it] * open_sky
    return BOUNCED + (1.0 - BOUNCED) * total / reference


def key_directions(azimuth: float) -> Array:
    """Directions to the key lamp's disc, shape [KEY_DIRECTIONS, 3].

    Args:
        azimuth: Azimuth from the scene to the camera [rad]; the lamp stands to the left of the camera and above it.
    """
    turn, rise = azimuth + KEY_AZIMUTH, KEY_ELEVATION
    centre = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    across = np.array([-np.sin(turn), np.cos(turn), 0.0])
    up = np.cross(centre, across)
    index = np.arange(KEY_DIRECTIONS) + 0.5
    radius = np.tan(KEY_SPREAD) * np.sqrt(index / KEY_DIRECTIONS)
    # The golden angle, taken in steps that let every fourth direction cover the disc by itself.
    angle = np.pi * (3.0 - 5.0**0.5) * index
    spread = centre + (radius * np.cos(angle))[:, None] * across + (radius * np.sin(angle))[:, None] * up
    return spread / np.linalg.norm(spread, axis=1, keepdims=True)


def key_light(points: Array, normals: Array, shadow_normals: Array, directions: Array, occluded: Occluded) -> Array:
    """Share of the key lamp's light that reaches points, cosine included, shape [N].

    Args:
        points: Points of the surface [m], shape [N, 3].
        normals: Unit shading normals, shape [N, 3].
        shadow_normals: Unit normals of the flat faces on the lit side, along which rays leave the surface.
        directions: Directions to parts of the lamp, shape [D, 3].
        occluded: Whether rays (origins, directions) hit anything.
    """
    total = np.zeros(len(points))
    origins = points + RAY_START * shadow_normals
    for direction in directions:
        cosine = normals @ direction
        lit = np.flatnonzero(cosine > 0.0)
        if len(lit) == 0:
            continue
        rays = np.broadcast_to(direction, (len(lit), 3))
        total[lit] += cosine[lit] * ~occluded(origins[lit], rays)
    return total / len(directions)
