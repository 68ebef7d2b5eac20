"""Cuts a garment along a level line of a smooth field, leaving a smooth border and no slivers.

Near vertices are first moved onto the line, then the triangles that still cross it are split, and the triangles along
the new border are brought back into shape by `polishing`.
"""

import numpy as np
import scipy.sparse as sp

from model.mesh.topology import border_vertices, edges_with_counts
from stages.outfit.polishing import polish
from stages.outfit.surface import Array, Faces, Surface

SNAP = 0.35
"""A vertex nearer to the line than this share of a crossing edge moves onto it instead of the edge being split."""


def cut(surface: Surface, field: Array, edge: float) -> Surface:
    """Keeps the part where the field is positive.

    The line may be closed, or run from border to border; its ends lie on those borders.

    Args:
        surface: Mesh to cut.
        field: Signed distance to the line, or another smooth field [any unit], shape [N].
        edge: Edge length of the mesh [m], the measure of what is too short.

    Returns:
        The part with its new border on the field's zero line; empty where the field is nowhere positive.
    """
    values = np.asarray(field, dtype=np.float64)
    if values.min() > 0:
        return surface
    snapped, values = _snap(surface, values)
    split, on_line = _split(snapped, values)
    part = Surface(split.vertices, split.faces, split.rows)
    used = np.zeros(len(part.vertices), dtype=bool)
    used[part.faces.reshape(-1)] = True
    return polish(part.compacted(), on_line[used], edge)


def _snap(surface: Surface, values: Array) -> tuple[Surface, Array]:
    """Moves vertices that are close to the line onto it, along their most nearly halved crossing edge.

    Those of a border keep to that border.
    """
    edges, faces = edges_with_counts(surface.faces)
    both, inner = np.vstack([edges, edges[:, ::-1]]), np.concatenate([faces, faces]) > 1
    at_border = border_vertices(surface.faces, len(values))
    a, b = both[(values[both[:, 0]] * values[both[:, 1]] < 0) & ~(inner & at_border[both[:, 0]])].T
    share = values[a] / (values[a] - values[b])
    near = np.flatnonzero(share < SNAP)
    # The shortest move of each vertex: sorted by share, the first entry of each vertex wins.
    near = near[np.argsort(share[near], kind="stable")]
    moved, first = np.unique(a[near], return_index=True)
    ends, t = b[near[first]], share[near[first]]
    count = len(values)
    kept = np.ones(count)
    kept[moved] = 1 - t
    shift = sp.csr_matrix((t, (moved, ends)), shape=(count, count))
    blend = (sp.diags(kept) + shift).tocsr()
    values = values.copy()
    values[moved] = 0.0
    return Surface(blend @ surface.vertices, surface.faces, blend @ surface.rows), values


def _split(surface: Surface, values: Array) -> tuple[Surface, np.ndarray]:
    """Splits crossing faces; returns the positive part with all vertices, and which of them lie on the line."""
    faces, side = surface.faces, np.sign(values).astype(int)
    corner = side[faces]
    kept = faces[(corner.min(axis=1) >= 0) & (corner.max(axis=1) > 0)]
    crossing = faces[(corner.min(axis=1) < 0) & (corner.max(axis=1) > 0)]

    ends: list[tuple[int, int]] = []
    of_edge: dict[tuple[int, int], int] = {}
    parts: list[list[int]] = []
    for triangle in crossing.tolist():
        ring: list[int] = []
        for a, b in zip(triangle, triangle[1:] + triangle[:1]):
            if side[a] >= 0:
                ring.append(a)
            if side[a] * side[b] < 0:
                key = (min(a, b), max(a, b))
                if key not in of_edge:
                    of_edge[key] = len(values) + len(ends)
                    ends.append(key)
                ring.append(of_edge[key])
        parts.append(ring)

    pairs = np.array(ends, dtype=np.int64).reshape(-1, 2)
    t = values[pairs[:, 0]] / (values[pairs[:, 0]] - values[pairs[:, 1]])
    index = np.arange(len(pairs))
    blend = sp.csr_matrix(
        (np.concatenate([1 - t, t]), (np.concatenate([index, index]), pairs.T.reshape(-1))),
        shape=(len(pairs), len(values)),
    )
    whole = sp.vstack([sp.identity(len(values), format="csr"), blend], format="csr")
    vertices = whole @ surface.vertices
    on_line = np.concatenate([side == 0, np.ones(len(pairs), dtype=bool)])
    new = _triangulate(vertices, parts)
    return Surface(vertices, np.concatenate([kept, new]), (whole @ surface.rows).tocsr()), on_line


def _triangulate(vertices: Array, rings: list[list[int]]) -> Faces:
    """Faces of triangles and quadrilaterals; a quadrilateral is split along its shorter diagonal."""
    out: list[tuple[int, int, int]] = []
    for ring in rings:
        if len(ring) == 4:
            a, b, c, d = ring
            if np.linalg.norm(vertices[a] - vertices[c]) <= np.linalg.norm(vertices[b] - vertices[d]):
                out += [(a, b, c), (a, c, d)]
            else:
                out += [(a, b, d), (b, c, d)]
        else:
            out.append((ring[0], ring[1], ring[2]))
    return np.array(out, dtype=np.int64).reshape(-1, 3)
