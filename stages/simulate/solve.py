"""The simulation of a scene: frames in, frames out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import igl
import numpy as np
from scipy.spatial import cKDTree

from stages.simulate.body_motion import BodyMotion
from stages.simulate.config import SimulateConfig
from stages.simulate.contact import BodyContact
from stages.simulate.pairs import PairContact
from stages.simulate.patches import Patches
from stages.simulate.plan import BETWEEN, Plan, make_plan
from stages.simulate.runtime import start_taichi
from stages.simulate.scene import Scene
from stages.simulate.springs import Springs
from stages.simulate.stepper import Report, Stepper
from stages.simulate.watch import EVERY, Watch
from stages.spec import DataError


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


def per_vertex(scene: Scene, constant: str) -> np.ndarray:
    """A fabric constant for every vertex of the scene, shape [N]."""
    return np.concatenate([np.full(len(g.vertices), getattr(g.fabric, constant)) for g in scene.garments])


def joined(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rest vertices [N, 3], faces [F, 3], rest scale of the edges [E] and garment index [N] of all garments."""
    offset = np.cumsum([0, *(len(g.vertices) for g in scene.garments)])
    vertices = np.concatenate([g.vertices for g in scene.garments]).astype(np.float64)
    faces = np.concatenate([g.faces + o for g, o in zip(scene.garments, offset)]).astype(np.int32)
    # Edges are sorted by their first vertex, so those of the joined mesh are the garments' own in turn.
    scale = np.concatenate([g.rest_scale for g in scene.garments])
    layer = np.repeat(np.arange(len(scene.garments), dtype=np.int32), np.diff(offset))
    return vertices, faces, scale, layer


def make_springs(scene: Scene) -> Springs:
    """Springs of all garments of `scene`."""
    vertices, faces, scale, _ = joined(scene)
    names = ("density", "bend_stiffness", "stretch_limit", "stiffening", "damping")
    return Springs(
        vertices,
        faces,
        stretch_stiffness=per_vertex(scene, "sheet_stiffness"),
        rest_scale=scale,
        **{name: per_vertex(scene, name) for name in names},
    )


def refuse_inside(scene: Scene, body: BodyMotion, deepest: float) -> None:
    """Refuse cloth that starts deep inside the body: what pushed it out would fling it.

    Raises:
        DataError: Naming the deepest vertex, its depth and the limit `deepest` [m].
    """
    if not len(body.whole):
        return
    faces, start = body.whole.astype(np.int64), np.ascontiguousarray(scene.start, np.float64)
    inside = np.flatnonzero(igl.fast_winding_number(body.x, faces, start) > 0.5)
    if not len(inside):
        return
    depth = np.sqrt(igl.point_mesh_squared_distance(start[inside], body.x, faces)[0])
    if depth.max() > deepest:
        offset = np.cumsum([0, *(len(g.vertices) for g in scene.garments)])
        vertex = inside[int(np.argmax(depth))]
        number = int(np.searchsorted(offset, vertex, side="right")) - 1
        raise DataError(
            f"{scene.garments[number].name}: vertex {vertex - offset[number]} starts {1e3 * depth.max():.0f} mm inside "
            f"the body, at most {1e3 * deepest:.0f} mm can be put right; start with the cloth outside"
        )


TANGLED = 0.15
"""Share of a scene's edges that may pass through their own garment at the start: so many can be taken apart."""


def refuse_tangled(pairs: PairContact, start: np.ndarray) -> None:
    """Refuse cloth that starts so tangled with itself that it can't be told which side of it belongs where.

    Garments that start through each other have an order; see `SimulateConfig.untangle`.

    Raises:
        DataError: Naming the number of edges and one of them.
    """
    pairs.search(start, np.zeros_like(start), 1e-3)
    pairs.age = pairs.every
    pairs.find_crossings(start, np.ones(len(start), np.int32), False)
    crossed = pairs.crossings.count
    if (crossed > 0).mean() > TANGLED:
        a, b = pairs.edges[int(np.argmax(crossed))]
        raise DataError(
            f"scene: {(crossed > 0).sum()} of {len(crossed)} edges pass through their own garment at the start, "
            f"edge {a}-{b} for one, at most {TANGLED:.1%} can be put up with; untangle the garment"
        )


FIRM = 0.02
"""Least stiffness of contact at a vertex, over that of the springs at it."""


def firm_area(springs: Springs, pressure: float) -> np.ndarray:
    """Area [m^2] for which skin of stiffness `pressure` [N/m^3] pushes on each vertex, shape [N].

    Its own; more where the cloth is so stiff that it lands on few vertices with all its weight.
    """
    return np.maximum(springs.area, FIRM * spring_pull(springs) / pressure)


def spring_pull(springs: Springs) -> np.ndarray:
    """Sum of the stiffness of the springs at each vertex [N/m], shape [N]."""
    return np.bincount(springs.edges.ravel(), np.repeat(springs.stiffness, 2), len(springs.area))


STIFF = 5e6
"""Stiffness of the springs at a vertex over its mass, times the step squared, from which cloth counts as stiff."""
STIFF_ITERATIONS, STIFF_TOLERANCE = 4, 0.02


