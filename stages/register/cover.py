"""Decide which of the layer's vertices a garment covers, and bring the edge of that region onto its borders."""

import heapq
from dataclasses import dataclass

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.mesh.geometry import area_vectors, vertex_normals
from model.mesh.topology import border_vertices, component_labels, edge_list
from stages.register.target import Target
from stages.register.untangle import untangle

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SMALL_HOLE = 0.02
"""Bare regions inside the garment below this share of the layer's vertices are gaps in the matching, not openings."""

EAR = 0.05
"""A covered face below this share of the median area is one without area."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Cover:
    """Where each vertex of the layer lies on a garment.

    Attributes:
        mask: Whether the garment covers the vertex, shape [N].
        face: The garment's face, -1 outside the mask, shape [N].
        barycentric: Weights of the face's corners, 0 outside the mask, shape [N, 3].
    """

    mask: Mask
    face: NDArray[np.int32]
    barycentric: NDArray[np.float32]


def cover(fitted: ArrayLike, faces: ArrayLike, target: Target, tolerance: float) -> Cover:
    """Reads correspondences and mask off a fitted layer.

    A vertex is inside if its closest point lies on the garment and not on the flange, near and facing alike. Of each
    edge that crosses a border one end, the nearer first, is then moved onto the border and belongs to the mask, so
    that the covered faces end where the garment ends.

    Args:
        fitted: Fitted layer [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        target: The garment.
        tolerance: Largest distance of an inside vertex from the garment [m].

    Returns:
        Correspondences and mask: one connected region without small holes.
    """
    points, triangles = np.asarray(fitted, dtype=np.float64), np.asarray(faces, dtype=np.int64)
    hits = target.closest(points)
    alike = (vertex_normals(points, triangles) * target.normals[hits.faces]).sum(axis=1) > 0.0
    edges = edge_list(triangles)
    inside = (hits.faces < target.garment_faces) & (hits.distance < tolerance) & alike
    inside = _tidy(inside, edges, border_vertices(triangles, len(points)))
    if not inside.any():
        nothing = np.full(len(points), -1, dtype=np.int32)
        return Cover(mask=inside, face=nothing, barycentric=np.zeros((len(points), 3), dtype=np.float32))
    border_distance, border_index, border_points = igl.point_mesh_squared_distance(
        hits.points, target.vertices, target.border_edges
    )
    snapped = _snap(inside, edges, np.sqrt(border_distance))
    mask = inside | snapped
    leaving = edges[mask[edges[:, 0]] != mask[edges[:, 1]]]
    at_edge = np.zeros_like(mask)
    at_edge[leaving.reshape(-1)] = True
    # An inside vertex whose outer neighbours were all moved onto the border stays inside; one of a filled hole may be
    # nearest to the flange and takes the border, too.
    on_border = (snapped & (at_edge | ~inside)) | (inside & (hits.faces >= target.garment_faces))
    index = np.where(on_border, target.border_faces[border_index], hits.faces)
    place = np.where(on_border[:, None], border_points, hits.points)
    covered = triangles[mask[triangles].all(axis=1)]
    mask &= ~_ears(place, covered, target.normals[index], on_border & ~inside)
    covered = triangles[mask[triangles].all(axis=1)]
    mask &= np.isin(np.arange(len(points)), covered)
    place, index = untangle(place, index, on_border, covered, target)
    barycentric = np.zeros((len(points), 3), dtype=np.float32)
    barycentric[mask] = _weights(place[mask], target.vertices[target.faces[index[mask]]])
    return Cover(mask=mask, face=np.where(mask, index, -1).astype(np.int32), barycentric=barycentric)


def _tidy(inside: Mask, edges: NDArray[np.int64], at_layer_border: Mask) -> Mask:
    """Keeps the largest connected region and fills small holes that do not reach a border of the layer."""
    out = np.zeros_like(inside)
    if not inside.any():
        return out
    labels = _regions(inside, edges)
    out[labels == np.bincount(labels[inside]).argmax()] = True
    out &= inside
    labels = _regions(~out, edges)
    for label in np.unique(labels[~out]):
        region = (labels == label) & ~out
        if region.sum() < SMALL_HOLE * len(out) and not (region & at_layer_border).any():
            out |= region
    return out


def _regions(member: Mask, edges: NDArray[np.int64]) -> NDArray[np.int64]:
    """Component of each vertex in the graph of the edges between members, shape [N]."""
    return component_labels(edges[member[edges].all(axis=1)], len(member))


def _snap(inside: Mask, edges: NDArray[np.int64], border_distance: Array) -> Mask:
    """Picks one end of every edge that leaves the inside, those nearest to the border first, shape [N]."""
    crossing = edges[inside[edges[:, 0]] != inside[edges[:, 1]]]
    links: dict[int, set[int]] = {}
    for a, b in crossing.tolist():
        links.setdefault(a, set()).add(b)
        links.setdefault(b, set()).add(a)
    queue = [(float(border_distance[v]), v) for v in links]
    heapq.heapify(queue)
    snapped = np.zeros_like(inside)
    while queue:
        _, vertex = heapq.heappop(queue)
        if links[vertex]:
            snapped[vertex] = True
            for other in links[vertex]:
                links[other].discard(vertex)
            links[vertex] = set()
    return snapped


def _ears(place: Array, covered: NDArray[np.int64], normals: Array, outside: Mask) -> Mask:
    """Vertices moved onto a border from outside that hold one face alone, without area or turned over, shape [N].

    Three points of a border span such a face where it runs straight or bends inwards.
    """
    signed = 0.5 * (area_vectors(place, covered) * normals[covered].mean(axis=1)).sum(axis=1)
    held = np.bincount(covered.reshape(-1), minlength=len(place))
    flat = np.zeros(len(place), dtype=bool)
    flat[covered[signed < EAR * np.median(signed)]] = True
    return outside & flat & (held == 1)


def _weights(points: Array, corners: Array) -> NDArray[np.float32]:
    """Barycentric weights [Q, 3] of points on triangles given by their corners [Q, 3, 3]; none negative."""
    a, b, p = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    aa, ab, bb = (a * a).sum(1), (a * b).sum(1), (b * b).sum(1)
    pa, pb = (p * a).sum(1), (p * b).sum(1)
    area = np.maximum(aa * bb - ab * ab, 1e-30)
    v, w = (bb * pa - ab * pb) / area, (aa * pb - ab * pa) / area
    weights = np.clip(np.stack([1 - v - w, v, w], axis=1), 0.0, None)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True), dtype=np.float32)
