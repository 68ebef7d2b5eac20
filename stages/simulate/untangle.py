"""Cloth that has passed through cloth, taken apart again: the contour where it crosses is made shorter and shorter.

Volino and Magnenat-Thalmann 2006, "Resolving surface collisions through intersection contour minimization": where an
edge passes through a face, the contour of the crossing goes on in the faces beside the edge. Moving edge and face
against each other along the gradient of its length shrinks it, whichever side was the right one.
"""

from __future__ import annotations

import numpy as np

from stages.simulate.patches import Patches, widened
from stages.simulate.springs import unique_edges
from stages.simulate.untangle_kernels import find_crossings

PACE = 2e-3
"""How far the edge of a crossing is pulled past the face in one step, at most [m]..."""
STRIDE = 0.25
"""... and over its own length."""
EVEN = 0.5
"""Gradient [1] of the contour's length at which it is pulled by 0.7 of that."""
SLANT = 0.1
"""Sine of the least angle of edge and face that the gradient is taken for: along a face it has no end."""


class Crossings:
    """Edges and faces of the cloth that pass through each other.

    Attributes:
        edge, face [K]: Each crossing's edge and face.
        part [N]: 1 for the vertices of those: what they touch tells nothing of the side they ought to be on.
    """

    def __init__(self, patches: Patches, layer: np.ndarray) -> None:
        self.patches, self.layer = patches, layer
        self.wings = opposite_vertices(patches.edges, patches.faces)
        self.count, self.found = np.zeros(len(patches.edges), np.int32), np.zeros((len(patches.edges), 4), np.int32)
        self.part = np.zeros(len(layer), np.int32)
        self.forget()

    def forget(self) -> None:
        """Know of no crossing until they are looked for again."""
        self.edge, self.face = np.zeros(0, np.int64), np.zeros(0, np.int64)

    def find(
        self,
        x: np.ndarray,
        centre: np.ndarray,
        radius: np.ndarray,
        near: np.ndarray,
        others: bool,
        met_count: np.ndarray,
        met: np.ndarray,
    ) -> None:
        """Find those of edges with an end that is `near` [N] other cloth, with faces of the patches that their own met.

        Those with other garments only with `others`. Each face is in a ball of `radius` [F] about its `centre` [F, 3].
        """
        p = self.patches
        while True:
            find_crossings(
                x, p.edges, p.faces, centre, radius, near, self.layer, int(others), p.of_edge, p.start, met_count, met,
                self.count, self.found,
            )  # fmt: skip
            found, self.found = self.found, widened(self.found, self.count)
            if found is self.found:
                break
        self.part[:] = 0
        self.edge = np.repeat(np.arange(len(self.count)), self.count)
        first = np.cumsum(self.count) - self.count
        self.face = self.found[self.edge, np.arange(len(self.edge)) - first[self.edge]].astype(np.int64)
        self.part[p.edges[self.edge]] = 1
        self.part[p.faces[self.face]] = 1

    def ways(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """How what still crosses in `x` [N, 3] ought to move so that the contour gets shorter.

        Returns:
            Vertices [K, 4] of an end of an edge and of the face that the edge passes through, twice for every crossing;
            the unit direction [K, 3] for the end to go relative to the face; and how far in one step [m], shape [K].
        """
        if not len(self.edge):
            return np.zeros((0, 4), np.int32), np.zeros((0, 3)), np.zeros(0)
        ends, corners = self.patches.edges[self.edge], self.patches.faces[self.face]
        still = _passes(x, ends, corners)
        edge, ends, corners = self.edge[still], ends[still], corners[still]
        p = x[ends[:, 0]]
        along = x[ends[:, 1]] - p
        e = _unit(along)
        n = _unit(np.cross(x[corners[:, 1]] - x[corners[:, 0]], x[corners[:, 2]] - x[corners[:, 0]]))
        slant = _dot(e, n)
        slant = np.where(slant < 0, -1.0, 1.0) * np.maximum(np.abs(slant), SLANT)
        gradient = np.zeros_like(p)
        for wing in self.wings[edge].T:
            away = x[wing] - p
            away -= _dot(away, e)[:, None] * e
            line = _unit(np.cross(n, np.cross(e, away)))
            line *= np.sign(_dot(line, away))[:, None]
            gradient += (wing >= 0)[:, None] * (line - (2 * _dot(e, line) / slant)[:, None] * n)
        length = np.linalg.norm(gradient, axis=1)
        pace = np.minimum(PACE, STRIDE * np.linalg.norm(along, axis=1)) * length / np.sqrt(length**2 + EVEN**2)
        vertices = [np.column_stack([end, corners]) for end in ends.T]
        return np.concatenate(vertices), np.tile(_unit(gradient), (2, 1)), np.tile(pace, 2)


def _passes(x: np.ndarray, ends: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Which edges with `ends` [K, 2] pass through the triangles with `corners` [K, 3], shape [K]."""
    p, a = x[ends[:, 0]], x[corners[:, 0]]
    along, u, v = x[ends[:, 1]] - p, x[corners[:, 1]] - a, x[corners[:, 2]] - a
    normal = np.cross(u, v)
    wide, steep = np.maximum(_dot(normal, normal), 1e-30), _dot(normal, along)
    s = _dot(normal, a - p) / np.where(np.abs(steep) < 1e-16, 1e-16, steep)
    hit = p + s[:, None] * along - a
    g, h = _dot(np.cross(hit, v), normal) / wide, _dot(np.cross(u, hit), normal) / wide
    passes: np.ndarray = (s > 0) & (s < 1) & (g > 0) & (h > 0) & (g + h < 1)
    return passes


def opposite_vertices(edges: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """For each of `edges` [E, 2] the vertices opposite to it in the two faces (of `faces` [F, 3]) beside it, or -1."""
    known, of_face = unique_edges(faces)
    order = np.argsort(of_face.ravel(), kind="stable")
    edge, vertex = of_face.ravel()[order], faces.ravel()[order]
    wings = np.full((len(known), 2), -1, np.int64)
    second = np.concatenate([[False], edge[1:] == edge[:-1]])
    wings[edge[~second], 0], wings[edge[second], 1] = vertex[~second], vertex[second]
    wide = int(known.max(initial=0)) + 1
    ends = np.sort(edges, axis=1).astype(np.int64)
    return wings[np.searchsorted(known[:, 0].astype(np.int64) * wide + known[:, 1], ends[:, 0] * wide + ends[:, 1])]


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    product: np.ndarray = np.einsum("ij,ij->i", a, b)
    return product


def _unit(a: np.ndarray) -> np.ndarray:
    length: np.ndarray = np.maximum(np.linalg.norm(a, axis=1, keepdims=True), 1e-20)
    return a / length
