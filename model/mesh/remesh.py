"""Isotropic remeshing of an open surface: even edges, near-equilateral triangles, borders kept."""

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from model.mesh.geometry import face_normals, vertex_normals
from model.mesh.topology import adjacency, border_halfedges, compact, edge_list, is_member

Points = NDArray[np.float64]
Faces = NDArray[np.int64]

LONG, SHORT = 4.0 / 3.0, 4.0 / 5.0
"""Edges longer or shorter than these shares of the target are split or collapsed (Botsch and Kobbelt 2004)."""

CORNER = np.deg2rad(55.0)
"""Border vertices where the border turns by more than this stay where they are [rad]."""


def remesh(
    vertices: ArrayLike,
    faces: ArrayLike,
    edge: float,
    passes: int = 12,
    onto: tuple[ArrayLike, ArrayLike] | None = None,
) -> tuple[Points, Faces]:
    """Remeshes an oriented manifold surface with borders to edges of about one length.

    Args:
        vertices: Vertices [m], shape [V, 3].
        faces: Triangles, shape [F, 3].
        edge: Target edge length [m].
        passes: Rounds of split, collapse, flip and smoothing.
        onto: Vertices and faces of the surface to stay on, of which the input is a remeshed copy; left out, the input.

    Returns:
        Vertices [m], shape [V', 3], on the input surface; those of a border on the input border, its corners
        unmoved. Faces, shape [F', 3], oriented as the input.

    Source: Botsch and Kobbelt, A Remeshing Approach to Multiresolution Modeling (2004).
    """
    points, triangles = _mesh(vertices, faces)
    source = _mesh(*onto) if onto is not None else (points, triangles)
    border = np.ascontiguousarray(border_halfedges(source[1]))
    corners = source[0][_corners(*source)]
    for _ in range(passes):
        points, triangles = _split_long(points, triangles, LONG * edge)
        points, triangles = _collapse_short(points, triangles, edge, _at(points, corners))
        triangles = _flip_to_valence(points, triangles)
        points = _relax(points, triangles, source, border, _at(points, corners))
    return points, triangles


def _mesh(vertices: ArrayLike, faces: ArrayLike) -> tuple[Points, Faces]:
    return np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(faces, dtype=np.int64)


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
    long = length > limit
    marked = edges[long]
    middle = np.full(len(edges), -1)
    middle[long] = len(points) + np.arange(len(marked))
    half = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
    low, high = half.min(axis=2), half.max(axis=2)
    base = len(points)
    ring = middle[np.searchsorted(edges[:, 0] * base + edges[:, 1], low * base + high)]
    is_split = ring >= 0
    count = is_split.sum(axis=1)
    # Turn the faces so that the split edges come first.
    turn = np.where(count == 1, is_split.argmax(axis=1), np.where(count == 2, (~is_split).argmax(axis=1) + 1, 0))
    order = (turn[:, None] + np.arange(3)) % 3
    face, ring = np.take_along_axis(faces, order, axis=1), np.take_along_axis(ring, order, axis=1)
    (a, b, c), (ab, bc, ca) = face.T, ring.T
    parts = {
        0: [(a, b, c)],
        1: [(a, ab, c), (ab, b, c)],
        2: [(ab, b, bc), (a, ab, c), (ab, bc, c)],
        3: [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)],
    }
    start = np.concatenate([[0], np.cumsum(count + 1)])
    out = np.empty((start[-1], 3), dtype=np.int64)
    for splits, pieces in parts.items():
        which = np.flatnonzero(count == splits)
        for number, corners in enumerate(pieces):
            out[start[which] + number] = np.stack([corner[which] for corner in corners], axis=1)
    new_points = np.vstack([points, 0.5 * (points[marked[:, 0]] + points[marked[:, 1]])])
    return new_points, out


