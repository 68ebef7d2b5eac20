"""Brings the triangles along a new border or seam back into shape: collapse, flip, and slide, only near the line."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.mesh.geometry import area_vectors, vertex_normals
from model.mesh.topology import adjacency, border_halfedges, compact, edge_list
from stages.outfit.surface import Array, Faces, Surface, grown

SHORT = 0.6
"""Edges near the line shorter than this share of the mesh's edge length are collapsed."""

RINGS = 3
"""How many rings of vertices from the line may move."""

ROUNDS = 3
"""Rounds of collapse, flip and slide: more no longer change the angles."""

SLIDES = 4
"""Steps towards the neighbours' mean in each round."""


@dataclass(frozen=True, eq=False)
class _Patch:
    """The mesh around a line: vertices are dropped from it but never added, so that each keeps its number outside."""

    vertices: Array
    """Positions [m], shape [n, 3]."""
    faces: Faces
    """Triangles over the patch's own numbers, shape [f, 3]."""
    blend: sp.csr_matrix
    """Each vertex as a mean of the whole mesh's vertices, shape [n, N]."""
    numbers: Faces
    """Number of each vertex in the whole mesh, shape [n]."""
    line: NDArray[np.bool_]
    """Which vertices lie on the line, shape [n]."""
    rim: NDArray[np.bool_]
    """Which vertices the rest of the mesh uses too, shape [n]."""

    @cached_property
    def edges(self) -> Faces:
        """All edges, shape [E, 2]."""
        return edge_list(self.faces)

    @cached_property
    def border_edges(self) -> Faces:
        """Edges on the border of the patch, whether or not the whole mesh has one there, shape [B, 2]."""
        return border_halfedges(self.faces)

    @cached_property
    def border(self) -> NDArray[np.bool_]:
        """Vertices on that border, shape [n]."""
        border = np.zeros(len(self.vertices), dtype=bool)
        border[self.border_edges.reshape(-1)] = True
        return border

    @cached_property
    def line_edges(self) -> Faces:
        """Edges of the line: those of the border if it is one, else those inside with both ends on it."""
        border = self.border_edges[self.line[self.border_edges].all(axis=1)]
        return border if len(border) else self.edges[self.line[self.edges].all(axis=1)]


def polish(surface: Surface, line: NDArray[np.bool_], edge: float) -> Surface:
    """Improves the triangles near a line without moving the line.

    Args:
        surface: The mesh.
        line: Vertices on the line (on the border, or on a seam inside), shape [N]; they only slide along it.
        edge: Edge length of the mesh [m].

    Returns:
        The mesh; vertices away from the line are untouched.
    """
    count = len(surface.vertices)
    around = grown(line, surface.faces, RINGS + 2)
    inside = around[surface.faces].all(axis=1)
    faces, numbers = compact(surface.faces[inside], count)
    outside = surface.faces[~inside]
    shared = np.zeros(count, dtype=bool)
    shared[outside.reshape(-1)] = True
    unit = sp.identity(count, format="csr")
    patch = _Patch(surface.vertices[numbers], faces, unit[numbers], numbers, line[numbers], shared[numbers])
    track = _Track.along(patch)
    for _ in range(ROUNDS):
        patch = _collapse(patch, edge)
        near = grown(patch.line, patch.faces, RINGS) & ~patch.rim
        patch = replace(patch, faces=_flip(patch.vertices, patch.faces, near))
        patch = _slide(patch, near, track)

    vertices = surface.vertices.copy()
    vertices[patch.numbers] = patch.vertices
    touched = np.zeros(count)
    touched[patch.numbers] = 1.0
    place = sp.csr_matrix(
        (np.ones(len(patch.numbers)), (patch.numbers, np.arange(len(patch.numbers)))), (count, len(patch.numbers))
    )
    rows = (sp.diags(1.0 - touched) + place @ patch.blend) @ surface.rows
    whole = Surface(vertices, np.concatenate([outside, patch.numbers[patch.faces]]), rows.tocsr())
    return whole.compacted()


