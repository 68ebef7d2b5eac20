"""Sews an upper to a lower piece at the waist: one manifold mesh, no doubled layer (CLOTH3D, Jumpsuits and Dresses)."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.mesh.topology import border_loops
from stages.outfit.coordinates import smooth_step
from stages.outfit.polishing import polish
from stages.outfit.resizing import averaging_matrix
from stages.outfit.surface import Array, Faces, Surface, grown

REACH_UP, REACH_DOWN = 0.12, 0.08
"""How far above and below the seam the pieces are drawn together [m]."""

UPPER_SHARE = 0.4
"""Where the seam lies between the waist of the lower piece (0) and that of the upper one (1)."""

SMOOTHINGS = 4
"""Averaging steps of the cloth next to the seam."""


def sew(upper: Surface, lower: Surface, edge: float) -> tuple[Surface, NDArray[np.bool_]]:
    """Joins two pieces whose waist borders face each other at about `STITCH` edge lengths.

    Args:
        upper: The piece above; its lowest border is sewn.
        lower: The piece below; its highest border is sewn.
        edge: Edge length of both [m].

    Returns:
        The garment, its rows over the templates of `upper` and then of `lower`; which vertices lie on the seam.
    """
    top_loop = min(border_loops(upper.faces), key=lambda loop: float(upper.vertices[loop, 2].mean()))
    bottom_loop = max(border_loops(lower.faces), key=lambda loop: float(lower.vertices[loop, 2].mean()))
    upper_points, lower_points = _draw_together(upper.vertices, top_loop, lower.vertices, bottom_loop)
    count = len(upper_points)
    vertices = np.concatenate([upper_points, lower_points])
    strip = _zip(vertices, top_loop, bottom_loop + count)
    faces = np.concatenate([upper.faces, lower.faces + count, strip])
    rows = sp.block_diag([upper.rows, lower.rows], format="csr")
    joined = Surface(vertices, faces, rows)
    near = np.zeros(len(vertices), dtype=bool)
    near[top_loop] = near[bottom_loop + count] = True
    near = grown(near, faces, 2)
    averaging = averaging_matrix(faces, len(vertices))
    for _ in range(SMOOTHINGS):
        vertices = np.where(near[:, None], averaging @ vertices, vertices)
    seam = np.zeros(len(vertices), dtype=bool)
    seam[top_loop] = True
    marked = sp.hstack([joined.rows, sp.csr_matrix(seam[:, None].astype(float))], format="csr")
    sewn = polish(Surface(vertices, faces, marked), seam, edge)
    # Only what lies on the seam is a mean of nothing but vertices of the seam; four rings beside it are so in part.
    on_seam = sewn.rows[:, -1].toarray().ravel() > 1.0 - 1e-6
    return Surface(sewn.vertices, sewn.faces, sewn.rows[:, :-1].tocsr()), on_seam


def _draw_together(upper: Array, top_loop: Faces, lower: Array, bottom_loop: Faces) -> tuple[Array, Array]:
    """Moves both waists to one outline between them, fading out away from the seam."""
    centre = lower[bottom_loop, :2].mean(axis=0)
    outlines = [_outline(upper[top_loop], centre), _outline(lower[bottom_loop], centre)]
    height = (upper[top_loop, 2].mean() + lower[bottom_loop, 2].mean()) / 2

    def drawn(points: Array, own: tuple[Array, Array], other: tuple[Array, Array], share: float, reach: float) -> Array:
        offset = points[:, :2] - centre
        angle = np.arctan2(offset[:, 1], offset[:, 0])
        ratio = np.interp(angle, *other, period=2 * np.pi) / np.interp(angle, *own, period=2 * np.pi)
        # Full at the seam, none at `reach` from it.
        fade = 1.0 - smooth_step(np.abs(points[:, 2] - height), 0.0, reach)
        out = points.copy()
        out[:, :2] = centre + offset * (1.0 + share * fade * (ratio - 1.0))[:, None]
        return out

    return (
        drawn(upper, outlines[0], outlines[1], 1.0 - UPPER_SHARE, REACH_UP),
        drawn(lower, outlines[1], outlines[0], UPPER_SHARE, REACH_DOWN),
    )


def _outline(loop: Array, centre: Array) -> tuple[Array, Array]:
    """Angles around the centre [rad], increasing, and distances from it [m] of a loop of points."""
    offset = loop[:, :2] - centre
    angle = np.arctan2(offset[:, 1], offset[:, 0])
    order = np.argsort(angle)
    return angle[order], np.linalg.norm(offset, axis=1)[order]


def _zip(points: Array, upper: Faces, lower: Faces) -> Faces:
    """A strip of triangles between two loops that run in opposite directions around the same axis.

    Args:
        points: Vertices [m], shape [N, 3].
        upper: Loop above, in the direction of its faces, shape [a].
        lower: Loop below, in the direction of its faces, shape [b].

    Returns:
        Faces, oriented as those that own the loops, shape [a + b, 3].
    """
    # A border runs along its faces; the strip uses each border edge the other way around, so walk both backwards.
    above, below = upper[::-1].tolist(), lower.tolist()
    start = int(np.argmin(np.linalg.norm(points[below] - points[above[0]], axis=1)))
    below = below[start:] + below[:start]
    above, below = [*above, above[0]], [*below, below[0]]
    i, j = 0, 0
    out: list[tuple[int, int, int]] = []
    while i < len(above) - 1 or j < len(below) - 1:
        if j == len(below) - 1:
            step_above = True
        elif i == len(above) - 1:
            step_above = False
        else:
            step_above = bool(
                np.linalg.norm(points[above[i + 1]] - points[below[j]])
                < np.linalg.norm(points[above[i]] - points[below[j + 1]])
            )
        if step_above:
            out.append((above[i], above[i + 1], below[j]))
            i += 1
        else:
            out.append((above[i], below[j + 1], below[j]))
            j += 1
    return np.array(out, dtype=np.int64)
