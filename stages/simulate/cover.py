"""Skin that stands out between the vertices of cloth, covered in the record alone.

Contact keeps vertices of cloth off the skin; where that bulges, as at a breast or a knee, it may stand out of a face
between them by a millimetre or two, which a picture shows as a speck. The record shows such faces moved out over it;
the simulation goes on from its own positions.
"""

from __future__ import annotations

import igl
import numpy as np
from scipy.spatial import cKDTree

from stages.simulate.contact import BodyContact
from stages.simulate.patches import in_box
from stages.simulate.springs import unique_edges

NEAR = 0.003
"""Distance from the skin of a vertex that lies on it: at least one of those whose face it stands out of [m]."""
CLEARANCE = 2e-4
"""How far below the cloth skin is to be [m]: twice the steps in which positions are stored."""
FURTHEST = 0.003
"""Skin further out than this isn't between vertices but beside the cloth; no vertex is moved further either [m]."""
ALIKE = 0.5
"""Least cosine between the normals of skin and of the cloth that lies on it; folded over, cloth shows it its back."""
REACH = 1.2
"""How far from vertices that lie on it skin may be below their faces, over the cloth's mean edge."""
ROUNDS = 6
"""Times, at most, that faces are moved."""


class Cover:
    """Covers the skin that stands out of cloth on it."""

    def __init__(self, contact: BodyContact) -> None:
        own = contact.patches
        layer = np.repeat(own.layer, np.diff(own.start))
        self.contact = contact
        self.garments = [np.ascontiguousarray(own.faces[layer == number], np.int64) for number in np.unique(layer)]
        self.room = np.zeros((len(own.of_vertex), 3))  # kernels launch faster on known arrays
        self.edges, self.vertices, self.edges_of = np.zeros((0, 2), np.int32), np.zeros(0, np.int32), 0
        self.ends = np.zeros((2, 0), np.int32)

    def __call__(self, x: np.ndarray, fixed: np.ndarray, floor: float) -> int:
        """Move vertices of x [N, 3], in place, so that corners and middles of edges of the skin are below the cloth.

        What is `fixed` [N], or hidden in a fold of the body nearer than `floor` [m] to skin, stays; nothing is moved
        as near as that.

        Returns:
            How many vertices were moved.
        """
        contact, body = self.contact, self.contact.body
        if not len(body.faces):
            return 0
        contact.locate(x)
        close = (contact.face >= 0) & (np.abs(contact.distance) < NEAR)
        if not close.any():
            return 0
        still = (fixed > 0) | (contact.distance < floor)
        y = self.room
        np.copyto(y, x)
        for faces in self.garments:
            a, b, c = close[faces.T]
            there = faces[a | b | c]
            vertices = np.unique(there)
            below = self._near(x[vertices[close[vertices]]], REACH * _mean_edge(x, there))
            for _ in range(ROUNDS):
                if len(there) and len(below):
                    there, below = self._move(y, there, below, still)
        way = y - x
        far = np.linalg.norm(way, axis=1)
        moved = far > 0
        if not moved.any():
            return 0
        y[moved] = x[moved] + way[moved] * np.minimum(1.0, FURTHEST / far[moved])[:, None]
        contact.locate(y)
        moved &= contact.distance >= floor
        x[moved] = y[moved]
        return int(moved.sum())

    def _near(self, lying: np.ndarray, reach: float) -> np.ndarray:
        """Points of the skin within `reach` [m] of the points `lying` [K, 3] on it, as the two vertices that each is
        midway between [M, 2]: the same twice for a corner."""
        body = self.contact.body
        if self.edges_of != len(body.faces):
            self.edges, self.edges_of = unique_edges(body.faces)[0], len(body.faces)
            self.vertices, self.ends = np.unique(self.edges), np.ascontiguousarray(self.edges.T)
        if not len(lying):
            return self.edges[:0]
        places, low, high = body.x[self.vertices], lying.min(axis=0) - reach, lying.max(axis=0) + reach
        about = np.flatnonzero(in_box(places, low, high))
        far, _ = cKDTree(lying).query(places[about], distance_upper_bound=reach)
        corners = self.vertices[about[far < reach]]
        chosen = np.zeros(len(body.x), bool)
        chosen[corners] = True
        a, b = self.ends
        return np.concatenate([np.column_stack([corners, corners]), self.edges[chosen[a] & chosen[b]]])

    def _move(
        self, x: np.ndarray, faces: np.ndarray, ends: np.ndarray, still: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Move `faces` [F, 3] of x [N, 3], in place, out over the points of the skin between `ends` [M, 2].

        Each vertex goes along the skin's normals, as far as that point asks for which asks most.

        Returns:
            The faces that moved, and the points below them.
        """
        points = self.contact.body.x[ends].mean(axis=1)
        squared, face, foot = igl.point_mesh_squared_distance(points, x, faces)
        near = np.flatnonzero(squared < FURTHEST**2)
        ends, points, foot, corners = ends[near], points[near], foot[near], faces[face[near]]
        a, b, c = (np.ascontiguousarray(x[corners[:, k]]) for k in range(3))
        up = _unit(np.cross(b - a, c - a))
        height = ((points - foot) * up).sum(axis=1)
        # Beside a border, or beyond a ridge, the way to the nearest point isn't the cloth's normal.
        across = np.abs(height) > 0.7 * np.linalg.norm(points - foot, axis=1) - 1e-9
        out = np.flatnonzero((height > 1e-6 - CLEARANCE) & across)
        normal = self._normals(ends[out])
        cosine = (normal * up[out]).sum(axis=1)
        facing = cosine > ALIKE
        out, normal, cosine = out[facing], normal[facing], cosine[facing]
        if not len(out):
            return faces[:0], ends[:0]
        weights = igl.barycentric_coordinates(foot[out], a[out], b[out], c[out])
        asked = ((height[out] + CLEARANCE) / cosine)[:, None] * weights / (weights**2).sum(axis=1, keepdims=True)
        furthest, way = np.zeros(len(x)), np.zeros_like(x)
        np.maximum.at(furthest, corners[out].ravel(), asked.ravel())
        np.add.at(way, corners[out].ravel(), (weights[:, :, None] * normal[:, None]).reshape(-1, 3))
        moved = np.flatnonzero((furthest > 0) & ~still)
        x[moved] += furthest[moved, None] * _unit(way[moved])
        touched = np.zeros(len(x), bool)
        touched[moved] = True
        return faces[touched[faces].any(axis=1)], ends[touched[corners].any(axis=1)]

    def _normals(self, ends: np.ndarray) -> np.ndarray:
        """Normals of the skin at points midway between `ends` [K, 2], shape [K, 3]."""
        body = self.contact.body
        first, count = body.start[ends.ravel()], np.diff(body.start)[ends.ravel()]
        owner = np.repeat(np.arange(len(first)), count)
        corner = first[owner] + np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        normal = np.zeros((len(first), 3))
        np.add.at(normal, owner, body.face_normal[body.incident[corner] // 3])
        return _unit(normal.reshape(-1, 2, 3).sum(axis=1))


def _mean_edge(x: np.ndarray, faces: np.ndarray) -> float:
    """Mean length of the first edges of faces [F, 3] of x [N, 3] [m]; 0 without any."""
    return float(np.linalg.norm(x[faces[:, 0]] - x[faces[:, 1]], axis=1).mean()) if len(faces) else 0.0


def _unit(v: np.ndarray) -> np.ndarray:
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-12))
