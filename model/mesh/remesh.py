"""Isotropic remeshing of an open surface: even edges, near-equilateral triangles, borders kept."""

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.mesh.geometry import face_normals, vertex_normals
from model.mesh.topology import adjacency, border_halfedges, compact, edge_list

Points = NDArray[np.float64]
Faces = NDArray[np.int64]

LONG, SHORT = 4.0 / 3.0, 4.0 / 5.0
"""Edges longer or shorter than these shares of the target are split or collapsed (Botsch and Kobbelt 2004)."""

CORNER = np.deg2rad(55.0)
"""Border vertices where the border turns by more than this stay where they are [rad]."""


def remesh(vertices: ArrayLike, faces: ArrayLike, edge: float, passes: int = 12) -> tuple[Points, Faces]:
    """Remeshes an oriented manifold surface with borders to edges of about one length.

    Args:
        vertices: Vertices [m], shape [V, 3].
        faces: Triangles, shape [F, 3].
        edge: Target edge length [m].
        passes: Rounds of split, collapse, flip and smoothing.

    Returns:
        Vertices [m], shape [V', 3], on the input surface; those of a border on the input border, its corners
        unmoved. Faces, shape [F', 3], oriented as the input.

    Source: Botsch and Kobbelt, A Remeshing Approach to Multiresolution Modeling (2004).
    """
    source = (np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(faces, dtype=np.int64))
    border = np.ascontiguousarray(border_halfedges(source[1]))
    corners = source[0][_corners(*source)]
    points, triangles = source
    for _ in range(passes):
        points, triangles = _split_long(points, triangles, LONG * edge)
        points, triangles = _collapse_short(points, triangles, edge, _at(points, corners))
        triangles = _flip_to_valence(points, triangles)
        points = _relax(points, triangles, source, border, _at(points, corners))
    return points, triangles


def _corners(points: Points, faces: Faces) -> NDArray[np.int64]:
    """Border vertices at which the border turns sharply."""
    half = border_halfedges(faces)
    after = dict(half.tolist())
    a, b = half[:, 0], half[:, 1]
    c = np.array([after[v] for v in b.tolist()])
    first, second = points[b] - points[a], points[c] - points[b]
    cosine = (first * second).sum(1) / (np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1))
    return np.sort(b[cosine < np.cos(CORNER)])


def _at(points: Points, corners: Points) -> NDArray[np.bool_]:
    """Which vertices are the (unmoved) corners."""
    fixed = np.zeros(len(points), dtype=bool)
    for corner in corners:
        fixed[np.linalg.norm(points - corner, axis=1).argmin()] = True
    return fixed


def _split_long(points: Points, faces: Faces, limit: float) -> tuple[Points, Faces]:
    """Splits every edge above the limit at its midpoint, each face into two, three or four."""
    edges = edge_list(faces)
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    marked = edges[length > limit]
    middle = {(int(a), int(b)): len(points) + i for i, (a, b) in enumerate(marked)}
    out: list[tuple[int, int, int]] = []
    for face in faces.tolist():
        ring = [middle.get((min(a, b), max(a, b)), -1) for a, b in zip(face, face[1:] + face[:1], strict=True)]
        count = sum(m >= 0 for m in ring)
        if count == 0:
            out.append(tuple(face))
            continue
        # Turn the face so that the split edges come first.
        turn = {1: lambda r: r[0] >= 0, 2: lambda r: r[2] < 0, 3: lambda r: True}[count]
        while not turn(ring):
            face, ring = face[1:] + face[:1], ring[1:] + ring[:1]
        (a, b, c), (ab, bc, ca) = face, ring
        if count == 1:
            out += [(a, ab, c), (ab, b, c)]
        elif count == 2:
            out += [(ab, b, bc), (a, ab, c), (ab, bc, c)]
        else:
            out += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    new_points = np.vstack([points, 0.5 * (points[marked[:, 0]] + points[marked[:, 1]])])
    return new_points, np.array(out, dtype=np.int64)


def _collapse_short(points: Points, faces: Faces, edge: float, fixed: NDArray[np.bool_]) -> tuple[Points, Faces]:
    """Collapses edges that are too short, shortest first; no two collapses of one call touch."""
    edges = edge_list(faces)
    neighbours = _neighbours(edges, len(points))
    half = border_halfedges(faces)
    on_border = np.zeros(len(points), dtype=bool)
    on_border[half.reshape(-1)] = True
    border_edges = {(min(a, b), max(a, b)) for a, b in half.tolist()}
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    short = np.flatnonzero(length < SHORT * edge)
    locked = np.zeros(len(points), dtype=bool)
    moved, target = points.copy(), np.arange(len(points))
    around = _faces_around(faces, len(points))
    for a, b in edges[short[np.argsort(length[short], kind="stable")]].tolist():
        is_border = (a, b) in border_edges
        ring = neighbours[a] | neighbours[b]
        if (on_border[a] and on_border[b] and not is_border) or (fixed[a] and fixed[b]) or locked[list(ring)].any():
            continue
        if len(neighbours[a] & neighbours[b]) != (1 if is_border else 2):
            continue
        keep, drop = (b, a) if (fixed[b] or (on_border[b] and not on_border[a])) else (a, b)
        free = not fixed[keep] and on_border[a] == on_border[b]
        place = 0.5 * (points[a] + points[b]) if free else points[keep]
        if np.linalg.norm(points[list(ring - {a, b})] - place, axis=1).max() > LONG * edge:
            continue
        if not _keeps_orientation(points, faces[list(around[a] | around[b])], a, b, place):
            continue
        moved[keep], target[drop] = place, keep
        locked[list(ring)] = True
    merged = target[faces]
    whole = (merged[:, 0] != merged[:, 1]) & (merged[:, 1] != merged[:, 2]) & (merged[:, 2] != merged[:, 0])
    new_faces, kept = compact(merged[whole], len(points))
    return moved[kept], new_faces


