"""Contact of cloth with cloth: self-collision, and one garment over another."""

from __future__ import annotations

from typing import Any

import numpy as np

from stages.simulate.body_motion import incident_corners
from stages.simulate.grid import Grid
from stages.simulate.pair_kernels import compact_pairs, gather_pairs, move_parted, part_pairs, press_pairs, write_pairs
from stages.simulate.pair_normals import cloth_normals
from stages.simulate.pair_search import edge_spheres, face_spheres, find_edge_edges, find_vertex_faces, mark_close

SHOVE = 3e-4
"""How much of a correction in one step counts as motion [m]."""


class PairContact:
    """Proximity pairs of vertices with faces and edges with edges, their forces, and the stiffness they add.

    Each pair keeps its parts on the sides they are on when found; between garments whose surfaces face the same way,
    on the sides that the order of the layers says. Found anew every `every` steps with `slack` to spare in between.

    Attributes:
        count: Active pairs; vertices [P, 4], weights [P, 4], block [P, 4] (K = a I + w w^T) of them, and the gather
            list start [N + 2], index [4 P]: see `compact_pairs`.
    """

    def __init__(
        self,
        rest: np.ndarray,
        faces: np.ndarray,
        edges: np.ndarray,
        layer: np.ndarray,
        area: np.ndarray,
        mass: np.ndarray,
        friction: np.ndarray,
        *,
        thickness: float,
        slack: float,
        untangle: float,
        stiffness: float,
        damping: float,
        every: int,
        dtype: Any,
    ) -> None:
        n = len(rest)
        self.rest, self.faces, self.edges = rest, np.ascontiguousarray(faces, np.int32), edges
        self.layer, self.area, self.mass, self.friction = layer, area, mass, friction
        self.thickness, self.slack, self.stiffness, self.every = thickness, slack, stiffness, every
        self.damping = damping
        self.untangle = untangle if layer.max(initial=0) > 0 else 0.0
        self.corner_start, self.corner = incident_corners(self.faces, n)
        self.vertex_normal = np.zeros((n, 3))
        self.face_centre, self.face_radius = np.zeros((len(faces), 3)), np.zeros(len(faces))
        self.face_normal = np.zeros((len(faces), 3))
        self.edge_centre, self.edge_radius = np.zeros((len(edges), 3)), np.zeros(len(edges))
        self.face_grid, self.edge_grid = Grid(len(faces)), Grid(len(edges))
        self.vf_count, self.vf_found = np.zeros(n, np.int32), np.zeros((n, 16), np.int32)
        self.ee_count, self.ee_found = np.zeros(len(edges), np.int32), np.zeros((len(edges), 16), np.int32)
        self.close = np.zeros(n, np.int32)
        self.dtype = dtype
        self.total = self.faces_first = self.count = 0
        self.age = self.lasts = every
        # Looking further than half an edge would find each vertex's neighbours all over the cloth.
        edge = float(np.median(np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)))
        self.widest_slack = max(slack, 0.55 * edge - thickness)
        self.kept = np.zeros(1, np.int32)
        self.start = np.zeros(n + 2, np.int32)
        self._room(1024)

    def _room(self, total: int) -> None:
        """Buffers for `total` pairs."""
        self.found_vertices, self.side, self.gap = np.zeros((total, 4), np.int32), np.zeros((total, 3)), np.zeros(total)
        self.active = np.zeros(total, np.int32)
        self.found_weights, self.found_block = np.zeros((total, 4), self.dtype), np.zeros((total, 4), self.dtype)
        self.found_force, self.force = np.zeros((total, 3)), np.zeros((total, 3))
        self.vertices, self.index = np.zeros((total, 4), np.int32), np.zeros(4 * total, np.int32)
        self.weights, self.block = np.zeros((total, 4), self.dtype), np.zeros((total, 4), self.dtype)

    def closing_speed(self, x: np.ndarray, v: np.ndarray) -> float:
        """Estimate of the greatest speed [m/s] at which parts of the cloth near each other approach.

        The deviation from the mean velocity of the 8 cm cell that a vertex is in, of all but 1 in 500.
        """
        cell = np.floor((x - x.min(0)) / 0.08).astype(np.int64)
        key = (cell[:, 0] * 4096 + cell[:, 1]) * 4096 + cell[:, 2]
        _, place, count = np.unique(key, return_inverse=True, return_counts=True)
        mean = np.stack([np.bincount(place, v[:, c]) for c in range(3)], axis=1) / count[:, None]
        apart = ((v - mean[place]) ** 2).sum(1)
        return float(np.sqrt(np.partition(apart, -1 - len(apart) // 500)[-1 - len(apart) // 500]))

    def search(self, x: np.ndarray, v: np.ndarray, dt: float) -> None:
        """Find the pairs at `x`, if those known are older than `every` steps; `v` tells how far ahead to look."""
        self.age += 1
        if self.age < self.lasts:
            return
        self.age = 0
        face_spheres(x, self.faces, self.face_centre, self.face_radius, self.face_normal)
        cloth_normals(self.corner_start, self.corner, self.face_normal, self.vertex_normal)
        edge_spheres(x, self.edges, self.edge_centre, self.edge_radius)
        step = self.closing_speed(x, v) * dt
        self.lasts = max(1, min(self.every, int(self.slack / max(step, 1e-9))))
        near = self.thickness + min(max(self.slack, 2 * step), self.widest_slack)
        far = max(near, self.untangle)
        lo, hi = x.min(0), x.max(0)
        widest = float(self.face_radius.max())
        grid = self.face_grid
        grid.fill(self.face_centre, self.face_radius, far + widest, lo, hi)
        while True:
            find_vertex_faces(
                x, self.faces, self.layer, self.face_normal, self.rest, self.vertex_normal, near, far, widest,
                grid.lo, grid.size, grid.dims, grid.first, grid.items, grid.balls, self.vf_count, self.vf_found,
            )  # fmt: skip
            if not self._too_narrow("vf_found", self.vf_count):
                break
        mark_close(self.faces, self.vf_count, self.vf_found, self.close)
        widest = float(self.edge_radius.max())
        grid = self.edge_grid
        grid.fill(self.edge_centre, self.edge_radius, near + widest, lo, hi)
        while True:
            find_edge_edges(
                x, self.edges, self.close, self.layer, self.vertex_normal,
                self.edge_centre, self.edge_radius, near, widest,
                grid.lo, grid.size, grid.dims, grid.first, grid.items, grid.balls, self.ee_count, self.ee_found,
            )  # fmt: skip
            if not self._too_narrow("ee_found", self.ee_count):
                break
        vf_end, ee_end = np.cumsum(self.vf_count), np.cumsum(self.ee_count)
        self.faces_first = int(vf_end[-1])
        self.total = self.faces_first + int(ee_end[-1])
        if self.total > len(self.gap):
            self._room(int(self.total * 1.3))
        write_pairs(
            x, self.rest, self.vertex_normal, self.faces, self.edges, self.layer, self.thickness,
            (vf_end - self.vf_count).astype(np.int32), self.vf_count, self.vf_found,
            (self.faces_first + ee_end - self.ee_count).astype(np.int32), self.ee_count, self.ee_found,
            self.found_vertices, self.side, self.gap,
        )  # fmt: skip

    def _too_narrow(self, name: str, count: np.ndarray) -> bool:
        """Whether more were found than the list has room for; if so, the list is made wider."""
        found, most = getattr(self, name), int(count.max())
        if most <= found.shape[1]:
            return False
        setattr(self, name, np.zeros((len(found), int(most * 1.3)), np.int32))
        return True

    def _compact(self) -> None:
        compact_pairs(
            self.total, self.active, self.found_vertices, self.found_weights, self.found_block, self.found_force,
            self.kept, self.vertices, self.weights, self.block, self.force, self.start, self.index,
        )  # fmt: skip
        self.count = int(self.kept[0])

    def evaluate(self, x: np.ndarray, x_start: np.ndarray, dt: float, force: np.ndarray, diagonal: np.ndarray) -> None:
        """Add the pairs' forces at `x` to `force` [N, 3], and set `diagonal` [N, 6] to their blocks."""
        press_pairs(
            x, x_start, self.found_vertices, self.side, self.gap, self.faces_first, self.total, self.area,
            self.friction, self.stiffness, self.damping / dt,
            self.active, self.found_weights, self.found_block, self.found_force,
        )  # fmt: skip
        self._compact()
        gather_pairs(self.start, self.index, self.weights, self.block, self.force, force, diagonal)

    def part(self, solved: np.ndarray, x: np.ndarray, fixed: np.ndarray, rounds: int) -> None:
        """Move apart in `x`, in place, what has come within a quarter of its gap.

        `solved`, of which x is a copy, takes part in the first SHOVE of each move: as far as it stops what closes in,
        a correction is motion; the rest of it isn't.
        """
        moved = False
        for _ in range(rounds):
            part_pairs(
                x, self.found_vertices, self.side, self.gap, self.faces_first, self.total, self.mass, fixed,
                self.active, self.found_weights, self.found_force,
            )  # fmt: skip
            self._compact()
            if not self.count:
                break
            move_parted(self.start, self.index, self.weights, self.force, x)
            moved = True
        if moved:
            shift = x - solved
            length = np.linalg.norm(shift, axis=1, keepdims=True)
            solved += shift * np.minimum(1.0, SHOVE / np.maximum(length, 1e-12))
