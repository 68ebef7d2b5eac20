"""Contact of cloth with cloth: self-collision, and one garment over another."""

from __future__ import annotations

from typing import Any

import numpy as np

from stages.simulate.body_kernels import face_frames
from stages.simulate.body_motion import incident_corners
from stages.simulate.pair_kernels import compact_pairs, gather_pairs, move_parted, part_pairs, press_pairs, write_pairs
from stages.simulate.pair_normals import cloth_normals
from stages.simulate.pair_search import (
    edge_spheres,
    find_edge_edges,
    find_vertex_faces,
    mark_close,
)
from stages.simulate.patch_kernels import GROUP, bound_normals, bound_patches, meet_patches
from stages.simulate.patches import Patches, widened
from stages.simulate.untangle import Crossings

LOOK_AHEAD = 1.25
"""How much further than its velocity says cloth is expected to go while pairs are kept."""
WIDEST_CONE = 1.25
"""Greatest angle [rad] between normals of cloth that surely hasn't folded onto itself."""
JERK = 0.5
"""How far cloth may leave its course in a step, over how much further than their reach pairs are looked for."""
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
        patches: Patches,
        layer: np.ndarray,
        area: np.ndarray,
        mass: np.ndarray,
        friction: np.ndarray,
        sheet: np.ndarray,
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
        self.patches = patches
        self.rest, self.faces, self.edges = rest, patches.faces, patches.edges
        faces, edges = self.faces, self.edges
        self.layer, self.area, self.mass, self.friction, self.sheet = layer, area, mass, friction, sheet
        self.thickness, self.slack, self.stiffness, self.every = thickness, slack, stiffness, every
        self.damping = damping
        self.untangle = untangle if layer.max(initial=0) > 0 else 0.0
        self.corner_start, self.corner = incident_corners(self.faces, n)
        self.vertex_normal = np.zeros((n, 3))
        self.face_centre, self.face_radius = np.zeros((len(faces), 3)), np.zeros(len(faces))
        self.face_normal = np.zeros((len(faces), 3))
        self.edge_centre, self.edge_radius = np.zeros((len(edges), 3)), np.zeros(len(edges))
        count = len(patches.layer)
        self.box, self.cone, self.drift = np.zeros((count, 6)), np.zeros((count, 4)), np.zeros(3)
        self.group_box = np.zeros(((count + GROUP - 1) // GROUP, 6))
        self.met_count, self.met = np.zeros(count, np.int32), np.zeros((count, 32), np.int32)
        self.fast, self.slip, self.ahead = 0.0, np.zeros(n), np.zeros((n, 3))
        self.vf_count, self.vf_found = np.zeros(n, np.int32), np.zeros((n, 16), np.int32)
        self.ee_count, self.ee_found = np.zeros(len(edges), np.int32), np.zeros((len(edges), 16), np.int32)
        self.vf_start, self.ee_start = np.zeros(n, np.int32), np.zeros(len(edges), np.int32)
        self.close = np.zeros(n, np.int32)
        self.crossings = Crossings(patches, layer)
        self.dtype = dtype
        self.total = self.whole = self.faces_first = self.count = 0
        self.age = self.lasts = every
        self.meets_for = 0.0  # [s], how much longer the patches that can touch are known
        # What nears fast is looked for this much further away; further still would be most of the cloth.
        length = np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)
        self.widest_slack, self.beside = 1.5 * float(np.median(length)), 1.2 * float(length.max())
        self.kept = np.zeros(1, np.int32)
        self.start = np.zeros(n + 2, np.int32)
        self.room(1024)

    def room(self, total: int) -> None:
        """Buffers for `total` pairs."""
        self.found_vertices, self.side, self.gap = np.zeros((total, 4), np.int32), np.zeros((total, 3)), np.zeros(total)
        self.active = np.zeros(total, np.int32)
        self.found_weights, self.found_block = np.zeros((total, 4), self.dtype), np.zeros((total, 4), self.dtype)
        self.found_force, self.force = np.zeros((total, 3)), np.zeros((total, 3))
        self.vertices, self.index = np.zeros((total, 4), np.int32), np.zeros(4 * total, np.int32)
        self.weights, self.block = np.zeros((total, 4), self.dtype), np.zeros((total, 4), self.dtype)

    def search(self, x: np.ndarray, v: np.ndarray, dt: float) -> None:
        """Find the pairs at `x`, if those known are older than `every` steps; `v` tells how far ahead to look."""
        self.age += 1
        self.meets_for -= dt
        if self.age < self.lasts:
            self._pull(x)
            return
        self.age = 0
        p = self.patches
        face_frames(x, self.faces, self.face_normal, self.face_centre, self.face_radius)
        cloth_normals(self.corner_start, self.corner, self.face_normal, self.vertex_normal)
        edge_spheres(x, self.edges, self.edge_centre, self.edge_radius)
        self.lasts = self._lasting(dt)  # by the speeds last looked at, and again by the present ones below
        near, horizon = self.thickness + self.slack, LOOK_AHEAD * self.lasts * dt
        furthest, far = near + self.widest_slack, max(near, self.untangle)
        np.mean(v, axis=0, out=self.drift)
        if self.meets_for < self.lasts * dt:
            self._meet(x, v, near, far, self.every * dt)
        self._bound(x, v, horizon)
        while True:
            find_vertex_faces(
                x, v, self.drift, self.faces, self.layer, self.face_centre, self.face_radius, self.face_normal,
                self.rest, self.vertex_normal, near, horizon, furthest, far, self.beside,
                p.of_vertex, p.start, self.box, self.met_count, self.met, self.vf_count, self.vf_found, self.slip,
            )  # fmt: skip
            vf_found, self.vf_found = self.vf_found, widened(self.vf_found, self.vf_count)
            if vf_found is self.vf_found:
                break
        mark_close(self.faces, self.vf_count, self.vf_found, self.close)
        while True:
            find_edge_edges(
                x, v, self.drift, self.edges, self.close, self.layer, self.vertex_normal,
                self.edge_centre, self.edge_radius, near, horizon, furthest,
                p.of_edge, p.edge_start, self.box, self.met_count, self.met, self.ee_count, self.ee_found,
            )  # fmt: skip
            ee_found, self.ee_found = self.ee_found, widened(self.ee_found, self.ee_count)
            if ee_found is self.ee_found:
                break
        self.fast = float(np.partition(self.slip, -1 - len(x) // 500)[-1 - len(x) // 500])
        self.lasts = min(self.lasts, self._lasting(dt))
        vf_end, ee_end = np.cumsum(self.vf_count), np.cumsum(self.ee_count)
        self.faces_first = int(vf_end[-1])
        self.total = self.faces_first + int(ee_end[-1])
        self.find_crossings(x, self.close, self.untangle == 0.0)
        if self.total > len(self.gap):
            self.room(int(self.total * 1.3))
        np.subtract(vf_end, self.vf_count, out=self.vf_start, casting="unsafe")
        np.subtract(self.faces_first + ee_end, self.ee_count, out=self.ee_start, casting="unsafe")
        write_pairs(
            x, self.rest, self.vertex_normal, self.faces, self.edges, self.layer, self.crossings.part,
            int(self.untangle > 0.0), self.thickness,
            self.vf_start, self.vf_count, self.vf_found, self.ee_start, self.ee_count, self.ee_found,
            self.found_vertices, self.side, self.gap,
        )  # fmt: skip
        self._pull(x)

    def _pull(self, x: np.ndarray) -> None:
        """Put what still crosses at `x` behind the pairs: ends of edges that are pulled past faces in this step."""
        vertices, way, pace = self.crossings.ways(x)
        self.whole = self.total + len(pace)
        if self.whole > len(self.gap):
            found, n = (self.found_vertices, self.side, self.gap), self.total
            self.room(int(self.whole * 1.3))
            self.found_vertices[:n], self.side[:n], self.gap[:n] = (values[:n] for values in found)
        pulled = slice(self.total, self.whole)
        self.found_vertices[pulled], self.side[pulled], self.gap[pulled] = vertices, way, pace

    def _bound(self, x: np.ndarray, v: np.ndarray, horizon: float) -> None:
        """Boxes of the patches and of what they sweep within `horizon` [s], seen from the cloth as a whole."""
        np.subtract(v, self.drift, out=self.ahead)
        self.ahead *= horizon
        self.ahead += x
        bound_patches(x, self.ahead, self.faces, self.patches.start, self.box, self.group_box)

    def _meet(self, x: np.ndarray, v: np.ndarray, near: float, far: float, time: float) -> None:
        """Which patches each patch can touch within `time` [s]: nearer than `near`, or `far` between garments [m]."""
        p = self.patches
        self._bound(x, v, LOOK_AHEAD * time)
        bound_normals(self.face_normal, p.start, self.cone)
        while True:
            meet_patches(
                self.box, self.cone, p.layer, p.near_start, p.near, near, far, WIDEST_CONE,
                self.group_box, self.met_count, self.met,
            )  # fmt: skip
            met, self.met = self.met, widened(self.met, self.met_count)
            if met is self.met:
                break
        self.meets_for = time

    def find_crossings(self, x: np.ndarray, near: np.ndarray, others: bool) -> None:
        """Look for `crossings` at x, where the faces' frames and the patches that meet are known; see there."""
        self.crossings.find(x, self.face_centre, self.face_radius, near, others, self.met_count, self.met)

    def _lasting(self, dt: float) -> int:
        """Steps for which pairs are kept: all but 1 vertex in 500 closed in slowly enough when last looked at."""
        return max(1, min(self.every, int(self.widest_slack / max(LOOK_AHEAD * self.fast * dt, 1e-9))))

    def jerked(self, x: np.ndarray, v: np.ndarray, dt: float, reached: np.ndarray) -> int:
        """The vertex that left its course the most if pairs may have been missed for it, -1 if they can't have been.

        Pairs are looked for along the course that velocities v (N, 3) at x set for a step of `dt` [s]. It `reached`
        other places: that counts where more than 1 vertex in 500 left it by JERK, seen from the cloth as a whole.
        """
        astray, limit = self.ahead, (JERK * self.widest_slack) ** 2
        np.multiply(v, -dt, out=astray)
        astray += reached
        astray -= x
        if not (np.einsum("ij,ij->i", astray, astray) > limit).any():
            return -1
        astray -= astray.mean(0)
        far = np.einsum("ij,ij->i", astray, astray)
        return int(far.argmax()) if np.count_nonzero(far > limit) > len(x) / 500 else -1

    def _compact(self, total: int) -> None:
        compact_pairs(
            total, self.active, self.found_vertices, self.found_weights, self.found_block, self.found_force,
            self.kept, self.vertices, self.weights, self.block, self.force, self.start, self.index,
        )  # fmt: skip
        self.count = int(self.kept[0])

    def evaluate(self, x: np.ndarray, x_start: np.ndarray, dt: float, force: np.ndarray, diagonal: np.ndarray) -> None:
        """Add the pairs' forces at `x` to `force` [N, 3], and set `diagonal` [N, 6] to their blocks."""
        press_pairs(
            x, x_start, self.found_vertices, self.side, self.gap, self.faces_first, self.total, self.whole, self.area,
            self.sheet, self.friction, self.stiffness, self.damping / dt,
            self.active, self.found_weights, self.found_block, self.found_force,
        )  # fmt: skip
        self._compact(self.whole)
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
            self._compact(self.total)
            if not self.count:
                break
            move_parted(self.start, self.index, self.weights, self.force, x)
            moved = True
        if moved:
            shift = x - solved
            length = np.linalg.norm(shift, axis=1, keepdims=True)
            solved += shift * np.minimum(1.0, SHOVE / np.maximum(length, 1e-12))
