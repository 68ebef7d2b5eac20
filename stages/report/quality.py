"""Quality of simulated cloth, measured again from positions alone: nothing here asks the solver."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.mesh.geometry import edge_lengths
from model.mesh.topology import edge_list

Array = NDArray[np.float64]

# Order of the winding number's expansion, and how many radii away it is used: both libigl's most accurate in use.
WINDING_ORDER, WINDING_ACCURACY = 2, 2.0


@dataclass(frozen=True, kw_only=True)
class Figures:
    """What was measured on one garment over a sequence.

    Attributes:
        finite: Whether every coordinate is finite.
        depth: Largest depth of a vertex inside the body [m], 0 if none is inside, in each frame, shape [T].
        stretched: Share of the edges stretched beyond the limit, in each frame, shape [T].
        stretch_p99: 99th percentile of the edges' stretch over all frames, as a share of the rest length.
        stretch_max: Largest stretch of any edge in any frame, as a share of the rest length.
    """

    finite: bool
    depth: Array
    stretched: Array
    stretch_p99: float
    stretch_max: float


def depth_inside(points: ArrayLike, vertices: ArrayLike, faces: ArrayLike) -> Array:
    """Exact distance to the surface of the points that lie inside it, by libigl; 0 outside, shape [N].

    Inside is where the winding number exceeds a half (Jacobson, Kavan and Sorkine-Hornung 2013), which holds for bodies
    that fold into themselves too: there the side of the nearest triangle may be the inside of another part.

    Args:
        points: Points [m], shape [N, 3].
        vertices: Vertices of the closed surface [m], shape [V, 3].
        faces: Its triangles, counter-clockwise seen from outside, shape [F, 3].
    """
    points = np.ascontiguousarray(points, dtype=np.float64)
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    faces = np.ascontiguousarray(faces, dtype=np.int64)
    winding = igl.FastWindingNumberBVH()
    winding.init(vertices, faces, WINDING_ORDER)
    depth = np.zeros(len(points))
    inside = np.flatnonzero(winding.winding_number(points, WINDING_ACCURACY) > 0.5)
    if len(inside):
        boxes = igl.AABB()
        boxes.init(vertices, faces)
        squared, *_ = boxes.squared_distance(vertices, faces, np.ascontiguousarray(points[inside]))
        depth[inside] = np.sqrt(squared)
    return depth


def stretches(positions: ArrayLike, rest: ArrayLike, faces: ArrayLike) -> Array:
    """Stretch of every edge in every frame, |x_i - x_j| / |X_i - X_j| - 1, shape [T, E].

    Args:
        positions: Vertices over time [m], shape [T, N, 3].
        rest: Vertices at rest [m], shape [N, 3].
        faces: Triangles, shape [F, 3].
    """
    edges = edge_list(faces)
    lengths = np.stack([edge_lengths(frame, edges) for frame in np.asarray(positions)])
    return lengths / edge_lengths(rest, edges) - 1.0


def measure(
    positions: ArrayLike,
    rest: ArrayLike,
    faces: ArrayLike,
    body_positions: ArrayLike,
    body_faces: ArrayLike,
    stretch_limit: float,
) -> Figures:
    """Measures one garment over a sequence.

    Args:
        positions: The garment's vertices over time [m], shape [T, N, 3].
        rest: Its vertices at rest [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        body_positions: The body's vertices over time in the same frame of reference [m], shape [T, V, 3].
        body_faces: The body's triangles, shape [G, 3].
        stretch_limit: Stretch beyond which an edge counts, as a share of the rest length.
    """
    x = np.asarray(positions, dtype=np.float64)
    if not np.all(np.isfinite(x)):
        lost = np.full(len(x), np.nan)
        return Figures(finite=False, depth=lost, stretched=lost, stretch_p99=np.nan, stretch_max=np.nan)
    depth = np.array([depth_inside(p, b, body_faces).max() for p, b in zip(x, np.asarray(body_positions))])
    stretch = stretches(x, rest, faces)
    return Figures(
        finite=True,
        depth=depth,
        stretched=np.mean(stretch > stretch_limit, axis=1),
        stretch_p99=float(np.percentile(stretch, 99.0)),
        stretch_max=float(stretch.max()),
    )
