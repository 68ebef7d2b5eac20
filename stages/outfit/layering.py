"""Keeps an outer garment off the garment below it."""

import numpy as np
from numpy.typing import NDArray

from model.mesh.topology import border_loops
from stages.outfit.clearance import Obstacle

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

COLLAR = 0.03
"""How far the solid of an inner garment goes on above its waist [m], so that an outer one passes outside of it."""


def solid(vertices: Array, faces: Faces, margin: float) -> Obstacle:
    """The space that a garment encloses, as an obstacle for a garment worn over it.

    Its borders are closed with fans; above the highest one, the waist, a collar goes on upwards first.

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
        rim = loop
        if loop is waist:
            rim = np.arange(count, count + len(loop))
            points.append(vertices[loop] + [0.0, 0.0, COLLAR])
            count += len(loop)
            after, rim_after = np.roll(loop, -1), np.roll(rim, -1)
            triangles += [np.stack([after, loop, rim], axis=1), np.stack([after, rim, rim_after], axis=1)]
        points.append((points[-1] if loop is waist else vertices[loop]).mean(axis=0)[None])
        triangles.append(np.stack([np.roll(rim, -1), rim, np.full(len(rim), count)], axis=1))
        count += 1
    return Obstacle(np.concatenate(points), np.concatenate(triangles), margin)
