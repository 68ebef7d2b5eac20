"""The simulation of a scene: frames in, frames out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from stages.simulate.config import SimulateConfig
from stages.simulate.make_stepper import make_stepper
from stages.simulate.plan import BETWEEN, Plan, make_plan
from stages.simulate.runtime import start_taichi
from stages.simulate.scene import Scene
from stages.simulate.springs import Springs
from stages.simulate.stepper import Report, Stepper
from stages.simulate.watch import EVERY


@dataclass(frozen=True)
class Solution:
    """What came out.

    Attributes:
        x: Positions [m] of the recorded frames, shape [T, N, 3], float64.
        report: Counts and timings of the run.
        springs: The springs, whose rest lengths tell the strain.
        plan: What was left out and why, and what had to be turned on after all, as JSON values.
    """

    x: np.ndarray
    report: Report
    springs: Springs
    plan: dict[str, Any]


def fastest_pass(stepper: Stepper, frame: int, cloth: cKDTree) -> float:
    """Greatest speed [m/s] at which skin that can reach the cloth during `frame` moves into it.

    Speed along the skin counts a third: it takes cloth round corners. Body vertices too far away to get to any cloth,
    however fast they are, don't count. `cloth` holds every EVERY-th vertex.
    """
    body = stepper.contact.body
    # Neighbours move alike: a part of the vertices tells, if what lies between them is allowed for.
    some = body.followed_vertices
    if not len(some):
        return 0.0
    beyond = 4 * stepper.config.travel + BETWEEN
    before, a, b, after = (body.frame(k)[some] for k in range(frame - 2, frame + 2))
    # The body's motion is the cubic that has these slopes at its ends.
    slopes, v = (b - a, 0.5 * (b - before), 0.5 * (after - a)), stepper.v[::EVERY]
    quickest = max(float(np.linalg.norm(m, axis=1).max()) for m in (*slopes, v / body.fps))
    distance, nearest = cloth.query(a, distance_upper_bound=2 * quickest + beyond, workers=1)
    near = np.isfinite(distance)
    distance, nearest = distance[near], nearest[near]
    way = (stepper.x[::EVERY][nearest] - a[near]) / np.maximum(distance, 1e-9)[:, None]
    fastest = 0.0
    for slope in slopes:
        velocity = slope[near] * body.fps - v[nearest]
        speed = np.linalg.norm(velocity, axis=1)
        into = np.maximum((velocity * way).sum(1), speed / 3)
        fastest = max(fastest, float(into[distance < speed / body.fps + beyond].max(initial=0.0)))
    return fastest


AIR, STARCH = 20.0, 30.0
"""How many times thicker the air is, and how many times stiffer cloth bends, when a scene begins to ease in."""
SUPPLE = 6
"""Frames before the first recorded one from which on cloth bends as its fabric does."""


def ease_in(stepper: Stepper, scene: Scene, drag: np.ndarray, frame: int) -> None:
    """Set elastics, air and bending for `frame`, so that what was made slack comes to rest on the body without a jolt.

    A garment is made without a fold. Left to itself it would crumple where it first gives way, and stay so for a second
    or two; starched at first it falls into few large folds, which get their small ones as it becomes supple.
    """
    s = min(1.0, frame / scene.ease_in) if scene.ease_in else 1.0
    springs = stepper.springs
    np.multiply(springs.length, 1 + s * (springs.rest_scale - 1), out=springs.rest_length)
    np.multiply(drag, AIR + s * (1 - AIR), out=stepper.drag)
    stepper.wind[:] = (1 - s) * scene.velocity + s * np.asarray(scene.wind)
    starched = max(0.0, 1 - frame / max(scene.record - SUPPLE, 1)) if scene.ease_in else 0.0
    springs.stiffen(STARCH**starched)
    stepper.bend[:] = springs.bend


PUT_IN_ORDER = 6
"""Frames, at least, in which garments that start through each other are put in the order of their layers."""


def leave_order(stepper: Stepper, scene: Scene, frame: int) -> None:
    """From `frame` on garments stay on the sides they are on, once they were put in order.

    A hem may fly up over what is worn over it; drawn back through that, it would tangle.
    """
    if stepper.pairs is not None and frame > max(scene.ease_in, PUT_IN_ORDER):
        stepper.pairs.untangle = 0.0


TUCKED = 0.4
"""Depth in a fold of the body at which cloth hidden there is recorded, over the distance that it keeps elsewhere."""


def presentable(stepper: Stepper) -> np.ndarray:
    """Positions (N, 3) [m] to record: as little as can be inside the body, below skin and across each other; the
    simulation goes on from its own."""
    clock, x, floor = perf_counter(), stepper.shown, stepper.config.floor
    np.copyto(x, stepper.x)
    stepper.contact.lift(x, stepper.fixed, floor, 12)
    stepper.contact.tuck(x, TUCKED * floor)
    clock = stepper.report.clock("folds", clock)
    stepper.cover(x, stepper.fixed, floor)
    clock = stepper.report.clock("cover", clock)
    if stepper.tidy is not None:
        stepper.tidy(x, stepper.fixed, floor)
        stepper.report.clock("tidy", clock)
    return x.copy()


def advance_frame(stepper: Stepper, frame: int, share: float = 1.0) -> None:
    """Go on to `frame`, in steps that are `share` of those that its motion needs."""
    clock, watch, steps = perf_counter(), stepper.watch, stepper.report.steps
    stepper.fastest = 0.0
    if len(stepper.contact.body.whole):
        cloth = cKDTree(stepper.x[::EVERY])
        if watch is not None:
            watch.look(stepper, frame, cloth)
        # Twice the speed at the frame's start: cloth that falls onto a body speeds up within the frame.
        stepper.fastest = 2 * fastest_pass(stepper, frame, cloth)
    longest = stepper.config.dt if watch is None else watch.longest(stepper, frame, share)
    dt = min(longest, 2 * stepper.config.travel / max(stepper.fastest, 1e-9))
    stepper.report.clock("step size", clock)
    stepper.advance_to(frame / stepper.contact.body.fps, share * dt)
    if watch is not None:
        watch.steps[frame] = stepper.report.steps - steps


def solve(
    scene: Scene,
    config: SimulateConfig,
    progress: Callable[[int, int], None] | None = None,
    observe: Callable[[int, Stepper], None] | None = None,
    plan: Plan | None = None,
) -> Solution:
    """Simulate `scene`.

    Args:
        scene: The scene.
        config: The knobs.
        progress: Told (done, total) after every frame.
        observe: Shown (frame, stepper) at frame 0 and after every frame; may look, but not touch.
        plan: What to leave out; made for the scene if not given.

    Raises:
        DataError: If the scene can't be simulated, or a step fails at the floor of the step size.
    """
    scene.check()
    clock = perf_counter()
    start_taichi(config.threads or None, config.device)
    plan = make_plan(scene, config) if plan is None else plan
    planned = perf_counter() - clock
    clock = perf_counter()
    stepper = make_stepper(scene, config, plan)
    stepper.report.clock("set-up", clock)
    stepper.report.seconds["plan"] = planned
    watch = stepper.watch
    assert watch is not None
    recorded = [stepper.x.copy()] if scene.record == 0 else []
    drag = stepper.drag.copy()
    if observe is not None:
        observe(0, stepper)
    for frame in range(1, scene.frames + 1):
        if frame <= max(scene.ease_in + 1, scene.record):
            ease_in(stepper, scene, drag, frame)
        leave_order(stepper, scene, frame)
        advance_frame(stepper, frame)
        if frame >= scene.record:
            recorded.append(presentable(stepper))
        if observe is not None:
            observe(frame, stepper)
        if progress is not None:
            progress(frame, scene.frames)
    return Solution(np.stack(recorded), stepper.report, stepper.springs, watch.record())