def _keeps_orientation(points: Points, faces: Faces, a: int, b: int, place: Points) -> bool:
    """Whether no face around the edge a-b turns over when both ends move to `place`."""
    staying = faces[~((faces == a).any(1) & (faces == b).any(1))]
    corners = points[staying]
    moved = np.where(((staying == a) | (staying == b))[:, :, None], place, corners)
    return bool(((_cross(corners) * _cross(moved)).sum(1) > 0).all())


def _cross(corners: Points) -> Points:
    """Area-weighted normals of triangles given by their corners [F, 3, 3]."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _neighbours(edges: NDArray[np.int64], vertex_count: int) -> list[set[int]]:
    """The neighbours of each vertex."""
    rings: list[set[int]] = [set() for _ in range(vertex_count)]
    for a, b in edges.tolist():
        rings[a].add(b)
        rings[b].add(a)
    return rings


def _faces_around(faces: Faces, vertex_count: int) -> list[set[int]]:
    """The faces at each vertex."""
    around: list[set[int]] = [set() for _ in range(vertex_count)]
    for index, face in enumerate(faces.tolist()):
        for v in face:
            around[v].add(index)
    return around


def _flip_to_valence(points: Points, faces: Faces) -> Faces:
    """Flips inner edges where that brings valences nearer to 6 (4 on a border); no two flips of one call touch."""
    f = faces.copy()
    count = len(points)
    valence = np.bincount(edge_list(f).reshape(-1), minlength=count)
    goal = np.full(count, 6)
    goal[border_halfedges(f).reshape(-1)] = 4
    excess = valence - goal
    half = f[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    codes = half[:, 0] * count + half[:, 1]
    order = np.argsort(codes)
    position = np.searchsorted(codes[order], half[:, 1] * count + half[:, 0])
    twin = order[np.minimum(position, len(codes) - 1)]
    inner = (codes[twin] == half[:, 1] * count + half[:, 0]) & (half[:, 0] < half[:, 1])
    first = np.flatnonzero(inner)
    second = twin[first]
    a, b = half[first, 0], half[first, 1]
    c, d = f[first // 3, (first % 3 + 2) % 3], f[second // 3, (second % 3 + 2) % 3]
    gain = sum((excess[v] ** 2 - (excess[v] + step) ** 2) for v, step in ((a, -1), (b, -1), (c, 1), (d, 1)))
    before = _cross(points[np.stack([a, b, c], 1)]) + _cross(points[np.stack([b, a, d], 1)])
    one, two = _cross(points[np.stack([c, d, b], 1)]), _cross(points[np.stack([d, c, a], 1)])
    size = np.linalg.norm(before, axis=1)
    proper = np.minimum((one * before).sum(1), (two * before).sum(1)) > 0.05 * size**2
    linked = adjacency(edge_list(f), count)
    proper &= np.asarray(linked[c, d]).reshape(-1) == 0
    touched = np.zeros(count, dtype=bool)
    candidates = np.flatnonzero(proper & (gain > 0))
    for i in candidates[np.argsort(-gain[candidates], kind="stable")].tolist():
        quad = [a[i], b[i], c[i], d[i]]
        if touched[quad].any():
            continue
        touched[quad] = True
        f[first[i] // 3] = (c[i], d[i], b[i])
        f[second[i] // 3] = (d[i], c[i], a[i])
    return f


def _relax(
    points: Points, faces: Faces, source: tuple[Points, Faces], border: NDArray[np.int64], fixed: NDArray[np.bool_]
) -> Points:
    """Moves vertices towards the mean of their neighbours, inner ones along the surface, border ones along it."""
    count = len(points)
    half = border_halfedges(faces)
    on_border = np.zeros(count, dtype=bool)
    on_border[half.reshape(-1)] = True
    links = adjacency(edge_list(faces), count)
    along = adjacency(half, count)
    mean = (links @ points) / np.asarray(links.sum(axis=1)).reshape(-1, 1)
    mean[on_border] = (along @ points)[on_border] / 2.0
    step = 0.6 * (mean - points)
    normals = vertex_normals(points, faces)
    step[~on_border] -= (step * normals).sum(1, keepdims=True)[~on_border] * normals[~on_border]
    step[fixed] = 0.0
    moved = points + step
    inside = ~on_border
    moved[inside] = igl.point_mesh_squared_distance(np.ascontiguousarray(moved[inside]), *source)[2]
    sliding = on_border & ~fixed
    moved[sliding] = igl.point_mesh_squared_distance(np.ascontiguousarray(moved[sliding]), source[0], border)[2]
    # A step that would turn a face over is taken back at all three of its corners.
    turned = (face_normals(points, faces) * face_normals(moved, faces)).sum(1) < 0.2
    back = np.unique(faces[turned])
    moved[back] = points[back]
    return moved
