"""Builds the mesh that garments are registered on: one half, remeshed, mirrored, and closed in two ways.

The half (x >= 0, the person's left) is cut from the body at the neck, the wrist and the ankle and opened along a narrow
strip down the inner leg. Remeshed and mirrored, the two halves share the midline. Closing the strip of each leg gives
the body topology; joining the two legs across the gap, front border with front border and back border with back
border, gives the skirt topology of CLOTH3D, section 4.1. Both use the same vertices.
"""

from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.mesh.geometry import face_areas
from model.mesh.remesh import remesh
from model.mesh.split import split_along
from model.mesh.strip import strip_faces
from model.mesh.topology import border_loops, border_vertices, compact, largest_component_faces

Points = NDArray[np.float64]
Faces = NDArray[np.int64]

HIP, KNEE, ANKLE, FOOT, NECK, HEAD, ELBOW, WRIST, HAND = 1, 4, 7, 10, 12, 15, 18, 20, 22
"""Joints of the left side and the midline that place the cuts (SMPL's numbers)."""

NECK_CUT, WRIST_CUT, ANKLE_CUT = 0.6, 0.35, 0.1
"""Where the cuts lie, as shares of neck -> head, wrist -> hand and ankle -> foot (along the shin)."""

STRIP_WIDTH = 0.87
"""Width of the strip along the inner leg in edge lengths: the height of an equilateral triangle."""


MIDLINE_REACH = 1.5e-3
"""Border vertices this near to x = 0 lie on the midline [m]: more than bodies miss symmetry, less than an edge."""


@dataclass(frozen=True, eq=False, kw_only=True)
class HalfLayer:
    """The left half of the layer on the reference body.

    Attributes:
        vertices: [m], shape [H, 3], y up.
        faces: Shape [F, 3].
        midline: Vertices with x = 0.
        front: The front border of the strip, from the crotch to the ankle.
        back: The back border of the strip, from the crotch to the ankle.
    """

    vertices: Points
    faces: Faces
    midline: NDArray[np.int64]
    front: NDArray[np.int64]
    back: NDArray[np.int64]


@dataclass(frozen=True, eq=False, kw_only=True)
class LayerMesh:
    """The whole layer as rows over the body's vertices.

    Attributes:
        corners: The body's vertices that each vertex lies between, shape [N, 3].
        barycentric: Their weights, shape [N, 3].
        body_faces: Closed legs, shape [F, 3].
        skirt_faces: Joined legs, shape [G, 3].
        core_faces: The faces that both topologies share, shape [C, 3].
        mirror: The vertex opposite each vertex, itself on the midline, shape [N].
        crotch: Height of the crotch [m].
    """

    corners: Faces
    barycentric: Points
    body_faces: NDArray[np.int32]
    skirt_faces: NDArray[np.int32]
    core_faces: NDArray[np.int32]
    mirror: NDArray[np.int64]
    crotch: float


def build_layer_mesh(vertices: ArrayLike, faces: ArrayLike, joints: ArrayLike, vertex_count: int) -> LayerMesh:
    """Builds the layer of a body in the T-pose.

    Args:
        vertices: Reference body [m], shape [V, 3], y up, close to symmetric about x = 0.
        faces: Triangles, shape [F, 3].
        joints: Joints of the reference body [m], shape [24, 3].
        vertex_count: Number of vertices N to aim at.

    Returns:
        The layer; its number of vertices is within a few percent of `vertex_count`.
    """
    points, triangles = np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64)
    half = build_half(points, triangles, np.asarray(joints, dtype=np.float64), vertex_count)
    count = len(half.vertices)
    on_midline = np.zeros(count, dtype=bool)
    on_midline[half.midline] = True
    opposite = np.arange(count)
    opposite[~on_midline] = count + np.arange(count - len(half.midline))
    mirrored = half.vertices[~on_midline] * (-1.0, 1.0, 1.0)
    core = np.vstack([half.faces, opposite[half.faces][:, ::-1]])
    left_strip = strip_faces(half.vertices, half.back, half.front)
    joined = np.vstack([half.vertices, mirrored])
    bridges = np.vstack(
        [
            strip_faces(joined, opposite[half.front], half.front),
            strip_faces(joined, half.back, opposite[half.back]),
        ]
    )
    mirror = np.empty(len(joined), dtype=np.int64)
    mirror[np.arange(count)], mirror[opposite] = opposite, np.arange(count)
    corners, barycentric = closest_corners(joined, points, triangles)
    return LayerMesh(
        corners=corners,
        barycentric=barycentric,
        body_faces=np.vstack([core, left_strip, opposite[left_strip][:, ::-1]]).astype(np.int32),
        skirt_faces=np.vstack([core, bridges]).astype(np.int32),
        core_faces=core.astype(np.int32),
        mirror=mirror,
        crotch=float(half.vertices[half.front[0], 1]),
    )


def build_half(vertices: Points, faces: Faces, joints: Points, vertex_count: int) -> HalfLayer:
    """Cuts, opens and remeshes the left half; see `build_layer_mesh`."""
    points, triangles = vertices, faces
    for normal, origin in _cut_planes(joints):
        points, triangles, _ = _keep(points, triangles, (points - origin) @ normal)
    edge = _edge_length(points, triangles, vertex_count)
    points, triangles = _open_strip(points, triangles, joints, STRIP_WIDTH * edge)
    points, triangles = remesh(points, triangles, edge)
    midline = np.flatnonzero(border_vertices(triangles, len(points)) & (np.abs(points[:, 0]) < MIDLINE_REACH))
    points[midline, 0] = 0.0
    front, back = _strip_borders(points, triangles, midline)
    return HalfLayer(vertices=points, faces=triangles, midline=midline, front=front, back=back)


