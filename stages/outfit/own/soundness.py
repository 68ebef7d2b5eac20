"""Whether a mesh can be cloth: one manifold, oriented, open surface of proper triangles that does not meet itself."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from model.mesh.geometry import edge_lengths, face_areas
from model.mesh.intersection import self_intersecting_faces
from model.mesh.topology import border_loops, compact, component_labels, edge_list, edges_with_counts
from stages.outfit.own.obj import ObjMesh
from stages.spec import DataError

MOST_VERTICES = 100_000
"""Vertices of a garment at most: beyond that simulation takes days and more memory than there is."""

FLATTEST = 1.0
"""Smallest angle of a triangle [degrees]; flatter ones have no direction to bend about."""

COARSEST = 0.06
"""Mean edge above which a garment cannot hang as cloth [m]."""

FINEST = 0.001
"""Mean edge below which a garment is not simulated in any sensible time [m]."""

Array = NDArray[np.float64]
Faces = NDArray[np.int64]


def sound_topology(mesh: ObjMesh, file: str) -> ObjMesh:
    """Checks all of a mesh that does not depend on its unit.

    Args:
        mesh: The mesh as read.
        file: Name of the file, for messages.

    Returns:
        The mesh without vertices that no face uses; the others in their order.

    Raises:
        DataError: What is wrong, where, and what to do; one line.
    """
    _finite(mesh, file)
    _proper_faces(mesh, file)
    faces, kept = compact(mesh.faces, len(mesh.vertices))
    mesh = replace(mesh, vertices=mesh.vertices[kept], faces=faces, vertex_lines=mesh.vertex_lines[kept])
    if len(kept) > MOST_VERTICES:
        raise DataError(f"{file}: {len(kept)} vertices, at most {MOST_VERTICES} can be simulated; simplify the mesh")
    _manifold(mesh, file)
    _one_piece(mesh, file)
    if not border_loops(faces):
        raise DataError(
            f"{file}: the surface is closed, it has no opening for the body; a garment is a single layer of cloth: "
            "delete the inner or outer shell, or open neck, sleeves and hem"
        )
    return mesh


def sound_triangles(vertices: Array, mesh: ObjMesh, file: str) -> None:
    """Checks the triangles of a mesh in metres, and that it does not pass through itself.

    Args:
        vertices: Positions [m], shape [N, 3].
        mesh: The mesh.
        file: Name of the file, for messages.

    Raises:
        DataError: What is wrong, where, and what to do; one line.
    """
    faces = mesh.faces
    mean = float(edge_lengths(vertices, edge_list(faces)).mean())
    if not FINEST <= mean <= COARSEST:
        remedy = "subdivide or remesh" if mean > COARSEST else "simplify"
        raise DataError(
            f"{file}: edges are {mean * 1e3:.3g} mm long in the mean, must be from {FINEST * 1e3:g} to "
            f"{COARSEST * 1e3:g} mm; {remedy} the mesh to about 10 mm"
        )
    angle = _smallest_angles(vertices, faces)
    flat = np.flatnonzero(angle < FLATTEST)
    if len(flat):
        worst = flat[angle[flat].argmin()]
        raise DataError(
            f"{file}: line {mesh.face_lines[worst]}: a degenerate triangle, its smallest angle is "
            f"{angle[worst]:.2g} degrees, must be >= {FLATTEST:g}; {len(flat)} of {len(faces)} triangles "
            "are so: merge vertices that lie together, or remesh"
        )
    crossing = self_intersecting_faces(vertices, faces)
    if len(crossing):
        one, other = mesh.face_lines[crossing[0]]
        raise DataError(
            f"{file}: the garment passes through itself at {len(crossing)} pairs of triangles, first at lines {one} "
            f"and {other}; pull the layers apart"
        )


def _finite(mesh: ObjMesh, file: str) -> None:
    bad = np.flatnonzero(~np.isfinite(mesh.vertices).all(axis=1))
    if len(bad):
        x = ", ".join(f"{value:g}" for value in mesh.vertices[bad[0]])
        raise DataError(
            f"{file}: line {mesh.vertex_lines[bad[0]]}: vertex {bad[0] + 1} is ({x}), must be finite; {len(bad)} of "
            f"{len(mesh.vertices)} vertices are not: export it again"
        )


def _proper_faces(mesh: ObjMesh, file: str) -> None:
    a, b, c = mesh.faces.T
    bad = np.flatnonzero((a == b) | (b == c) | (c == a))
    if len(bad):
        raise DataError(
            f"{file}: line {mesh.face_lines[bad[0]]}: a degenerate face, it names a vertex twice; {len(bad)} triangles "
            "are so: remove them"
        )


def _manifold(mesh: ObjMesh, file: str) -> None:
    """No edge has three faces, neighbours are oriented alike, and the faces at a vertex form one fan."""
    faces = mesh.faces
    edges, counts = edges_with_counts(faces)
    if counts.max() > 2:
        a, b = edges[counts.argmax()]
        raise DataError(
            f"{file}: not manifold: {counts.max()} faces meet at the edge from line {mesh.vertex_lines[a]} to "
            f"{mesh.vertex_lines[b]}, at most 2 can; {(counts > 2).sum()} edges are so: separate the layers there"
        )
    half = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    codes = half[:, 0] * len(mesh.vertices) + half[:, 1]
    order = np.argsort(codes, kind="stable")
    twice = np.flatnonzero(codes[order[1:]] == codes[order[:-1]])
    if len(twice):
        one, other = mesh.face_lines[order[[twice[0], twice[0] + 1]] // 3]
        raise DataError(
            f"{file}: not oriented: the faces of lines {one} and {other} look to opposite sides; {len(twice)} edges "
            "are so: recalculate the normals outside"
        )
    fans = _fans(faces, len(mesh.vertices))
    if fans.max() > 1:
        v = int(fans.argmax())
        raise DataError(
            f"{file}: not manifold: {fans[v]} parts of the surface touch in the single vertex {v + 1}, line "
            f"{mesh.vertex_lines[v]}; {(fans > 1).sum()} vertices are so: split them, or close the gap"
        )


def _fans(faces: Faces, count: int) -> Faces:
    """How many separate fans of faces there are around each vertex, shape [N]."""
    corners = np.arange(3 * len(faces)).reshape(-1, 3)
    # Each half-edge as (edge, its two corners); the faces at an edge join their corners at both of its ends.
    start, end = corners[:, [0, 1, 2]].reshape(-1), corners[:, [1, 2, 0]].reshape(-1)
    a, b = faces.reshape(-1)[start], faces.reshape(-1)[end]
    codes = np.minimum(a, b) * count + np.maximum(a, b)
    order = np.argsort(codes, kind="stable")
    pair = np.flatnonzero(codes[order[1:]] == codes[order[:-1]])
    one, two = order[pair], order[pair + 1]
    # Neighbours are oriented alike, so that one's start is the other's end.
    rows, columns = np.concatenate([start[one], end[one]]), np.concatenate([end[two], start[two]])
    links = sp.coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(corners.size, corners.size))
    fan = connected_components(links, directed=False)[1]
    owner = np.unique(np.stack([faces.reshape(-1), fan], axis=1), axis=0)[:, 0]
    return np.bincount(owner, minlength=count)


def _one_piece(mesh: ObjMesh, file: str) -> None:
    labels = component_labels(edge_list(mesh.faces), len(mesh.vertices))
    count = int(labels.max()) + 1
    if count > 1:
        sizes = np.sort(np.bincount(labels))[::-1]
        together = len(mesh.vertices) - len(np.unique(mesh.vertices, axis=0))
        remedy = (
            f"{together} vertices lie exactly on others: merge them" if together else "join them, or keep the largest"
        )
        raise DataError(
            f"{file}: {count} separate pieces, of {', '.join(map(str, sizes[:4]))}{' ...' if count > 4 else ''} "
            f"vertices, a garment must be one; {remedy}"
        )


def _smallest_angles(vertices: Array, faces: Faces) -> Array:
    """Smallest angle of each triangle [degrees], 0 where it has no area, shape [F]."""
    corner = vertices[faces]
    twice_area = 2.0 * face_areas(vertices, faces)
    angles = []
    for k in range(3):
        u, v = corner[:, (k + 1) % 3] - corner[:, k], corner[:, (k + 2) % 3] - corner[:, k]
        angles.append(np.arctan2(twice_area, (u * v).sum(axis=1)))
    smallest: Array = np.degrees(np.min(angles, axis=0))
    return np.where(twice_area > 0, smallest, 0.0)
