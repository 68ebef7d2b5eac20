"""Fit the layer to a garment: a displacement field that is smooth first and follows the cloth last."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from model.mesh.geometry import vertex_normals
from model.mesh.operators import graph_laplacian
from model.mesh.topology import compact, edge_list
from stages.register.target import Hits, Target

Array = NDArray[np.float64]

ANCHOR = 1e-6
"""Weight that draws displacements to 0 where nothing matches; it keeps the system definite."""


@dataclass(frozen=True, kw_only=True)
class Gate:
    """Which points of the garment count as matches.

    Attributes:
        reach: Largest distance [m].
        turn: Largest angle between the normals of layer and garment [rad].
    """

    reach: float
    turn: float

    def admits(self, hits: Hits, normals: Array, target: Target) -> NDArray[np.bool_]:
        """Matches: near, facing alike, and not at the flange's rim, towards which bare limbs would be dragged."""
        alike = (normals * target.normals[hits.faces]).sum(axis=1) > np.cos(self.turn)
        return np.asarray((hits.distance < self.reach) & alike & ~hits.at_rim)


def fit(
    source: ArrayLike, faces: ArrayLike, target: Target, gate: Gate, coarse: Sequence[float], fine: Sequence[float]
) -> Array:
    """Deforms the layer so that it lies on the garment wherever the two belong together.

    At each stiffness a, coarse to fine: a point c of the garment for each vertex, the gated ones with w = 1, then the
    displacements d from the source that minimise

        sum_i w_i |x_i + d_i - c_i|^2 + a sum_(i, j) |d_i - d_j|^2

    over the layer's edges (i, j): (W + a L) d = W (c - x) with the graph Laplacian L. The parts of the layer that the
    garment leaves bare are carried along smoothly. A dimensionless a smooths over about sqrt(a) edges.

    Args:
        source: Layer [m], shape [N, 3].
        faces: Its triangles, shape [F, 3].
        target: The garment.
        gate: Which matches to trust.
        coarse: Falling values of a for matches alike in position and normal.
        fine: Falling values of a for closest points.

    Returns:
        The fitted layer [m], shape [N, 3]; parts out of the garment's reach stay where they were.

    Source: non-rigid ICP after Amberg et al., Optimal Step Nonrigid ICP Algorithms for Surface Registration (2007),
    with one displacement per vertex instead of an affine map.
    """
    whole = np.array(source, dtype=np.float64)
    local, kept = _within_reach(whole, np.asarray(faces), target, gate.reach)
    start = whole[kept]
    laplacian = graph_laplacian(edge_list(local), len(start))
    moved = start
    for position, a in enumerate((*coarse, *fine)):
        normals = vertex_normals(moved, local)
        hits = target.alike(moved, normals, gate.reach) if position < len(coarse) else target.closest(moved)
        weight = gate.admits(hits, normals, target).astype(np.float64)
        system = sp.csc_matrix(a * laplacian + sp.diags(weight + ANCHOR))
        factor = splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        moved = start + factor.solve(weight[:, None] * (hits.points - start))
    whole[kept] = moved
    return whole


def _within_reach(
    points: Array, faces: NDArray[np.integer], target: Target, reach: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The faces within `reach` of the garment's vertices, renumbered, and their vertices: no other can match."""
    inside = np.isfinite(cKDTree(target.vertices).query(points, distance_upper_bound=reach)[0])
    return compact(faces[inside[faces].all(axis=1)], len(points))
