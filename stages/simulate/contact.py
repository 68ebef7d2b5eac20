"""Contact of the cloth with the moving body."""

from __future__ import annotations

import igl
import numpy as np

from stages.simulate.body_motion import BodyMotion
from stages.simulate.contact_corrections import lift_out, take_over
from stages.simulate.contact_forces import foresee, hold_attached, press
from stages.simulate.contact_search import find_candidates, touch
from stages.simulate.fold_kernels import count_windings, lay_on_skin
from stages.simulate.kernels import BLOCKS
from stages.simulate.patch_kernels import GROUP, bound_patches, keep_meeting, meet_others
from stages.simulate.patches import Patches, widened


class BodyContact:
    """Candidates, closest points, forces and stiffness of the body on N cloth vertices.

    A step goes: `search` at the guess, then in each Newton iteration `evaluate`, and `lift` when the step is solved.

    Attributes:
        force [N, 3] [N], block [N, 6] [N/m]: What the body does to each vertex, and minus its derivative.
        face [N], distance [N] [m]: Closest triangle, -1 if none is near, and signed distance to it.
        pinched [N]: 1 for vertices that have been near two sides of the skin since `tuck` last looked.
        reaction [N] [N]: Normal force of the skin that the last linear solve ended with.
        fresh [N]: 1 for vertices that met the skin or left it in the last step.
        shear [N, 3] [m]: Elastic slip of the friction's grip; `accept` keeps that of the solved step.
    """

    SPARE = 0.004
    """How much beyond the margin to look for skin, besides what it moves [m]."""
    MEET_STEPS = 4
    """Steps ahead for which the patches that can meet are looked up."""
    SURPRISE = 0.02
    """How much further cloth may go meanwhile than its velocity says [m]."""

    def __init__(
        self,
        body: BodyMotion,
        patches: Patches,
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
        self.patches = patches
        own = len(patches.layer)
        self.box, self.group_box = np.zeros((own, 6)), np.zeros((_groups(own), 6))
        self.met_count, self.met = np.zeros(own, np.int32), np.zeros((own, 32), np.int32)
        self.near_count, self.near = np.zeros(own, np.int32), np.zeros((own, 32), np.int32)
        self.ahead, self.body_ahead = np.zeros((n, 3)), np.zeros_like(body.x)
        all_patches = len(body.whole_start) - 1
        self.whole_box, self.whole_group_box = np.zeros((all_patches, 6)), np.zeros((_groups(all_patches), 6))
        self.fit_body()
        self.count, self.found = np.zeros(n, np.int32), np.zeros((n, 32), np.int32)
        self.face, self.face2 = np.full(n, -1, np.int32), np.full(n, -1, np.int32)
        self.bary, self.normal, self.normal2 = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
        self.distance, self.distance2 = np.full(n, 1e9), np.full(n, 1e9)
        self.looked, self.located = np.zeros((n, 3)), np.nan
        self.force, self.block = np.zeros((n, 3)), np.zeros((n, 6))
        self.shear, self.shear_new, self.reaction = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n)
        self.tie_corner, self.tie_bary = np.zeros((n, 3), np.int32), np.zeros((n, 3))
        self.tie_face = np.arange(n, dtype=np.int32)
        self.tie_offset, self.tie_stiffness = np.zeros(n), np.zeros(n)
        self.has_ties = False
        self.fresh, self.touched = np.zeros(n, np.int32), np.zeros(n, np.int32)
        self.deepest_vertex = 0
        self.deepest, self.moved = np.zeros(BLOCKS), np.zeros(BLOCKS, np.int32)

    def fit_body(self) -> None:
        """Room for the patches that the body has now; what they meet is looked up anew."""
        other = len(self.body.patch_start) - 1
        self.body_step_box, self.body_box = np.zeros((other, 6)), np.zeros((other, 6))
        self.body_group_box = np.zeros((_groups(other), 6))
        self.met_until = -1.0

    def search(self, x: np.ndarray, v: np.ndarray, dt: float, guess: np.ndarray, furthest: float) -> None:
        """List the triangles near each vertex of `guess`, which a step of `dt` [s] from x at velocity v leads to.

        The body has been moved to the end of the step. Which patches of the body each patch of cloth can meet is looked
        up for some steps at a time. No triangle further away than `furthest` [m] is listed.
        """
        b = self.body
        if not len(b.faces):
            return
        if b.time > self.met_until + 1e-9:
            self._meet(x, v, b.time - dt, self.MEET_STEPS * dt)
        bound_patches(b.x_old, b.x, b.faces, b.patch_start, self.body_step_box, self.body_group_box)
        own = self.patches
        keep_meeting(
            guess, own.faces, own.start, self.body_step_box, furthest,
            self.met_count, self.met, self.near_count, self.near,
        )  # fmt: skip
        while True:
            find_candidates(
                guess, v, b.x, b.x_old, b.faces, b.centre, b.radius, self.margin + self.SPARE, furthest, dt,
                own.of_vertex, b.patch_start, self.body_step_box, self.near_count, self.near, self.count, self.found,
            )  # fmt: skip
            found, self.found = self.found, widened(self.found, self.count)
            if found is self.found:
                return

    def _meet(self, x: np.ndarray, v: np.ndarray, time: float, horizon: float) -> None:
        """Which patches of the body each patch of cloth can meet from `time` [s] on for `horizon` [s]."""
        b, own = self.body, self.patches
        drift = v.mean(0)
        np.multiply(v - drift, 1.25 * horizon, out=self.ahead)
        self.ahead += x
        bound_patches(x, self.ahead, own.faces, own.start, self.box, self.group_box)
        b.place(time + horizon, self.body_ahead)
        self.body_ahead -= horizon * drift
        bound_patches(b.x_old, self.body_ahead, b.faces, b.patch_start, self.body_box, self.body_group_box)
        # What the velocity at the start doesn't tell: contact and gravity may speed the cloth up meanwhile.
        reach = self.margin + self.SPARE + self.SURPRISE
        while True:
            meet_others(self.box, self.body_box, self.body_group_box, reach, self.met_count, self.met)
            met, self.met = self.met, widened(self.met, self.met_count)
            if met is self.met:
                break
            self.near = np.zeros_like(self.met)
        self.met_until = time + horizon

    def locate(self, x: np.ndarray) -> None:
        """Closest points of the active vertices of `x` among the candidates; far away ones may keep an older one."""
        b = self.body
        moved, self.located = int(self.located != b.time), b.time
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
            moved,
            self.face,
            self.bary,
            self.normal,
            self.distance,
            self.face2,
            self.normal2,
            self.distance2,
            self.pinched,
            self.looked,
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
                self.tie_corner,
                self.force,
                self.block,
            )

    @property
    def touching(self) -> int:
        """How many vertices the skin touches."""
        return int((self.distance < self.margin).sum()) if len(self.body.faces) else 0

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
        either; the fold hides it. Only what has been between two sides of the skin, or is next to such cloth, can get
        there. Returns how many were moved.
        """
        if not len(self.body.faces):
            return 0
        self.locate(x)
        # What two skins push to and fro is left behind one of them.
        lost = (self.distance < -depth) | ((self.distance > depth) & (self.pinched > 0))
        near = np.flatnonzero((self.face >= 0) & lost)
        self.pinched[:] = 0
        if not len(near):
            return 0
        # The winding number counts how many times the skin encloses a point, overlapping or not.
        winding = np.zeros(len(near), np.int32)
        b = self.body
        bound_patches(b.x, b.x, b.whole, b.whole_start, self.whole_box, self.whole_group_box)
        count_windings(np.ascontiguousarray(x[near]), b.x, b.whole, b.whole_start, self.whole_box, winding)
        hidden = near[winding > 0]
        self.pinched[hidden] = 1
        edges = self.patches.edges
        for _ in range(2 if len(hidden) else 0):
            self.pinched[edges[self.pinched[edges].any(axis=1)]] = 1
        if len(hidden):
            lay_on_skin(
                hidden.astype(np.int32), self.body.x, self.body.faces, self.body.centre, self.body.radius, depth, x
            )
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
            solved, x, x_bar, h, dt, self.face, self.distance, self.bary, self.normal, b.x, b.x_old, b.faces,
            self.margin, self.touched, self.fresh, v, before,
        )  # fmt: skip

    def accept(self) -> None:
        """Keep the grip of the step that has been solved."""
        self.shear, self.shear_new = self.shear_new, self.shear

    def tie(self, vertices: np.ndarray, x: np.ndarray, stiffness: np.ndarray) -> None:
        """Tie `vertices` (K,) of `x` softly to the closest body points where they are now, `stiffness` (K,) [N/m]."""
        b = self.body
        assert b.cut is not None
        # Of faces that are equally near the first is taken, so that all have to be there, whatever is left out.
        squared, face, point = igl.point_mesh_squared_distance(x[vertices], b.x, b.cut.faces.astype(np.int64))[:3]
        self.tie_corner[vertices] = b.cut.faces[face]
        corners = [np.ascontiguousarray(b.x[b.cut.faces[face, k]]) for k in range(3)]
        self.tie_bary[vertices] = igl.barycentric_coordinates(np.ascontiguousarray(point), *corners)
        self.tie_offset[vertices] = np.maximum(np.sqrt(squared), self.margin)
        self.tie_stiffness[vertices] = stiffness
        self.has_ties = True


def _groups(patches: int) -> int:
    """How many boxes hold GROUP patches each."""
    return (patches + GROUP - 1) // GROUP
