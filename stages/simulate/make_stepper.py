"""From a scene and the knobs to a stepper at its start: springs, contact with skin, contact of cloth with cloth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stages.simulate.body_motion import BodyMotion
from stages.simulate.config import SimulateConfig
from stages.simulate.contact import BodyContact
from stages.simulate.pairs import PairContact
from stages.simulate.patches import Patches
from stages.simulate.plan import Plan
from stages.simulate.refusals import refuse_inside, refuse_tangled
from stages.simulate.runtime import start_taichi
from stages.simulate.scene import Scene
from stages.simulate.springs import Springs
from stages.simulate.stepper import Stepper
from stages.simulate.watch import Watch


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
    offset = np.cumsum([0, *(len(g.vertices) for g in scene.garments)])
    return Springs(
        vertices,
        faces,
        stretch_stiffness=per_vertex(scene, "sheet_stiffness"),
        rest_scale=scale,
        cords=np.concatenate([g.cords + o for g, o in zip(scene.garments, offset)]),
        cord_length=np.concatenate([g.cord_length for g in scene.garments]),
        **{name: per_vertex(scene, name) for name in names},
    )


FIRM, FIRMER = 0.02, 0.2
"""Least stiffness of contact at a vertex, over that of the springs at it: of cloth, and of what counts as stiff."""


def firm_area(springs: Springs, pressure: float, dt: float) -> np.ndarray:
    """Area [m^2] for which skin of stiffness `pressure` [N/m^3] pushes on each vertex in steps of `dt` [s], shape [N].

    Its own; more where the cloth is so stiff that it lands on few vertices with all its weight.
    """
    pull = spring_pull(springs)
    firm = np.where(pull / springs.mass * dt**2 < STIFF, FIRM, FIRMER)
    return np.maximum(springs.area, firm * pull / pressure)


def spring_pull(springs: Springs) -> np.ndarray:
    """Sum of the stiffness of the springs at each vertex [N/m], shape [N]."""
    return np.bincount(springs.edges.ravel(), np.repeat(springs.stiffness, 2), len(springs.area))


STIFF = 5e6
"""Stiffness of the springs at a vertex over its mass, times the step squared, from which cloth counts as stiff."""
STIFF_ITERATIONS, STIFF_TOLERANCE, STIFF_STEPS = 4, 0.02, 4


def careful(config: SimulateConfig, springs: Springs) -> SimulateConfig:
    """`config`, with shorter steps, solved more closely, in f64, where most of the cloth is stiff beyond fabrics.

    What little such springs are left strained holds more energy than the cloth has from its motion.
    """
    if float(np.median(spring_pull(springs) / springs.mass)) * config.dt**2 < STIFF:
        return config
    iterations, tolerance = max(config.newton_iterations, STIFF_ITERATIONS), min(config.tolerance, STIFF_TOLERANCE)
    dt = min(config.dt, max(config.dt / STIFF_STEPS, 2 * config.shortest_dt))
    return replace(config, newton_iterations=iterations, tolerance=tolerance, precision="f64", dt=dt)


def make_stepper(scene: Scene, config: SimulateConfig, plan: Plan | None = None) -> Stepper:
    """A stepper at the start of `scene`; `advance_frame` keeps to the `plan`, if there is one."""
    scene.check()
    start_taichi(config.threads or None, config.device)
    springs = make_springs(scene)
    config = careful(config, springs)
    left_out = None if plan is None else plan.left_out
    body = BodyMotion(scene.body_faces, scene.body, scene.body_frames, scene.fps, left_out)
    refuse_inside(scene, body, config.deepest_start)
    vertices, faces, _, layer = joined(scene)
    patches = Patches(vertices, faces, springs.edges[: springs.woven], layer)
    contact = BodyContact(
        body,
        patches,
        firm_area(springs, config.contact_stiffness, config.dt),
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
