"""The layer's 21 segments, one vertex each at the coarsest level of the network, and its inner legs."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components

from model.mesh.topology import adjacency, edge_list

HIP, KNEE, ANKLE, SPINE1, SPINE2, SHOULDER, ELBOW, WRIST = 1, 4, 7, 3, 6, 16, 18, 20
LEG_JOINTS, ARM_JOINTS = (1, 4, 7, 10), (16, 18, 20, 22)
"""Joints of the left side (SMPL's numbers)."""

SEGMENT_COUNT = 21
MIDLINE_SEGMENTS = ("chest", "upper back", "waist front", "waist back", "hips")
SIDED_SEGMENTS = (
    "upper arm",
    "elbow",
    "forearm",
    "outer thigh",
    "inner front thigh",
    "inner back thigh",
    "shin",
    "hem",
)

ARM_CUTS = (0.6, 1.35)
"""Where the elbow segment begins and ends: 0 at the shoulder, 1 at the elbow, 2 at the wrist; sleeves end there."""

LEG_CUTS = (1.0, 1.6)
"""Where the shin and the hem begin: 0 at the hip, 1 at the knee, 2 at the ankle."""

INNER_THIGH = np.deg2rad(75.0)
"""Half width of the inner thigh about the leg's bone [rad]."""

WAIST = (0.45, 0.5)
"""The waist's ends: a share of pelvis -> first spine joint below, of first -> second spine joint above."""


def leg_coordinates(points: ArrayLike, joints: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where points are along and around the left leg.

    Args:
        points: Points on the left half [m], T-pose, y up, shape [P, 3].
        joints: Joints [m], shape [24, 3].

    Returns:
        Along: 0 at the height of the hip, 1 of the knee, 2 of the ankle, continued beyond, shape [P]. Around: angle
        about the bone [rad], 0 towards the other leg, positive to the front, shape [P].
    """
    x, chain = np.asarray(points, dtype=np.float64), np.asarray(joints)[[HIP, KNEE, ANKLE]]
    along = _along(-x[:, 1], -chain[:, 1])
    up = chain[::-1]
    bone_x, bone_z = np.interp(x[:, 1], up[:, 1], up[:, 0]), np.interp(x[:, 1], up[:, 1], up[:, 2])
    return along, np.arctan2(x[:, 2] - bone_z, bone_x - x[:, 0])


def segment_labels(
    points: ArrayLike, joints: ArrayLike, weights: ArrayLike, mirror: ArrayLike, core_faces: ArrayLike
) -> NDArray[np.int32]:
    """Labels the layer by region: 5 segments across the midline, then 8 on the left and the same 8 on the right.

    Regions whose offsets vary most (waist, sleeve ends, inner thighs, hem) get the smaller segments (CLOTH3D, section
    4.2, Pooling).

    Args:
        points: Layer of the reference body [m], T-pose, y up, shape [N, 3].
        joints: Its joints [m], shape [24, 3].
        weights: Its skinning weights, shape [N, 24].
        mirror: The vertex opposite each vertex, shape [N].
        core_faces: Faces that the body and the skirt topology share, shape [C, 3].

    Returns:
        Labels from 0 to 20, each connected through edges of `core_faces` and so under both topologies, shape [N].

    Raises:
        ValueError: A segment is empty.
    """
    x, j, w = np.asarray(points, dtype=np.float64), np.asarray(joints), np.asarray(weights)
    opposite = np.asarray(mirror)
    left = x[:, 0] >= 0
    flipped = np.where(left, np.arange(len(x)), opposite)
    x, w = x[flipped], w[flipped]
    sided = _sided_labels(x, j, w)
    label = np.where(sided >= 0, sided + len(MIDLINE_SEGMENTS), _midline_labels(x, j))
    right = ~left & (sided >= 0)
    label[right] += len(SIDED_SEGMENTS)
    return _connected(label, core_faces)


def inner_leg_vertices(points: ArrayLike, joints: ArrayLike, mirror: ArrayLike, crotch: float) -> NDArray[np.bool_]:
    """Vertices on the inner half of the legs, which move when the legs are joined to a skirt.

    Args:
        points: Layer of the reference body [m], T-pose, y up, shape [N, 3].
        joints: Its joints [m], shape [24, 3].
        mirror: The vertex opposite each vertex, shape [N].
        crotch: Height of the crotch [m].

    Returns:
        Shape [N].
    """
    x = np.asarray(points, dtype=np.float64)
    x = x[np.where(x[:, 0] >= 0, np.arange(len(x)), np.asarray(mirror))]
    around = leg_coordinates(x, joints)[1]
    return np.asarray((np.abs(around) < np.pi / 2) & (x[:, 1] < crotch))


def _along(value: NDArray[np.float64], knots: NDArray[np.float64]) -> NDArray[np.float64]:
    """0, 1, 2 at the three increasing knots, linear between them and beyond."""
    first, second = (value - knots[0]) / (knots[1] - knots[0]), 1 + (value - knots[1]) / (knots[2] - knots[1])
    return np.where(value < knots[1], first, second)


def _sided_labels(x: NDArray[np.float64], j: NDArray[np.float64], w: NDArray[np.float64]) -> NDArray[np.int64]:
    """Index into `SIDED_SEGMENTS` for limbs, -1 for the trunk."""
    label = np.full(len(x), -1)
    arm, leg = w[:, ARM_JOINTS].sum(axis=1) > 0.5, w[:, LEG_JOINTS].sum(axis=1) > 0.5
    reach = _along(x[:, 0], j[[SHOULDER, ELBOW, WRIST], 0])
    label[arm] = np.digitize(reach[arm], ARM_CUTS)
    along, around = leg_coordinates(x, j)
    thigh = np.where(np.abs(around) > INNER_THIGH, 3, np.where(around > 0, 4, 5))
    label[leg] = np.where(along < LEG_CUTS[0], thigh, np.where(along < LEG_CUTS[1], 6, 7))[leg]
    return label


def _midline_labels(x: NDArray[np.float64], j: NDArray[np.float64]) -> NDArray[np.int64]:
    """Index into `MIDLINE_SEGMENTS` by height, front and back split through hips and shoulders."""
    low = WAIST[0] * j[SPINE1, 1] + (1 - WAIST[0]) * j[0, 1]
    high = WAIST[1] * j[SPINE2, 1] + (1 - WAIST[1]) * j[SPINE1, 1]
    middle = np.interp(x[:, 1], j[[HIP, SHOULDER], 1], j[[HIP, SHOULDER], 2])
    back = (x[:, 2] < middle).astype(np.int64)
    return np.where(x[:, 1] > high, back, np.where(x[:, 1] > low, 2 + back, 4))


def _connected(label: NDArray[np.int64], core_faces: ArrayLike) -> NDArray[np.int32]:
    """Gives islands of a label to the segments around them."""
    links = adjacency(edge_list(core_faces), len(label))
    edges = np.stack(links.nonzero(), axis=1)
    out = label.copy()
    same = adjacency(edges[out[edges[:, 0]] == out[edges[:, 1]]], len(out))
    _, component = connected_components(same, directed=False)
    size = np.bincount(component)
    for segment in range(SEGMENT_COUNT):
        member = out == segment
        if not member.any():
            raise ValueError(f"segment {segment} of {SEGMENT_COUNT} is empty: the body's joints do not fit its surface")
        parts = np.unique(component[member])
        out[member & (component != parts[size[parts].argmax()])] = -1
    while (out < 0).any():
        votes = np.stack([links @ (out == s) for s in range(SEGMENT_COUNT)], axis=1)
        ready = (out < 0) & (votes.max(axis=1) > 0)
        out[ready] = votes[ready].argmax(axis=1)
    return out.astype(np.int32)
