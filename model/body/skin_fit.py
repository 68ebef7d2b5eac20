"""Finds where each point of one body's skin lies on the skin of another, whatever the two topologies are.

Joints take the first body to the second: turned, moved and scaled as a whole, then bent so that every joint meets its
own. Then the skin is pulled onto the other by ever less stiff springs between neighbours, first towards points alike in
place and direction, then towards closest ones.
"""

from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import RBFInterpolator
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from model.body.model import BodyModel
from model.mesh.geometry import area_vectors, face_normals, vertex_normals
from model.mesh.operators import graph_laplacian
from model.mesh.topology import edge_list

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

COARSE = (300.0, 60.0, 12.0, 3.0)
"""Falling stiffness of the rounds that match by place and direction [1]; a stiffness smooths over its root in edges."""

FINE = (1.0, 0.3, 0.1, 0.1)
"""Falling stiffness of the rounds that match by the closest point [1]."""

REACH = 0.12
"""Largest distance of a match [m]."""

TURN = 1.05
"""Largest angle between the two skins' normals at a match [rad]."""

NORMAL_SCALE = 0.1
"""Distance that a difference of 1 between unit normals counts for in the coarse rounds [m]."""

ANCHOR = 1e-6
"""Weight that draws displacements to 0 where nothing matches; it keeps the system definite."""

BARE_JOINTS = (15, 7, 8, 10, 11, 20, 21, 22, 23)
"""Joints of head, feet and hands (SMPL's numbers), whose skin no garment is cut for: it isn't measured."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SkinFit:
    """Where a source's vertices lie on a target, and how well the two skins agree where garments are worn.

    Attributes:
        face: Face of the target at each vertex of the source, shape [V].
        barycentric: Weights of its corners, shape [V, 3].
        pull_m: Largest distance over which a fitted vertex was put onto the target [m].
        miss_mean_m: Mean distance of the target's vertices from the source laid onto it [m].
        miss_m: Their largest one [m].
        folded: Share of the source's faces that look against the target's skin where they lie on it.
    """

    face: Faces
    barycentric: Array
    pull_m: float
    miss_mean_m: float
    miss_m: float
    folded: float


def fit_skin(source: BodyModel, target: BodyModel) -> SkinFit:
    """Lays the skin of one body on that of another, both of mean shape and in the T-pose.

    At each stiffness a, with a point c of the target for each vertex x of the source, the displacements d minimise

        sum_i w_i |x_i + d_i - c_i|^2 + a sum_(i, j) |d_i - d_j|^2

    over the source's edges (i, j), where w is 1 for matches that are near and look alike, else 0.

    Args:
        source: The body whose vertices are placed.
        target: The body that they are placed on.

    Returns:
        The places and their quality.

    Source: non-rigid ICP after Amberg et al., Optimal Step Nonrigid ICP Algorithms for Surface Registration (2007),
    with one displacement per vertex instead of an affine map.
    """
    faces, skin = source.faces.astype(np.int64), target.v_template.astype(np.float64)
    skin_faces = target.faces.astype(np.int64)
    normals = face_normals(skin, skin_faces)
    centres = skin[skin_faces].mean(axis=1)
    like = cKDTree(np.hstack([centres, NORMAL_SCALE * normals]))
    start = joint_warp(source.joint_template, target.joint_template)(source.v_template.astype(np.float64))
    laplacian = graph_laplacian(edge_list(faces), len(start))
    moved = start
    for turn, stiffness in enumerate((*COARSE, *FINE)):
        own = vertex_normals(moved, faces)
        if turn < len(COARSE):
            index = like.query(np.hstack([moved, NORMAL_SCALE * own]))[1]
            # Only across the skin: the face's centre says nothing of where along it the point belongs.
            goal = moved + normals[index] * ((centres[index] - moved) * normals[index]).sum(axis=1, keepdims=True)
        else:
            _, index, goal = igl.point_mesh_squared_distance(np.ascontiguousarray(moved), skin, skin_faces)
        near = np.linalg.norm(goal - moved, axis=1) < REACH
        weight = (near & ((own * normals[index]).sum(axis=1) > np.cos(TURN))).astype(np.float64)
        system = sp.csc_matrix(stiffness * laplacian + sp.diags(weight + ANCHOR))
        factor = splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        moved = start + factor.solve(weight[:, None] * (goal - start))
    squared, face, foot = igl.point_mesh_squared_distance(np.ascontiguousarray(moved), skin, skin_faces)
    corners = [np.ascontiguousarray(skin[skin_faces[face, k]]) for k in range(3)]
    weights = np.clip(igl.barycentric_coordinates(np.ascontiguousarray(foot), *corners), 0.0, None)
    worn, target_worn = dressed(source), dressed(target)
    miss = np.sqrt(igl.point_mesh_squared_distance(skin[target_worn], np.ascontiguousarray(foot), faces)[0])
    looks = (area_vectors(foot, faces) * normals[face][faces].sum(axis=1)).sum(axis=1)
    return SkinFit(
        face=face.astype(np.int64),
        barycentric=weights / weights.sum(axis=1, keepdims=True),
        pull_m=float(np.sqrt(squared[worn].max())),
        miss_mean_m=float(miss.mean()),
        miss_m=float(miss.max()),
        folded=float((looks <= 0)[worn[faces].all(axis=1)].mean()),
    )


def dressed(model: BodyModel) -> NDArray[np.bool_]:
    """Vertices of the skin of trunk, arms and legs, shape [V]."""
    skin = np.zeros(model.vertex_count, dtype=bool)
    skin[model.faces] = True
    return np.asarray(skin & (model.weights[:, list(BARE_JOINTS)].sum(axis=1) < 0.5))


def joint_warp(joints: ArrayLike, goals: ArrayLike) -> "JointWarp":
    """The map of space that takes joints to other joints: a similarity, then the smoothest bending (see `JointWarp`).

    Args:
        joints: Joints [m], shape [K, 3].
        goals: Where they are to be [m], shape [K, 3].

    Returns:
        The map.

    Source: the similarity of least squares, Umeyama (1991), equations 39 to 43.
    """
    a, b = np.asarray(joints, dtype=np.float64), np.asarray(goals, dtype=np.float64)
    centre_a, centre_b = a.mean(axis=0), b.mean(axis=0)
    u, sizes, vt = np.linalg.svd((b - centre_b).T @ (a - centre_a))
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    scale = (sizes * sign).sum() / ((a - centre_a) ** 2).sum()
    linear = scale * (u * sign) @ vt
    shift = centre_b - linear @ centre_a
    moved = a @ linear.T + shift
    return JointWarp(linear, shift, RBFInterpolator(moved, b - moved, kernel="linear"))


@dataclass(frozen=True, eq=False)
class JointWarp:
    """x -> y + b(y) with y = A x + t; b is a sum of |y - y_k| c_k, the biharmonic spline in three dimensions."""

    linear: Array
    """A: turn and scale, shape [3, 3]."""
    shift: Array
    """t [m], shape [3]."""
    bending: RBFInterpolator
    """b [m]."""

    def __call__(self, points: Array) -> Array:
        """Moves points [m], shape [n, 3]."""
        moved = points @ self.linear.T + self.shift
        bent: Array = moved + self.bending(moved)
        return bent
