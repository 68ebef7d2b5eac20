"""One time step: an implicit integrator, Newton's method, contact, and the check that the result can be trusted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from stages.simulate.config import SimulateConfig
from stages.simulate.contact import BodyContact
from stages.simulate.cover import Cover
from stages.simulate.elastic import advance, gather_rows, inertial_target, spring_blocks
from stages.simulate.kernels import BLOCKS
from stages.simulate.multilevel import Multilevel
from stages.simulate.pairs import PairContact
from stages.simulate.pcg import Pcg, conjugate_gradients
from stages.simulate.springs import Springs
from stages.simulate.tidy import Tidy
from stages.simulate.watch import Watch
from stages.simulate.wide_pcg import WidePcg
from stages.spec import DataError


@dataclass
class Report:
    """What a run did: counts, and seconds spent by part."""

    steps: int = 0
    contacts: int = 0
    pairs: int = 0
    halvings: int = 0
    unsolved: int = 0
    newton: int = 0
    linear: int = 0
    lifted: int = 0
    deepest: float = 0.0
    seconds: dict[str, float] = field(default_factory=dict)

    def clock(self, part: str, since: float) -> float:
        """Add the time since `since` to `part`; returns now."""
        now = perf_counter()
        self.seconds[part] = self.seconds.get(part, 0.0) + now - since
        return now


class Rejected(Exception):
    """A step whose result can't be trusted: (vertex, cause)."""

    def __init__(self, vertex: int, cause: str) -> None:
        super().__init__(cause)
        self.vertex, self.cause = vertex, cause


