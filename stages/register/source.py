"""The layer in rest pose, ready to be fitted to a garment."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from model.body import REST_POSE
from model.body.layer import GarmentLayer
from model.mesh.operators import harmonic_fill
from model.mesh.topology import adjacency, border_vertices, edge_list

CROTCH_RINGS = 4
"""Rings of vertices around the inner legs that are smoothed with them: they round off the crotch."""


def rest_layer(layer: GarmentLayer, betas: ArrayLike) -> NDArray[np.float64]:
    """The layer of a shape in the rest frame: rest pose, root joint at the origin, z up [m], shape [N, 3]."""
    return layer.model.pose(betas, REST_POSE[None], np.zeros((1, 3)))[0].astype(np.float64)


def source_surface(layer: GarmentLayer, betas: ArrayLike, topology: str) -> NDArray[np.float64]:
    """The surface to fit to a garment.

    Skirt topology: the new faces between the legs are stretched, and registration wants even ones. So the inner sides
    of the legs, and `CROTCH_RINGS` of vertices around them, are smoothed into a tube (CLOTH3D, section 4.1 and
    Fig. 4b). The hem keeps its height, without which the free border would creep up.

    Args:
        layer: The layer.
        betas: Shape, shape [b].
        topology: "body" or "skirt".

    Returns:
        Vertices in the rest frame [m], shape [N, 3].
    """
    rest = rest_layer(layer, betas)
    if topology != "skirt":
        return rest
    edges = edge_list(layer.skirt_faces)
    links = adjacency(edges, len(rest))
    free = layer.inner_leg.copy()
    for _ in range(CROTCH_RINGS):
        free |= np.asarray(links @ free > 0)
    tube = harmonic_fill(edges, rest, free)
    level = free & ~border_vertices(layer.skirt_faces, len(rest))
    tube[:, 2] = harmonic_fill(edges, rest[:, 2:], level)[:, 0]
    return tube