def careful(config: SimulateConfig, springs: Springs) -> SimulateConfig:
    """`config`, with more Newton iterations and a closer linear solve where most of the cloth is stiff beyond fabrics.

    What little such springs are left strained holds more energy than the cloth has from its motion.
    """
    if float(np.median(spring_pull(springs) / springs.mass)) * config.dt**2 < STIFF:
        return config
    iterations, tolerance = max(config.newton_iterations, STIFF_ITERATIONS), min(config.tolerance, STIFF_TOLERANCE)
    return replace(config, newton_iterations=iterations, tolerance=tolerance)


def make_stepper(scene: Scene, config: SimulateConfig, plan: Plan | None = None) -> Stepper:
    """A stepper at the start of `scene`; `advance_frame` keeps to the `plan`, if there is one."""
    scene.check()
    start_taichi(config.threads or None)
    springs = make_springs(scene)
    config = careful(config, springs)
    left_out = None if plan is None else plan.left_out
    body = BodyMotion(scene.body_faces, scene.body, scene.body_frames, scene.fps, left_out)
    refuse_inside(scene, body, config.deepest_start)
    vertices, faces, _, layer = joined(scene)
    patches = Patches(vertices, faces, springs.edges, layer)
    contact = BodyContact(
        body,
        patches,
        firm_area(springs, config.contact_stiffness),
        per_vertex(scene, "friction"),
        margin=config.margin,
        stiffness=config.contact_stiffness,
        damping=config.contact_damping,
        grip=config.grip,
    )
    tied = np.flatnonzero(np.concatenate([g.tied for g in scene.garments]))
    if len(tied) and len(body.whole) and config.waist_stiffness > 0:
        contact.tie(tied, np.ascontiguousarray(scene.start, np.float64), config.waist_stiffness * springs.area[tied])
    fixed = np.zeros(len(scene.start), np.int32)
    fixed[scene.pins] = 1
    held = np.array(scene.start, np.float64)

    def goal(time: float) -> np.ndarray:
        assert scene.pin_goal is not None
        held[scene.pins] = scene.pin_goal(time)
        return held

    pairs = None
    if config.self_collision:
        pairs = PairContact(
            vertices,
            patches,
            layer,
            springs.area,
            springs.mass,
            per_vertex(scene, "friction"),
            per_vertex(scene, "sheet_stiffness"),
            thickness=config.thickness,
            slack=config.pair_slack,
            untangle=config.untangle,
            stiffness=config.contact_stiffness,
            damping=config.pair_damping,
            every=config.pair_every if plan is None else plan.pair_every,
            dtype=np.float32 if config.precision == "f32" else np.float64,
        )
        refuse_tangled(pairs, np.array(scene.start, np.float64))
    stepper = Stepper(
        springs,
        contact,
        pairs,
        config,
        scene.start,
        drag=per_vertex(scene, "drag"),
        fixed=fixed,
        goal=goal if scene.pin_goal is not None else None,
        wind=scene.wind,
    )
    stepper.v[:] = scene.velocity
    stepper.first_frame = scene.record
    if plan is not None:
        stepper.watch = Watch(plan, springs)
    return stepper


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


AIR = 20.0
"""How many times thicker the air is when a scene begins to ease in."""


def ease_in(stepper: Stepper, scene: Scene, drag: np.ndarray, frame: int) -> None:
    """Set elastics and air for `frame`, so that what was made slack comes to rest on the body without a jolt.

    Garments that were made through each other are put in order in that time, from further than later.
    """
    s = min(1.0, frame / scene.ease_in) if scene.ease_in else 1.0
    springs = stepper.springs
    np.multiply(springs.length, 1 + s * (springs.rest_scale - 1), out=springs.rest_length)
    np.multiply(drag, AIR + s * (1 - AIR), out=stepper.drag)
    stepper.wind[:] = (1 - s) * scene.velocity + s * np.asarray(scene.wind)
    if stepper.pairs is not None and frame > scene.ease_in:
        stepper.pairs.untangle = 0.0


TUCKED = 0.4
"""Depth in a fold of the body at which cloth hidden there is recorded, over the distance that it keeps elsewhere."""


def presentable(stepper: Stepper) -> np.ndarray:
    """Positions (N, 3) [m] to record, nowhere inside the body; the simulation goes on from its own."""
    clock, x = perf_counter(), stepper.x.copy()
    stepper.contact.lift(x, stepper.fixed, stepper.config.floor, 12)
    stepper.contact.tuck(x, TUCKED * stepper.config.floor)
    stepper.report.clock("folds", clock)
    return x


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
    start_taichi(config.threads or None)
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
        if frame <= scene.ease_in + 1:
            ease_in(stepper, scene, drag, frame)
        advance_frame(stepper, frame)
        if frame >= scene.record:
            recorded.append(presentable(stepper))
        if observe is not None:
            observe(frame, stepper)
        if progress is not None:
            progress(frame, scene.frames)
    return Solution(np.stack(recorded), stepper.report, stepper.springs, watch.record())