class _Track:
    """The polyline that the vertices of a line slide along."""

    def __init__(self, starts: Array, ends: Array) -> None:
        self.starts, self.ends = starts, ends

    @classmethod
    def along(cls, patch: _Patch) -> "_Track":
        """The edges of the patch's line."""
        edges = patch.line_edges
        return cls(patch.vertices[edges[:, 0]], patch.vertices[edges[:, 1]])

    def nearest(self, points: Array) -> Array:
        """The nearest point of the polyline to each point [m], shape [n, 3]."""
        along = self.ends - self.starts
        length2 = np.maximum((along**2).sum(axis=1), 1e-18)
        # All pairs, one coordinate at a time.
        offset = [points[:, k, None] - self.starts[:, k] for k in range(3)]
        t = np.clip(sum(o * along[:, k] for k, o in enumerate(offset)) / length2, 0.0, 1.0)
        best = sum((o - t * along[:, k]) ** 2 for k, o in enumerate(offset)).argmin(axis=1)
        feet: Array = self.starts[best] + t[np.arange(len(points)), best, None] * along[best]
        return feet


def _collapse(patch: _Patch, edge: float) -> _Patch:
    """Collapses short edges that touch the line, shortest first, where that keeps the mesh a manifold."""
    faces, points, line, border = patch.faces, patch.vertices, patch.line, patch.border
    border_edges = {(min(a, b), max(a, b)) for a, b in patch.border_edges.tolist()}
    line_edges = {(min(a, b), max(a, b)) for a, b in patch.line_edges.tolist()}
    corner = np.bincount(patch.line_edges.reshape(-1), minlength=len(points)) == 1
    edges = patch.edges[line[patch.edges].any(axis=1)]
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    short = np.flatnonzero(length < SHORT * edge)
    if len(short) == 0:
        return patch
    local = faces[np.isin(faces, edges[short]).any(axis=1)]
    around: dict[int, set[int]] = {}
    for a, b, c in local.tolist():
        for v, w, u in ((a, b, c), (b, c, a), (c, a, b)):
            around.setdefault(v, set()).update((w, u))

    into = np.arange(len(points))
    partner = np.arange(len(points))
    touched: set[int] = set()
    for index in short[np.argsort(length[short], kind="stable")].tolist():
        a, b = (int(v) for v in edges[index])
        ring = around[a] | around[b]
        on_border, on_line = (a, b) in border_edges, bool(line[a] and line[b])
        if (on_line and (a, b) not in line_edges) or (border[a] and border[b] and not on_border):
            continue
        if ring & touched or len(around[a] & around[b]) != (1 if on_border else 2):
            continue
        keep, drop = (b, a) if (line[b] and not line[a]) or corner[b] else (a, b)
        if (border[drop] and not on_border) or patch.rim[drop] or corner[drop]:
            continue
        halved = on_line and not corner[keep]
        place = (points[a] + points[b]) / 2 if halved else points[keep]
        if not _keeps_orientation(points, local, a, b, place):
            continue
        if halved:
            partner[keep] = drop
        into[drop] = keep
        touched |= ring
    merged = into[faces]
    alive = (merged[:, 0] != merged[:, 1]) & (merged[:, 1] != merged[:, 2]) & (merged[:, 2] != merged[:, 0])
    new_faces, kept = compact(merged[alive], len(points))
    # A vertex on the line moves to the middle of the edge that collapsed into it; the line's ends stay.
    return _Patch(
        (points[kept] + points[partner[kept]]) / 2,
        new_faces,
        ((patch.blend[kept] + patch.blend[partner[kept]]) * 0.5).tocsr(),
        patch.numbers[kept],
        line[kept],
        patch.rim[kept],
    )


def _keeps_orientation(points: Array, faces: Faces, a: int, b: int, place: Array) -> bool:
    """Whether no face around the edge turns by more than 60 degrees, or loses its area, when both ends move."""
    has_a, has_b = (faces == a).any(axis=1), (faces == b).any(axis=1)
    staying = faces[has_a ^ has_b]
    corners = points[staying]
    moved = np.where(((staying == a) | (staying == b))[:, :, None], place, corners)
    before = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    after = np.cross(moved[:, 1] - moved[:, 0], moved[:, 2] - moved[:, 0])
    size = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return bool(((before * after).sum(axis=1) > 0.5 * size).all())


