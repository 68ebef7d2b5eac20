"""Keeps an outer garment off the garment below it."""

import numpy as np
from numpy.typing import NDArray

from model.mesh.topology import border_loops
from stages.outfit.obstacle import Obstacle

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

DOME = ((0.01, 0.98), (0.02, 0.94), (0.035, 0.84), (0.05, 0.68))
"""Heights above the waist of an inner garment [m] and shares of its width at which a dome closes it: an outer garment
passes outside of the waist without a step."""


def solid(vertices: Array, faces: Faces, margin: float) -> Obstacle:
    """The space that a garment encloses, as an obstacle for a garment worn over it.

    Its borders are closed with fans, the highest one, the waist, with a dome.

    Args:
        vertices: Vertices of the garment [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        margin: Distance to keep from it [m].

    Returns:
        The obstacle: a closed surface that looks outwards.
    """
    points, triangles = [vertices], [faces]
    count = len(vertices)
    loops = border_loops(faces)
    waist = max(loops, key=lambda loop: float(vertices[loop, 2].mean()))
    for loop in loops:
        rim, ring = loop, vertices[loop]
        middle = ring.mean(axis=0)
        for rise, share in DOME if loop is waist else ():
            upper = np.arange(count, count + len(loop))
            ring = middle + share * (vertices[loop] - middle) + [0.0, 0.0, rise]
            points.append(ring)
            count += len(loop)
            after, upper_after = np.roll(rim, -1), np.roll(upper, -1)
            triangles += [np.stack([after, rim, upper], axis=1), np.stack([after, upper, upper_after], axis=1)]
            rim = upper
        points.append(ring.mean(axis=0)[None])
        triangles.append(np.stack([np.roll(rim, -1), rim, np.full(len(rim), count)], axis=1))
        count += 1
    return Obstacle(np.concatenate(points), np.concatenate(triangles), margin)