class Stepper:
    """State of the cloth and the step that advances it.

    Attributes:
        x, v: Positions [m] and velocities [m/s], shape [N, 3], at `time` [s].
        shown: Room for positions that are put in order to be recorded, [N, 3]: kernels launch faster on known arrays.
        fastest: Bound on the speed of skin past cloth near it [m/s], which sets how far contact is looked for.
        first_frame: Frame of the body that counts as 0 in messages.
        watch: The plan in force; None does without.
        cover: Covers skin that stands out between vertices, in a copy of x.
        tidy: Takes apart what crosses in a copy of x, if cloth collides with cloth.
    """

    LONGEST_MOVE = 0.03
    """Furthest that one Newton iteration may move a vertex [m]."""
    UNSOLVED = 0.003
    """A step isn't solved while the last iteration still moved a vertex this far [m]..."""
    SHARE = 1 / 3
    """... or this share of its short edges: those of the 5th percentile..."""
    PATIENCE = 4
    """... and gets up to so many times the iterations; a step that isn't solved then is halved..."""
    PART = 8
    """... down to this part of the longest, and further where edges are short: what still jumps there is pinched."""
    LEVELS_LAST = 4
    """Steps for which the matrices of the coarse levels are kept."""

    def __init__(
        self,
        springs: Springs,
        contact: BodyContact,
        pairs: PairContact | None,
        config: SimulateConfig,
        x: np.ndarray,
        *,
        drag: np.ndarray,
        fixed: np.ndarray,
        goal: Callable[[float], np.ndarray] | None = None,
        wind: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Start at rest at `x`; `goal(time)` gives places [N, 3], of which those of the `fixed` vertices are used."""
        n = len(x)
        real = np.float32 if config.precision == "f32" else np.float64
        self.springs, self.contact, self.pairs, self.config = springs, contact, pairs, config
        self.cover = Cover(contact)
        self.tidy = None if pairs is None else Tidy(pairs, contact)
        self.time, self.last_dt = 0.0, 0.0
        self.fastest = np.inf
        self.first_frame = 0
        self.watch: Watch | None = None
        self.x, self.v = np.array(x, np.float64), np.zeros((n, 3))
        self.x_old, self.v_old, self.shown = self.x.copy(), self.v.copy(), self.x.copy()
        self.x_bar, self.y, self.guess, self.trial = (np.zeros((n, 3)) for _ in range(4))
        self.residual = np.zeros((n, 3))
        self.pull, self.block = np.zeros((len(springs.edges), 3)), np.zeros((len(springs.edges), 4), real)
        self.bend, self.bend_scale = springs.bend.astype(real), np.ones(n, real)
        self.pair_block = np.zeros((n, 6))
        self.drag, self.wind = np.ascontiguousarray(drag, np.float64), np.array(wind, np.float64)
        self.fixed = np.ascontiguousarray(fixed, np.int32)
        self.goal = goal
        self.pcg = Pcg(n, real)
        self.wide = WidePcg(self.pcg) if config.device == "gpu" else None
        self.levels = Multilevel(springs.edges, springs.stiffness, self.fixed, real)
        self.levels_age, self.levels_h = self.LEVELS_LAST, 0.0
        self.own = np.zeros((n, 6))
        self.inertia = np.zeros(n)
        self.largest = np.zeros(BLOCKS)
        self.unsolved = min(self.UNSOLVED, self.SHARE * float(np.percentile(springs.length, 5)))
        self.report = Report()
        self.no_pairs = (
            np.zeros((1, 4), np.int32),
            np.zeros((1, 4), real),
            np.zeros((1, 4), real),
            np.zeros(n + 1, np.int32),
            np.zeros(1, np.int32),
        )

    def advance_to(self, time: float, dt: float) -> None:
        """Step until `time` [s] in equal steps of at most `dt`, halving those that fail.

        Raises:
            DataError: If a step of `shortest_dt` fails, naming time, vertex and cause.
        """
        while time - self.time > 1e-9:
            left = time - self.time
            step = left / np.ceil(left / dt - 1e-6)
            reaction = self.contact.reaction.copy()
            try:
                self.step(step)
            except Rejected as fault:
                self.contact.reaction[:] = reaction
                dt = step / 2
                self.report.halvings += 1
                if dt < self.config.shortest_dt:
                    where = ", ".join(f"{c:.3f}" for c in self.x[fault.vertex])
                    raise DataError(
                        f"simulation failed at {self._when()}: vertex {fault.vertex} at ({where}) m: {fault.cause}, "
                        f"with a step of {step:.1e} s, floor {self.config.shortest_dt:.1e} s; "
                        "check the motion there, or lower simulate.shortest_dt"
                    ) from None

    def _when(self) -> str:
        """The present time, as the frame of the sequence it lies in, or of the transition before it."""
        frame = int(self.time * self.contact.body.fps) - self.first_frame
        where = f"frame {frame}" if frame >= 0 else f"{-frame} frames before the first, in the transition"
        return f"{where} ({self.time:.4f} s)"

    def step(self, dt: float) -> None:
        """One step of `dt` [s].

        Raises:
            Rejected: If the result isn't finite or can't be trusted; the state is as it was before.
        """
        c, s = self.config, self.springs
        clock = perf_counter()
        w = dt / self.last_dt if c.integrator == "bdf2" and self.last_dt > 0 else 0.0
        if w > 2.0:
            w = 0.0
        h = dt * (1 + w) / (1 + 2 * w)
        goal = self.x if self.goal is None else self.goal(self.time + dt)
        inertial_target(
            self.x, self.v, self.x_old, self.v_old, w, dt, self.fixed, goal, self.springs.mass, self.contact.fresh,
            self.x_bar, self.y, self.guess, self.inertia,
        )  # fmt: skip
        self.contact.body.move_to(self.time, dt)
        clock = self.report.clock("body", clock)
        furthest = c.margin + self.contact.SPARE + min(max(self.fastest * dt, c.travel), 2 * c.travel)
        self.contact.search(self.x, self.v, dt, self.guess, furthest)
        clock = self.report.clock("candidates", clock)
        if self.pairs is not None:
            self.pairs.search(self.x, self.v, dt)
            clock = self.report.clock("pairs", clock)
        x, other = self.guess, self.trial
        self.bend_scale[:] = 1 + s.bend_damping / h
        for iteration in range(self.PATIENCE * c.newton_iterations):
            clock = perf_counter()
            self.contact.evaluate(x, self.x, dt)
            clock = self.report.clock("contact", clock)
            if self.pairs is not None:
                self.pairs.evaluate(x, self.x, dt, self.contact.force, self.pair_block)
                clock = self.report.clock("pairs", clock)
            self._assemble(x, h)
            if iteration == 0:
                self._rebuild_levels(h)
            clock = self.report.clock("assembly", clock)
            self._solve()
            clock = self.report.clock("solve", clock)
            advance(x, self.pcg.dx, self.LONGEST_MOVE, BLOCKS, other, self.largest)
            self.contact.foresee(x, other)
            self.report.contacts += self.contact.touching
            self.report.pairs += 0 if self.pairs is None else self.pairs.count
            x, other = other, x
            self.report.newton += 1
            moved = float(self.largest.max())
            if not moved < 1e29:
                raise Rejected(int(np.argmax(~np.isfinite(self.pcg.dx).all(1))), "the solution is not finite")
            # The first iteration holds what touches by friction; only the second knows whether it slides. Where the
            # last one of those given still moved a vertex far, the step isn't solved yet.
            wanted = c.newton_tolerance if iteration + 1 < c.newton_iterations else self.unsolved
            if iteration > 0 and moved < max(wanted, c.newton_tolerance):
                break
        if moved > self.unsolved:
            vertex = int(np.argmax(np.abs(self.pcg.dx).max(1)))
            if moved > self.LONGEST_MOVE or self._divisible(dt, self.PART * self.UNSOLVED / self.unsolved):
                raise Rejected(vertex, f"the last Newton iteration still moved it {moved * 1e3:.2g} mm")
            self.report.unsolved += 1
        if self.pairs is not None and self._divisible(dt, self.PART):
            jerked = self.pairs.jerked(self.x, self.v, dt, x)
            if jerked >= 0:
                raise Rejected(jerked, "it was jerked off its course, maybe through other cloth")
        self._finish(x, other, dt, h)

    def _divisible(self, dt: float, part: float) -> bool:
        """Whether a step of `dt` [s] may be halved, down to that `part` of the longest."""
        return dt > max(self.config.dt / part, 2 * self.config.shortest_dt)

    def _rebuild_levels(self, h: float) -> None:
        """Take the coarse levels' matrices from the present one, now and then: a preconditioner may be a bit old."""
        self.levels_age += 1
        if self.levels_age >= self.LEVELS_LAST or abs(h - self.levels_h) > 0.2 * h:
            self.levels.rebuild(self.block, self.own)
            self.levels_age, self.levels_h = 0, h

    def _assemble(self, x: np.ndarray, h: float) -> None:
        s, p = self.springs, self.pcg
        spring_blocks(
            x,
            self.x_bar,
            s.edges,
            s.rest_length,
            s.stiffness,
            s.limit,
            s.stiffening,
            s.damping,
            s.edge_bend,
            h,
            self.pull,
            self.block,
        )
        gather_rows(
            x,
            self.x_bar,
            self.y,
            s.mass,
            self.inertia,
            s.area,
            self.drag,
            self.config.gravity,
            self.wind,
            h,
            s.start,
            s.neighbour,
            s.spring,
            self.pull,
            self.block,
            s.bend_start,
            s.bend_neighbour,
            s.bend,
            s.bend_sum,
            s.bend_damping,
            self.contact.force,
            self.contact.block,
            self.pair_block,
            self.fixed,
            self.residual,
            p.diagonal,
            p.inverse,
            self.own,
        )

    def _solve(self) -> None:
        s, p, c = self.springs, self.pcg, self.config
        q = self.pairs
        m = self.levels
        pairs = self.no_pairs if q is None else (q.vertices, q.weights, q.block, q.start, q.index)
        levels = (m.at, m.first, m.index, m.weight, m.inverse, m.coarsest)
        matrix = (p.diagonal, p.inverse, s.start, s.neighbour, s.spring, self.block)
        bending = (s.bend_start, s.bend_neighbour, self.bend, self.bend_scale)
        if self.wide is not None:
            self.wide.solve(self.residual, (*matrix, *bending, *pairs), levels, c.tolerance, c.linear_iterations)
        else:
            limits = (BLOCKS, c.tolerance**2, c.linear_iterations, p.crew)
            vectors = (m.coarse, p.dx, p.r, p.z, p.p, p.q, p.w, p.part, p.gate, p.done)
            p.gate[:] = 0
            clock = perf_counter()
            conjugate_gradients(*[self.residual, *matrix, *bending, *pairs, *levels, *limits, *vectors])
            p.clock(perf_counter() - clock)
        self.report.linear += int(p.done[0])

    def _finish(self, x: np.ndarray, spare: np.ndarray, dt: float, h: float) -> None:
        c, r = self.config, self.report
        clock = perf_counter()
        np.copyto(spare, x)
        if self.pairs is not None:
            self.pairs.part(spare, x, self.fixed, 3)
            clock = r.clock("pairs", clock)
        least, moved = self.contact.lift(x, self.fixed, c.floor)
        # Shorter steps cure what moved through the skin; they can't help cloth shut in where the body overlaps itself.
        if least < -c.travel and dt > c.dt / 5:
            raise Rejected(self.contact.deepest_vertex, f"it went {-least * 1e3:.1f} mm into the body")
        r.deepest, r.lifted, r.steps = max(r.deepest, -least), r.lifted + moved, r.steps + 1
        self.contact.accept()
        # The corrected positions become the state; the two oldest buffers are free again.
        free = self.x_old
        self.x_old, self.v_old, self.x, self.v = self.x, self.v, x, self.v_old
        self.contact.take_over(spare, x, self.x_bar, h, dt, self.v, self.x_old)
        self.guess, self.trial = spare, free
        self.time += dt
        self.last_dt = dt
        clock = r.clock("finish", clock)