def _flip(points: Array, faces: Faces, near: NDArray[np.bool_]) -> Faces:
    """Flips inner edges whose opposite angles sum to more than 180 degrees (Delaunay), where the surface is flat."""
    faces = faces.copy()
    for _ in range(2):
        local = np.flatnonzero(near[faces].all(axis=1))
        f = faces[local]
        half = np.stack([f, np.roll(f, -1, axis=1)], axis=2).reshape(-1, 2)
        opposite = np.roll(f, 1, axis=1).reshape(-1)
        owner = np.repeat(local, 3)
        base = len(points)
        codes = half[:, 0] * base + half[:, 1]
        order = np.argsort(codes)
        back = half[:, 1] * base + half[:, 0]
        where = np.minimum(np.searchsorted(codes[order], back), len(codes) - 1)
        twin = order[where]
        first = np.flatnonzero((codes[twin] == back) & (half[:, 0] < half[:, 1]))
        second = twin[first]
        a, b, c, d = half[first, 0], half[first, 1], opposite[first], opposite[second]
        bad = _angle(points, c, a, b) + _angle(points, d, a, b)
        one, two = np.stack([c, d, b], axis=1), np.stack([d, c, a], axis=1)
        old = area_vectors(points, np.stack([a, b, c], axis=1)) + area_vectors(points, np.stack([b, a, d], axis=1))
        size = np.linalg.norm(old, axis=1) + 1e-30
        flat = (area_vectors(points, one) * old).sum(axis=1) > 0.02 * size**2
        flat &= (area_vectors(points, two) * old).sum(axis=1) > 0.02 * size**2
        all_edges = edge_list(f)
        existing = np.isin(np.minimum(c, d) * base + np.maximum(c, d), all_edges[:, 0] * base + all_edges[:, 1])
        wanted = np.flatnonzero((bad > np.pi + 1e-6) & flat & ~existing)
        touched: set[int] = set()
        for i in wanted[np.argsort(-bad[wanted], kind="stable")].tolist():
            quad = {int(a[i]), int(b[i]), int(c[i]), int(d[i])}
            if quad & touched:
                continue
            touched |= quad
            faces[owner[first[i]]] = (c[i], d[i], b[i])
            faces[owner[second[i]]] = (d[i], c[i], a[i])
        if not touched:
            break
    return faces


def _angle(points: Array, apex: Faces, a: Faces, b: Faces) -> Array:
    """Angle at `apex` of the triangles (apex, a, b) [rad]."""
    u, v = points[a] - points[apex], points[b] - points[apex]
    return np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1))


def _slide(patch: _Patch, near: NDArray[np.bool_], track: _Track) -> _Patch:
    """Moves the vertices near the line towards their neighbours' mean: on the line along it, else tangentially."""
    faces, points, count = patch.faces, patch.vertices, len(patch.vertices)
    inner = near & ~patch.line & ~patch.border
    along, links = adjacency(patch.line_edges, count), adjacency(patch.edges, count)
    on_line = patch.line & (np.asarray(along.sum(axis=1)).reshape(-1) == 2)
    weights = sp.diags(inner.astype(float)) @ links + sp.diags(on_line.astype(float)) @ along
    total = np.asarray(weights.sum(axis=1)).reshape(-1)
    moving = total > 0
    step_matrix = sp.diags(np.where(moving, 0.5, 1.0)) + sp.diags(0.5 / np.where(moving, total, 1.0)) @ weights
    blend = patch.blend
    for _ in range(SLIDES):
        step = step_matrix @ points - points
        normals = vertex_normals(points, faces)
        step[inner] -= (step[inner] * normals[inner]).sum(axis=1, keepdims=True) * normals[inner]
        points = points + step
        points[on_line] = track.nearest(points[on_line])
        # The same step, without the correction along the normal, for what the vertices remember of the template.
        blend = step_matrix @ blend
    return replace(patch, vertices=points, blend=blend.tocsr())