def closest_corners(queries: Points, vertices: Points, faces: Faces) -> tuple[Faces, Points]:
    """The closest point of a mesh to each query: the face's corners [Q, 3] and the point's weights on them [Q, 3]."""
    _, index, closest = igl.point_mesh_squared_distance(queries, vertices, faces)
    corners = faces[index]
    weights = igl.barycentric_coordinates(
        np.ascontiguousarray(closest), *(np.ascontiguousarray(vertices[corners[:, k]]) for k in range(3))
    )
    weights = np.clip(weights, 0.0, None)
    return corners, weights / weights.sum(axis=1, keepdims=True)


def _cut_planes(joints: Points) -> list[tuple[Points, Points]]:
    """Half-spaces to keep, each its normal and a point: left half, below neck, before wrist, above ankle."""
    neck = joints[HEAD] - joints[NECK]
    forearm = joints[WRIST] - joints[ELBOW]
    shin = _unit(joints[ANKLE] - joints[KNEE])
    below = joints[ANKLE] + ANKLE_CUT * ((joints[FOOT] - joints[ANKLE]) @ shin) * shin
    return [
        (np.array([1.0, 0.0, 0.0]), np.zeros(3)),
        (-_unit(neck * (0.0, 1.0, 1.0)), joints[NECK] + NECK_CUT * neck),
        (-_unit(forearm), joints[WRIST] + WRIST_CUT * (joints[HAND] - joints[WRIST])),
        (-shin, below),
    ]


def _unit(vector: Points) -> Points:
    return np.asarray(vector / np.linalg.norm(vector))


def _keep(points: Points, faces: Faces, field: Points) -> tuple[Points, Faces, NDArray[np.int64]]:
    """The largest connected part of a mesh where a field is positive, cut along its zero line."""
    split_points, split_faces, positive = split_along(points, faces, field)
    kept = split_faces[positive]
    kept = kept[largest_component_faces(kept)]
    new_faces, used = compact(kept, len(split_points))
    return split_points[used], new_faces, used


def _edge_length(points: Points, faces: Faces, vertex_count: int) -> float:
    """Edge [m] at which equilateral triangles cover the half with half of the vertices."""
    area_per_vertex = float(face_areas(points, faces).sum()) / (vertex_count / 2)
    return float(np.sqrt(2.0 / np.sqrt(3.0) * area_per_vertex))


def _open_strip(points: Points, faces: Faces, joints: Points, width: float) -> tuple[Points, Faces]:
    """Removes the strip of the inner leg: within width / 2 of the leg's bones in depth, on their inner side."""
    chain = joints[[ANKLE, KNEE, HIP]]

    def bone(at: Points, axis: int) -> Points:
        return np.asarray(np.interp(at[:, 1], chain[:, 1], chain[:, axis]))

    # Split at the knee first: over each face the bone is then straight, and the strip's edges are exact.
    points, faces, _ = split_along(points, faces, points[:, 1] - joints[KNEE, 1])
    for offset in (-0.5 * width, 0.5 * width):
        points, faces, _ = split_along(points, faces, points[:, 2] - bone(points, 2) - offset, snap=1e-5)
    centre = points[faces].mean(axis=1)
    strip = (
        (np.abs(centre[:, 2] - bone(centre, 2)) < 0.5 * width)
        & (centre[:, 0] < bone(centre, 0))
        & (centre[:, 1] < joints[HIP, 1])
    )
    new_faces, used = compact(faces[~strip], len(points))
    return points[used], new_faces


def _strip_borders(
    points: Points, faces: Faces, midline: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The strip's front and back borders, from the midline down to the ankle.

    The longest border of the half runs: neck, midline, strip, ankle, strip, midline. The strip's borders lie between
    the midline and the two sharpest corners next to the ankle, its lowest vertices.
    """
    loop = border_loops(faces)[0]
    on_midline = np.isin(loop, midline)
    crotch_ends = [i for i in range(len(loop)) if on_midline[i] and not on_midline[(i + 1) % len(loop)]]
    crotch_ends += [i for i in range(len(loop)) if on_midline[i] and not on_midline[i - 1]]
    lowest = sorted(crotch_ends, key=lambda i: points[loop[i], 1])[:2]
    start, end = (lowest[0], lowest[1]) if not on_midline[(lowest[0] + 1) % len(loop)] else (lowest[1], lowest[0])
    run = np.roll(loop, -start)[: (end - start) % len(loop) + 1]
    turn = _turning(points[run])
    low = points[run[1:-1], 1] < points[run, 1].min() + 0.1 * np.ptp(points[run, 1])
    first, second = np.sort(1 + np.flatnonzero(low)[np.argsort(-turn[low], kind="stable")[:2]])
    one, two = run[: first + 1], run[second:][::-1]
    return (one, two) if points[one, 2].mean() > points[two, 2].mean() else (two, one)


def _turning(path: Points) -> Points:
    """Angle by which a path turns at each of its inner points [rad], shape [P - 2]."""
    step = np.diff(path, axis=0)
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    return np.asarray(np.arccos(np.clip((step[1:] * step[:-1]).sum(1), -1.0, 1.0)))
