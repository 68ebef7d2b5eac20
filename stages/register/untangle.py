"""Turn over the few registered faces that face the wrong way."""

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.mesh.geometry import area_vectors
from model.mesh.topology import adjacency, edge_list
from stages.register.target import Target

Array = NDArray[np.float64]

PASSES = 12


def untangle(
    points: Array, index: NDArray[np.int64], on_border: NDArray[np.bool_], faces: NDArray[np.int64], target: Target
) -> tuple[Array, NDArray[np.int64]]:
    """Evens out the vertices around registered faces that face against the garment, keeping them on it.

    Such faces come from creases (between the thighs) and from slivers along a border. Their vertices move to the mean
    of their neighbours and back to the closest point: inner ones of the garment, border ones of its border.

    Args:
        points: Registered vertices on the garment [m], shape [N, 3].
        index: The garment's face of each vertex, shape [N].
        on_border: Whether a vertex was placed on a border, shape [N].
        faces: Registered faces, shape [F, 3].
        target: The garment.

    Returns:
        New points [N, 3] and faces [N]; as given if nothing was turned.
    """
    place, where = points.copy(), index.copy()
    edges = edge_list(faces)
    everywhere = adjacency(edges, len(points))
    along = adjacency(edges[on_border[edges].all(axis=1)], len(points))
    for _ in range(PASSES):
        normals = target.normals[where[faces]].sum(axis=1)
        turned = (area_vectors(place, faces) * normals).sum(axis=1) <= 0
        if not turned.any():
            break
        around = np.zeros(len(points), dtype=bool)
        around[faces[turned]] = True
        inner, border = np.flatnonzero(around & ~on_border), np.flatnonzero(around & on_border)
        if len(inner):
            hits = target.closest(_mean(everywhere, place, inner))
            own = hits.faces < target.garment_faces
            place[inner[own]], where[inner[own]] = hits.points[own], hits.faces[own]
        if len(border):
            goal = 0.5 * (place[border] + _mean(along, place, border))
            _, edge, nearest = igl.point_mesh_squared_distance(goal, target.vertices, target.border_edges)
            place[border], where[border] = nearest, target.border_faces[edge]
    return place, where


def _mean(links: sp.csr_matrix, values: Array, rows: NDArray[np.int64]) -> Array:
    """Mean of the neighbours' values, a vertex without any keeps its own, shape [R, D]."""
    part = links[rows]
    count = np.asarray(part.sum(axis=1)).reshape(-1, 1)
    return np.where(count > 0, (part @ values) / np.maximum(count, 1.0), values[rows])