def _collapse_short(points: Points, faces: Faces, edge: float, fixed: NDArray[np.bool_]) -> tuple[Points, Faces]:
    """Collapses edges that are too short, shortest first; no two collapses of one call touch."""
    count = len(points)
    edges = edge_list(faces)
    half = border_halfedges(faces)
    on_border = np.zeros(count, dtype=bool)
    on_border[half.reshape(-1)] = True
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    short = np.flatnonzero(length < SHORT * edge)
    a, b = edges[short[np.argsort(length[short], kind="stable")]].T
    is_border = is_member(a * count + b, np.sort(half.min(axis=1) * count + half.max(axis=1)))
    links = adjacency(edges, count)
    common = np.asarray(links[a].multiply(links[b]).sum(axis=1)).reshape(-1)
    good = ~(on_border[a] & on_border[b] & ~is_border) & ~(fixed[a] & fixed[b])
    good &= common == np.where(is_border, 1, 2)
    a, b = a[good], b[good]
    swap = fixed[b] | (on_border[b] & ~on_border[a])
    keep, drop = np.where(swap, b, a), np.where(swap, a, b)
    free = ~fixed[keep] & (on_border[a] == on_border[b])
    place = np.where(free[:, None], 0.5 * (points[a] + points[b]), points[keep])
    # The neighbours of both ends, themselves included: rows of a list of (edge, vertex).
    owner, ring = _rows((links[a] + links[b]).tocsr())
    ends = (ring == a[owner]) | (ring == b[owner])
    far = ~ends & (np.linalg.norm(points[ring] - place[owner], axis=1) > LONG * edge)
    good = np.bincount(owner[far], minlength=len(a)) == 0
    good &= _keeps_orientation(points, faces, a, b, place)
    chosen = _apart(owner, ring, np.flatnonzero(good), len(a), count)
    moved, target = points.copy(), np.arange(count)
    moved[keep[chosen]], target[drop[chosen]] = place[chosen], keep[chosen]
    merged = target[faces]
    whole = (merged[:, 0] != merged[:, 1]) & (merged[:, 1] != merged[:, 2]) & (merged[:, 2] != merged[:, 0])
    new_faces, kept = compact(merged[whole], count)
    return moved[kept], new_faces


def _rows(matrix: sp.csr_matrix) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Row and column of every entry of a sparse matrix, row by row."""
    return np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr)), matrix.indices.astype(np.int64)


def _apart(
    owner: NDArray[np.int64], members: NDArray[np.int64], wanted: NDArray[np.int64], rank_count: int, vertex_count: int
) -> NDArray[np.int64]:
    """Those of the wanted changes that no earlier one touches: what taking them one by one, in order, would leave.

    Args:
        owner: Change of each row, by its rank, shape [R].
        members: A vertex that it touches, shape [R].
        wanted: Ranks of the changes to choose from, in increasing order.
        rank_count: Number of ranks.
        vertex_count: Number of vertices.

    Returns:
        Ranks of the chosen ones, in increasing order.
    """
    is_wanted = np.zeros(rank_count, dtype=bool)
    is_wanted[wanted] = True
    chosen: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
    owner, members = owner[is_wanted[owner]], members[is_wanted[owner]]
    while len(owner):
        # A change goes ahead where it is the first at all of its vertices.
        first = np.full(vertex_count, rank_count)
        np.minimum.at(first, members, owner)
        ahead = np.ones(rank_count, dtype=bool)
        ahead[owner[first[members] < owner]] = False
        winners = np.unique(owner[ahead[owner]])
        chosen.append(winners)
        locked = np.zeros(vertex_count, dtype=bool)
        locked[members[ahead[owner]]] = True
        is_wanted[winners] = False
        is_wanted[owner[locked[members]]] = False
        left = is_wanted[owner]
        owner, members = owner[left], members[left]
    return np.sort(np.concatenate(chosen))


def _keeps_orientation(
    points: Points, faces: Faces, a: NDArray[np.int64], b: NDArray[np.int64], place: Points
) -> NDArray[np.bool_]:
    """Whether no face around each edge a-b turns over when both of its ends move to `place` [m], shape [n]."""
    corners_of = sp.csr_matrix(
        (np.ones(faces.size), (faces.reshape(-1), np.repeat(np.arange(len(faces)), 3))), shape=(len(points), len(faces))
    )
    owner, face = _rows((corners_of[a] + corners_of[b]).tocsr())
    around = faces[face]
    has_a, has_b = around == a[owner, None], around == b[owner, None]
    staying = ~(has_a.any(axis=1) & has_b.any(axis=1))
    owner, around, ends = owner[staying], around[staying], (has_a | has_b)[staying]
    corners = points[around]
    moved = np.where(ends[:, :, None], place[owner][:, None], corners)
    turned = (_cross(corners) * _cross(moved)).sum(axis=1) <= 0
    good: NDArray[np.bool_] = np.bincount(owner[turned], minlength=len(a)) == 0
    return good


def _cross(corners: Points) -> Points:
    """Area-weighted normals of triangles given by their corners [F, 3, 3]."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


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
    existing = edge_list(f)
    proper &= ~is_member(np.minimum(c, d) * count + np.maximum(c, d), existing[:, 0] * count + existing[:, 1])
    candidates = np.flatnonzero(proper & (gain > 0))
    candidates = candidates[np.argsort(-gain[candidates], kind="stable")]
    quads = np.stack([a, b, c, d], axis=1)[candidates]
    ranks = np.arange(len(candidates))
    chosen = candidates[_apart(np.repeat(ranks, 4), quads.reshape(-1), ranks, len(ranks), count)]
    f[first[chosen] // 3] = np.stack([c, d, b], axis=1)[chosen]
    f[second[chosen] // 3] = np.stack([d, c, a], axis=1)[chosen]
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
