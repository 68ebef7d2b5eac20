"""Patches: the faces and edges of a surface in small groups that are near each other at rest."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

FACES = 16
"""Most faces of a patch..."""
PATCHES = 2000
"""... unless that made more patches than this: every search compares each with each."""


class Patches:
    """A cut of a surface into patches.

    Attributes:
        faces [F, 3], edges [E, 2]: The mesh's own, those of a patch behind one another.
        start, edge_start [P + 1]: Where each patch begins in them.
        of_vertex [N], of_edge [E]: The patch of each vertex (of one of its faces) and of each of `edges`.
        layer [P]: Garment of each.
        near_start [P + 1], near: For each patch those that share a vertex with it, ascending, itself included.
    """

    def __init__(
        self, rest: np.ndarray, faces: np.ndarray, edges: np.ndarray | None = None, layer: np.ndarray | None = None
    ) -> None:
        """Cut the mesh of `rest` [N, 3], `faces` [F, 3] and `edges` [E, 2] whose vertices are in `layer` [N]."""
        edges = np.zeros((0, 2), np.int32) if edges is None else edges
        layer = np.zeros(len(rest), np.int32) if layer is None else layer
        most = max(FACES, int(np.ceil(len(faces) / PATCHES)))
        centre = rest[faces].mean(1)
        groups = [
            group
            for number in np.unique(layer)
            for group in _halves(centre, np.flatnonzero(layer[faces[:, 0]] == number), most)
        ]
        groups = _connected(faces, groups)
        order = np.concatenate(groups)
        self.start = np.cumsum([0, *(len(g) for g in groups)]).astype(np.int32)
        self.faces = np.ascontiguousarray(faces[order], np.int32)
        of_face = np.repeat(np.arange(len(groups)), np.diff(self.start))
        self.layer = layer[self.faces[self.start[:-1], 0]].astype(np.int32)
        self.of_vertex = np.zeros(len(rest), np.int32)
        self.of_vertex[self.faces[::-1].ravel()] = np.repeat(of_face[::-1], 3)
        owner = self.of_vertex[edges[:, 0]]
        order = np.argsort(owner, kind="stable")
        self.edges = np.ascontiguousarray(edges[order], np.int32)
        self.of_edge = owner[order]
        self.edge_start = np.searchsorted(self.of_edge, np.arange(len(groups) + 1)).astype(np.int32)
        self._find_near(of_face, len(rest))

    def _find_near(self, of_face: np.ndarray, count: int) -> None:
        patch, vertex = np.repeat(of_face, 3), self.faces.ravel()
        at = np.unique(vertex.astype(np.int64) * len(self.layer) + patch)  # every patch of every vertex
        vertex, patch = at // len(self.layer), at % len(self.layer)
        first = np.searchsorted(vertex, np.arange(count + 1))
        many = np.diff(first)[vertex]
        a = np.repeat(patch, many)
        offset = np.arange(len(a)) - np.repeat(np.cumsum(many) - many, many)
        b = patch[np.repeat(first[vertex], many) + offset]
        pairs = np.unique(a * len(self.layer) + b)
        self.near = (pairs % len(self.layer)).astype(np.int32)
        self.near_start = np.searchsorted(pairs // len(self.layer), np.arange(len(self.layer) + 1)).astype(np.int32)


def widened(found: np.ndarray, count: np.ndarray) -> np.ndarray:
    """`found` [n, width] itself if each row has room for its `count` [n] entries, else a wider array to search anew."""
    most = int(count.max(initial=0))
    return found if most <= found.shape[1] else np.zeros((len(found), int(most * 1.3)), found.dtype)


def _halves(points: np.ndarray, members: np.ndarray, most: int) -> list[np.ndarray]:
    """`members` of `points` [.., 3] in groups of at most `most`, halved along the longest side of their box."""
    order, start = members, np.array([0])
    size = np.array([len(members)])
    while size.max(initial=0) > most:
        at = points[order]
        axis = np.argmax(np.maximum.reduceat(at, start) - np.minimum.reduceat(at, start), axis=1)
        group = np.repeat(np.arange(len(start)), size)
        order = order[np.lexsort((at[np.arange(len(at)), axis[group]], group))]
        start = np.unique(np.concatenate([start, (start + size // 2)[size > most]]))
        size = np.diff(np.append(start, len(order)))
    return np.split(order, start[1:]) if len(members) else []


def _connected(faces: np.ndarray, groups: list[np.ndarray]) -> list[np.ndarray]:
    """`groups` of `faces` (F, 3) cut where they aren't connected: sheets near each other aren't one patch."""
    of_face = np.zeros(len(faces), np.int64)
    for k, group in enumerate(groups):
        of_face[group] = k
    corners = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    face = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort((face, corners[:, 1], corners[:, 0]))
    edge, face = corners[order], face[order]
    twin = np.flatnonzero((edge[1:] == edge[:-1]).all(1))
    a, b = face[twin], face[twin + 1]
    same = of_face[a] == of_face[b]
    graph = sparse.coo_matrix((np.ones(same.sum()), (a[same], b[same])), shape=(len(faces), len(faces)))
    _, part = csgraph.connected_components(graph, directed=False)
    order = np.lexsort((part, of_face))
    return np.split(order, np.flatnonzero(np.diff(part[order])) + 1)


def in_box(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Which `points` (N, 3) lie between the corners `low` and `high` (3,) of a box, shape (N,)."""
    sides = [(x > a) & (x < b) for x, a, b in zip(points.T, low, high)]
    inside: np.ndarray = sides[0] & sides[1] & sides[2]
    return inside
