"""From offsets and a mask over the layer to a garment's own mesh (CLOTH3D supplement, Post-processing)."""

from __future__ import annotations

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.mesh.geometry import face_normals
from model.mesh.topology import (
    adjacency,
    border_halfedges,
    compact,
    component_labels,
    edge_list,
    largest_component_faces,
)

# Islands and gaps of the mask with fewer vertices than this are noise.
SMALLEST_PATCH = 60
# Rounds of averaging the mask over neighbours; the layer's edges are 1 cm, so that these reach some 2 cm.
MASK_ROUNDS = 6
# "Empirically, 10 iterations are more than enough."
BORDER_ROUNDS = 10
# Distance from the skin at which vertices inside the body are put [m]. The simulated cloth keeps 2 mm; here
# whole triangles of 1 cm edges must clear a curved body.
CLEARANCE = 4e-3
LIFT_ROUNDS = 3
# Rounds of averaging that carry a lift into the surroundings, about one edge of 1 cm each.
LIFT_SPREAD = 4


def clean_mask(mask: NDArray[np.bool_], faces: NDArray[np.integer]) -> NDArray[np.bool_]:
    """The mask (N,) with an even border, its holes filled and its small islands removed.

    Averaging over the neighbours and taking the majority evens out the border and closes thin gaps.
    """
    edges = edge_list(faces)
    average = _neighbour_average(edges, len(mask))
    share = mask.astype(np.float64)
    for _ in range(MASK_ROUNDS):
        share = average @ share
    cleaned = share >= 0.5
    opening = np.zeros(len(mask), bool)
    opening[border_halfedges(faces)] = True
    for value in (False, True):
        inner = edges[(cleaned[edges] == value).all(axis=1)]
        labels = component_labels(inner, len(mask))
        drop = np.bincount(labels) < SMALLEST_PATCH
        if not value:
            # Skin shows at neck, arms and legs, all of which lead to a border of the layer; anything else is a hole.
            drop |= np.bincount(labels, opening) == 0
        cleaned[drop[labels] & (cleaned == value)] = not value
    return cleaned


def garment_mesh(
    positions: NDArray[np.floating], mask: NDArray[np.bool_], faces: NDArray[np.integer]
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """The garment that the layer's vertices form where the mask holds.

    Args:
        positions: Layer vertices with their offsets added [m], shape (N, 3).
        mask: Which vertices the garment covers, as predicted, shape (N,).
        faces: The topology of the garment's type, shape (F, 3).

    Returns:
        Vertices [m] (M, 3) and faces (G, 3) of the largest connected piece, its borders smoothed.

    Raises:
        ValueError: If no face lies in the mask.
    """
    worn = faces[clean_mask(mask, faces)[faces].all(axis=1)]
    if not len(worn):
        raise ValueError("garment_mesh: the mask covers no face of the layer; the code decodes to no garment")
    worn = worn[largest_component_faces(worn)]
    own_faces, kept = compact(worn, len(positions))
    vertices = smooth_borders(np.asarray(positions, np.float64)[kept], own_faces, BORDER_ROUNDS)
    return vertices.astype(np.float32), own_faces.astype(np.int32)


def smooth_borders(vertices: NDArray[np.float64], faces: NDArray[np.integer], rounds: int) -> NDArray[np.float64]:
    """Averages each border vertex with its neighbours along the border, again and again.

    The supplement multiplies by "a normalized Laplacian" that links border vertices only. Taken literally that gives
    differential coordinates, not positions; what smooths is the border's adjacency with self, its rows summing to one.
    """
    border = border_halfedges(faces)
    around = adjacency(border, len(vertices))
    touched = np.unique(border)
    rows = (around + sp.identity(len(vertices), format="csr"))[touched]
    average = sp.diags(1.0 / np.asarray(rows.sum(axis=1)).ravel()) @ rows
    smoothed = vertices.copy()
    for _ in range(rounds):
        smoothed[touched] = average @ smoothed
    return smoothed


def lift_out(
    vertices: NDArray[np.floating],
    faces: NDArray[np.integer],
    body: NDArray[np.floating],
    body_faces: NDArray[np.integer],
) -> tuple[NDArray[np.float32], float]:
    """Moves cloth that is inside the body, or too close to the skin, to `CLEARANCE` outside the nearest skin.

    The collision loss only makes such vertices rare: a decoder knows no body exactly. What moves takes its
    surroundings along, so that no crease marks the place.

    Args:
        vertices: Garment [m], shape (M, 3).
        faces: Its triangles, shape (F, 3).
        body: Body [m], closed, shape (V, 3).
        body_faces: Its triangles, shape (G, 3).

    Returns:
        The moved vertices (M, 3), and the share of vertices that was inside.
    """
    points, skin = np.array(vertices, np.float64), np.ascontiguousarray(body, np.float64)
    triangles = np.ascontiguousarray(body_faces, np.int64)
    normals = face_normals(skin, triangles)
    average = _neighbour_average(edge_list(faces), len(points))
    share = 0.0
    for turn in range(LIFT_ROUNDS):
        square, face, nearest = igl.point_mesh_squared_distance(points, skin, triangles)
        inside = igl.fast_winding_number(skin, triangles, points) > 0.5
        if turn == 0:
            share = float(inside.mean())
        low = inside | (square < CLEARANCE**2)
        lift = np.where(low[:, None], nearest + CLEARANCE * normals[face] - points, 0.0)
        spread = lift
        for _ in range(LIFT_SPREAD if turn < LIFT_ROUNDS - 1 else 0):
            spread = np.where(low[:, None], lift, average @ spread)
        points += spread
    return points.astype(np.float32), share


def _neighbour_average(edges: NDArray[np.integer], count: int) -> sp.csr_matrix:
    """Matrix (count, count) that averages each vertex with its neighbours."""
    rows = adjacency(edges, count) + sp.identity(count, format="csr")
    return sp.diags(1.0 / np.asarray(rows.sum(axis=1)).ravel()) @ rows
