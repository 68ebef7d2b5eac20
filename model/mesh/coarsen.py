"""Edge contraction to exact vertex counts, never across labels: the clusters behind the pooling of a mesh network."""

from __future__ import annotations

import heapq
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

# Weight of the uniformity term against the quadric. The term is edge length^2 x merged size x mean vertex area, so
# that both are m^4 and a flat region, whose quadrics vanish, still contracts its shortest edges and smallest clusters
# first (CLOTH3D, Pooling: "vertices uniformly distributed in the graph coarsening").
UNIFORMITY = 1e-2

# An edge of a closed manifold has two opposite vertices; contracting one with more pinches the surface.
LINK = 2


def coarsen(
    vertices: NDArray[np.floating],
    faces: NDArray[np.integer],
    edges: NDArray[np.integer],
    labels: NDArray[np.integer],
    counts: Sequence[int],
) -> list[NDArray[np.int32]]:
    """Cluster a mesh's vertices level by level through quadric edge contraction, each label apart.

    Contracted is the edge with the least quadric error at the merged centroid (Garland and Heckbert, 1997) plus a
    uniformity term; edges between two labels never are. The link condition holds while enough edges satisfy it;
    after that it is dropped, since the clusters matter here and not the coarse surface.

    Args:
        vertices: Positions [m], shape (N, 3).
        faces: Triangles, shape (F, 3); they give the quadrics.
        edges: Vertex pairs that may be contracted, shape (E, 2); usually the edges of `faces`, or those it shares with
            a second topology, so that every cluster is connected under both.
        labels: Segment of each vertex, shape (N,).
        counts: Vertices to keep at each coarser level, decreasing; the last is at least the number of labels.

    Returns:
        One map a level, fine vertex -> coarse vertex, shape (vertices of the finer level,).

    Raises:
        ValueError: If a count cannot be reached, because a label is not connected along `edges`.
    """
    contraction = _Contraction(np.asarray(vertices, np.float64), faces, edges, np.asarray(labels))
    maps: list[NDArray[np.int32]] = []
    fine = list(range(len(vertices)))
    for count in counts:
        contraction.reduce_to(count)
        kept = np.flatnonzero(contraction.alive)
        number = np.full(len(vertices), -1, np.int32)
        number[kept] = np.arange(len(kept), dtype=np.int32)
        maps.append(number[[contraction.root(vertex) for vertex in fine]])
        fine = kept.tolist()
    return maps


class _Contraction:
    """State of one run of contractions: clusters, their quadrics and neighbours, and the queue of candidate edges."""

    def __init__(
        self,
        vertices: NDArray[np.float64],
        faces: NDArray[np.integer],
        edges: NDArray[np.integer],
        labels: NDArray[np.integer],
    ) -> None:
        count = len(vertices)
        quadrics, area = _vertex_quadrics(vertices, faces)
        self.labels = labels.tolist()
        self.position = vertices.tolist()
        self.quadric = quadrics.tolist()
        self.size = [1] * count
        self.parent = list(range(count))
        self.alive = np.ones(count, bool)
        self.remaining = count
        self.uniformity = UNIFORMITY * area / count
        self.neighbours: list[set[int]] = [set() for _ in range(count)]
        for a, b in edges.tolist():
            self.neighbours[a].add(b)
            self.neighbours[b].add(a)
        self.version = [0] * count
        self.queue: list[tuple[float, int, int, int, int]] = []
        self.deferred: list[tuple[float, int, int, int, int]] = []
        for a in range(count):
            for b in self.neighbours[a]:
                if a < b:
                    self.push(a, b)

    def root(self, vertex: int) -> int:
        """The living vertex that `vertex` was merged into."""
        while self.parent[vertex] != vertex:
            vertex = self.parent[vertex]
        return vertex

    def merged(self, a: int, b: int) -> tuple[float, float, float]:
        """Centroid of the union of two clusters [m]."""
        share = self.size[a] / (self.size[a] + self.size[b])
        p, q = self.position[a], self.position[b]
        return (
            share * p[0] + (1 - share) * q[0],
            share * p[1] + (1 - share) * q[1],
            share * p[2] + (1 - share) * q[2],
        )

    def push(self, a: int, b: int) -> None:
        """Queue the edge (a, b) at its present cost, unless it joins two labels."""
        if self.labels[a] != self.labels[b]:
            return
        if a > b:
            a, b = b, a
        x, y, z = self.merged(a, b)
        q = [s + t for s, t in zip(self.quadric[a], self.quadric[b])]
        error = (
            q[0] * x * x + q[4] * y * y + q[7] * z * z + q[9]
            + 2 * (q[1] * x * y + q[2] * x * z + q[3] * x + q[5] * y * z + q[6] * y + q[8] * z)
        )  # fmt: skip
        p, r = self.position[a], self.position[b]
        length2 = (p[0] - r[0]) ** 2 + (p[1] - r[1]) ** 2 + (p[2] - r[2]) ** 2
        cost = error + self.uniformity * length2 * (self.size[a] + self.size[b])
        heapq.heappush(self.queue, (cost, a, b, self.version[a], self.version[b]))

    def reduce_to(self, count: int) -> None:
        """Contract the cheapest edges until `count` vertices remain."""
        relaxed = False
        while self.remaining > count:
            if not self.queue:
                if relaxed:
                    raise ValueError(
                        f"coarsen: {self.remaining} vertices are left and none may merge, wanted {count}; "
                        "every label must be connected along the given edges"
                    )
                self.queue, self.deferred, relaxed = self.deferred, [], True
                heapq.heapify(self.queue)
                continue
            entry = heapq.heappop(self.queue)
            _, a, b, version_a, version_b = entry
            if self.version[a] != version_a or self.version[b] != version_b:
                continue
            if not relaxed and len(self.neighbours[a] & self.neighbours[b]) > LINK:
                self.deferred.append(entry)
                continue
            self.contract(a, b)
        self.queue.extend(self.deferred)
        heapq.heapify(self.queue)
        self.deferred = []

    def contract(self, a: int, b: int) -> None:
        """Merge b into a and queue a's edges at their new cost."""
        self.position[a] = list(self.merged(a, b))
        self.quadric[a] = [s + t for s, t in zip(self.quadric[a], self.quadric[b])]
        self.size[a] += self.size[b]
        self.parent[b] = a
        self.alive[b] = False
        self.remaining -= 1
        around = self.neighbours[b]
        around.discard(a)
        self.neighbours[a].discard(b)
        for vertex in around:
            self.neighbours[vertex].discard(b)
            self.neighbours[vertex].add(a)
        self.neighbours[a] |= around
        self.version[a] += 1
        self.version[b] += 1
        for vertex in sorted(self.neighbours[a]):
            self.push(a, vertex)


def _vertex_quadrics(vertices: NDArray[np.float64], faces: NDArray[np.integer]) -> tuple[NDArray[np.float64], float]:
    """Area-weighted plane quadrics summed at the vertices, upper triangle (N, 10), and the whole area [m^2]."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    double_area = np.linalg.norm(normal, axis=1)
    normal /= np.maximum(double_area, 1e-20)[:, None]
    plane = np.concatenate([normal, -np.sum(normal * a, axis=1, keepdims=True)], axis=1)
    rows, columns = np.triu_indices(4)
    quadric = plane[:, rows] * plane[:, columns] * (0.5 * double_area)[:, None]
    total = np.zeros((len(vertices), 10))
    np.add.at(total, faces.ravel(), np.repeat(quadric, 3, axis=0))
    return total, float(0.5 * double_area.sum())
