"""Contact of the cloth with the moving body."""

from __future__ import annotations

import igl
import numpy as np

from stages.simulate.body_motion import BodyMotion
from stages.simulate.contact_kernels import find_candidates, foresee, hold_attached, lift_out, press, take_over, touch
from stages.simulate.grid import Grid
from stages.simulate.kernels import BLOCKS


class BodyContact:
    """Candidates, closest points, forces and stiffness of the body on N cloth vertices.

    A step goes: `search` at the guess, then in each Newton iteration `evaluate`, and `lift` when the step is solved.

    Attributes:
        force [N, 3] [N], block [N, 6] [N/m]: What the body does to each vertex, and minus its derivative.
        face [N], distance [N] [m]: Closest triangle, -1 if none is near, and signed distance to it.
        pinched [N]: 1 for vertices that have been near two sides of the skin since `tuck` last looked.
        reaction [N] [N]: Normal force of the skin that the last linear solve ended with.
        shear [N, 3] [m]: Elastic slip of the friction's grip; `accept` keeps that of the solved step.
    """

    def __init__(
        self,
        body: BodyMotion,
        area: np.ndarray,
        friction: np.ndarray,
        *,
        margin: float,
        stiffness: float,
        damping: float,
        grip: float,
    ) -> None:
        n = len(area)
        self.body, self.area, self.friction = body, area, friction
        self.margin, self.stiffness, self.damping, self.grip = margin, stiffness, damping, grip
        self.active, self.pinched = np.ones(n, np.int32), np.ones(n, np.int32)
        self.grid = Grid(max(len(body.piece_face), 1))
        self.count, self.found = np.zeros(n, np.int32), np.zeros((n, 32), np.int32)
        self.face, self.face2 = np.full(n, -1, np.int32), np.full(n, -1, np.int32)
        self.bary, self.normal, self.normal2 = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
        self.distance, self.distance2 = np.full(n, 1e9), np.full(n, 1e9)
        self.force, self.block = np.zeros((n, 3)), np.zeros((n, 6))
        self.shear, self.shear_new, self.reaction = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n)
        self.tie_face, self.tie_bary = np.zeros(n, np.int32), np.zeros((n, 3))
        self.tie_offset, self.tie_stiffness = np.zeros(n), np.zeros(n)
        self.has_ties = False
        self.deepest_vertex = 0
        self.deepest, self.moved = np.zeros(BLOCKS), np.zeros(BLOCKS, np.int32)

    def search(self, x: np.ndarray, reach: float) -> None:
        """List the triangles within `reach` [m] of each vertex of `x`, body at its present place."""
        if not len(self.body.faces):
            return
        b, g = self.body, self.grid
        widest = float(b.piece_radius.max())
        g.fill(
            b.piece_centre,
            b.piece_radius,
            max(reach + widest, 1e-3),
            x.min(0) - reach - widest,
            x.max(0) + reach + widest,
        )
        while True:
            find_candidates(
                x,
                b.piece_face,
                reach,
                widest,
                g.lo,
                g.size,
                g.dims,
                g.first,
                g.items,
                g.balls,
                self.count,
                self.found,
            )
            most = int(self.count.max())
            if most <= self.found.shape[1]:
                return
            self.found = np.zeros((len(x), int(most * 1.25)), np.int32)

    def locate(self, x: np.ndarray) -> None:
        """Closest points of the active vertices of `x` among the candidates."""
        b = self.body
        touch(
            x,
            self.active,
            self.count,
            self.found,
            b.x,
            b.faces,
            b.across,
            b.start,
            b.incident,
            b.face_normal,
            b.centre,
            b.radius,
            self.margin,
            self.face,
            self.bary,
            self.normal,
            self.distance,
            self.face2,
            self.normal2,
            self.distance2,
            self.pinched,
        )

    def evaluate(self, x: np.ndarray, x_start: np.ndarray, dt: float) -> None:
        """Force and block at `x`, a step of `dt` [s] after `x_start`."""
        b = self.body
        if not len(b.faces):
            self.force[:] = 0.0
            return
        self.locate(x)
        press(
            x,
            x_start,
            self.face,
            self.bary,
            self.normal,
            self.distance,
            self.face2,
            self.normal2,
            self.distance2,
            b.x,
            b.x_old,
            b.faces,
            self.area,
            self.friction,
            self.shear,
            self.reaction,
            self.margin,
            self.stiffness,
            self.damping,
            dt,
            self.grip,
            self.force,
            self.block,
            self.shear_new,
        )
        if self.has_ties:
            hold_attached(
                x,
                x_start,
                self.tie_face,
                self.tie_bary,
                self.tie_offset,
                self.tie_stiffness,
                b.x,
                b.faces,
                self.force,
                self.block,
            )

    def foresee(self, x: np.ndarray, solved: np.ndarray) -> None:
        """Take over what the linear solve from `x`, where contact was evaluated, to `solved` says of the forces."""
        if len(self.body.faces):
            foresee(
                x, solved, self.face, self.normal, self.distance, self.area, self.friction,
                self.margin, self.stiffness, self.grip, self.reaction, self.shear_new,
            )  # fmt: skip

    def lift(self, x: np.ndarray, fixed: np.ndarray, floor: float, attempts: int = 3) -> tuple[float, int]:
        """Move vertices of `x` nearer than `floor` [m] out to it, in place: (least distance before [m], moved).

        Where skin folds, a vertex moved out of one side may come to lie behind another: such vertices are looked at
        again, `attempts` times at most.
        """
        if not len(self.body.faces):
            return 1e9, 0
        least, total = 1e9, 0
        for attempt in range(attempts):
            self.locate(x)
            lift_out(self.face, self.normal, self.distance, fixed, floor, x, self.active, self.deepest, self.moved)
            if attempt == 0:
                least, total = float(self.deepest.min()), int(self.moved.sum())
                self.deepest_vertex = int(np.argmin(self.distance))
            if not self.moved.any():
                break
        self.active[:] = 1
        return least, total

    def tuck(self, x: np.ndarray, depth: float) -> int:
        """Lay vertices of `x` that are hidden where the body overlaps itself onto the nearest skin, in place.

        In an armpit or a bent elbow skin passes into skin and there is no outside left for the cloth in the fold. It
        stays on the side it lies on, at most `depth` [m] from that skin, so that it is nowhere deep inside the body
        either; the fold hides it. Only what has been between two sides of the skin can get there. Returns how many
        were moved.
        """
        if not len(self.body.faces) or not self.pinched.any():
            return 0
        self.locate(x)
        near = np.flatnonzero((self.face >= 0) & (self.distance > depth) & (self.pinched > 0))
        self.pinched[:] = 0
        if not len(near):
            return 0
        # The winding number counts how many times the skin encloses a point, overlapping or not (Barill et al. 2018).
        winding = igl.fast_winding_number(self.body.x, self.body.faces.astype(np.int64), x[near])
        hidden = near[winding > 0.5]
        self.pinched[hidden] = 1
        x[hidden] += (depth - self.distance[hidden])[:, None] * self.normal[hidden]
        return len(hidden)

    def take_over(
        self,
        solved: np.ndarray,
        x: np.ndarray,
        x_bar: np.ndarray,
        h: float,
        dt: float,
        v: np.ndarray,
        before: np.ndarray,
    ) -> None:
        """Velocities `v` of a step that solved for `solved` and was corrected to `x`; see the kernel."""
        b = self.body
        if not len(b.faces):
            np.divide(solved - x_bar, h, out=v)
            before += x - solved
            return
        take_over(
            solved, x, x_bar, h, dt, self.face, self.bary, self.normal, b.x, b.x_old, b.faces, v, before
        )  # fmt: skip

    def accept(self) -> None:
        """Keep the grip of the step that has been solved."""
        self.shear, self.shear_new = self.shear_new, self.shear

    def tie(self, vertices: np.ndarray, x: np.ndarray, stiffness: np.ndarray) -> None:
        """Tie `vertices` (K,) of `x` softly to the closest body points where they are now, `stiffness` (K,) [N/m]."""
        reach = self.margin
        while (self.face[vertices] < 0).any():
            reach *= 2
            self.search(x, reach)
            self.locate(x)
            if reach > 1.0:
                break
        keep = vertices[self.face[vertices] >= 0]
        self.tie_face[keep], self.tie_bary[keep] = self.face[keep], self.bary[keep]
        self.tie_offset[keep] = np.maximum(self.distance[keep], self.margin)
        self.tie_stiffness[keep] = stiffness[np.isin(vertices, keep)]
        self.has_ties = bool(len(keep))
