"""The curve's scenes and settings, as data, and the solving of one point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from stages.simulate.config import SimulateConfig
from stages.simulate.fabric import Fabric
from stages.simulate.make_stepper import joined
from stages.simulate.scene import Scene
from stages.simulate.scene_file import read_scene
from stages.simulate.scene_program import scene_of
from stages.simulate.solve import solve
from tools.solver.people import person
from tools.solver.statistics import statistics

FINE = {"newton_iterations": 4, "newton_tolerance": 1e-6, "tolerance": 0.01, "calm": 1.0}

POINTS: dict[str, dict[str, Any]] = {
    "preview": {"accuracy": "preview"},
    "standard, step 1/60": {"dt": 1 / 60, "calm": 1.0},
    "standard": {},
    "standard, Euler": {"integrator": "euler", "calm": 1.0},
    "standard, 4 Newton": FINE,
    "fine": {"accuracy": "fine"},
    "step 1/480, 4 Newton": {"dt": 1 / 480, **FINE},
    "reference": {"accuracy": "reference"},
    "reference, half step": {"accuracy": "reference", "dt": 1 / 3840},
}
"""Knobs of every point. All but the last two are compared with "reference", whose step is a quarter of the finest."""

REFERENCE, FINEST = "reference", "reference, half step"
LEVELS = ("preview", "standard", "fine", "reference")
QUICK = ("preview", "standard", "step 1/480, 4 Newton")
"""Points of the reduced set, whose yardstick is the last of them and only shows that the command works."""


@dataclass(frozen=True, kw_only=True)
class CurveScene:
    """A scene of the curve.

    Attributes:
        title: For tables and plots.
        file: Scene file in the peers' folder, or "" for a person of the pipeline's own.
        body: Whether the file's body is there.
        build: Makes the person.
        frames: Frames to solve, 0 for all.
        half_step: Whether the reference is solved at half its step too, for its own error.
        blender: Whether Blender's curve is measured too, which takes longest.
    """

    title: str
    file: str = ""
    body: bool = True
    build: Callable[[], Scene] | None = None
    frames: int = 0
    half_step: bool = False
    blender: bool = True


# The transition is part of the scene, so that both start from the same state; brisk, as the reference takes hours.
BRISK = SimulateConfig(settle_frames=0, shape_speed=1.0, pose_speed=3.0)


def _worn(gender: str, outfit: str, betas: tuple[float, ...], motion: str, start: int) -> Callable[[], Scene]:
    return partial(person, gender, outfit, betas, motion=motion, start=start, frames=16, edge=0.014, config=BRISK)


SCENES = {
    "A": CurveScene(title="A: tube dress on a walker", file="A.npz", frames=32),
    "A-free": CurveScene(title="A without the body", file="A.npz", body=False, frames=32),
    "C": CurveScene(title="C: sheet dropped on a ball", file="C.npz", frames=32, blender=False),
    "B64": CurveScene(title="B64: sheet hung from two corners", file="B64.npz", frames=32, half_step=True),
    "shirt": CurveScene(
        title="t-shirt and trousers, walk", build=_worn("male", "tshirt+trousers", (0.5, 0.5), "walk", 0)
    ),
    "dress": CurveScene(title="dress, dance", build=_worn("female", "dress", (0.0, -0.5), "dance", 0)),
    "skirt": CurveScene(title="top and skirt, turn", build=_worn("female", "top+skirt", (-0.5, 0.5), "turn", 30)),
}


def build(scene: CurveScene, peers: Path | None, frames: int = 0) -> Scene:
    """The scene, from its first frame on; cut to its own number of frames, or to `frames` if that isn't 0."""
    frames = frames or scene.frames
    if scene.build is not None:
        made = scene.build()
    else:
        assert peers is not None
        file = read_scene(peers / "scenes" / scene.file)
        if not scene.body:
            file = replace(file, body_v=np.zeros((0, 0, 3)), body_f=np.zeros((0, 3), np.int32))
        made = scene_of(file, Fabric())
    made = replace(made, record=0)
    return replace(made, frames=min(frames, made.frames)) if frames else made


def measure(name: str, point: str, peers: Path | None, frames: int, threads: int, out: Path) -> dict[str, Any]:
    """Solve a point; writes its positions x (T, N, 3) to `out`, returns its figures."""
    scene = build(SCENES[name], peers, frames)
    config = SimulateConfig(threads=threads, **POINTS[point])
    # A first frame compiles the kernels, or loads them: no part of the time, as set-up and plan aren't.
    solve(replace(scene, frames=1), config)
    clock = perf_counter()
    solution = solve(scene, config)
    wall = perf_counter() - clock - sum(solution.report.seconds[part] for part in ("set-up", "plan"))
    x = solution.x.astype(np.float32)
    np.savez(out, x=x)
    rest, faces, _, _ = joined(scene)
    report = solution.report
    return {
        "wall_s_per_simulated_s": wall / (scene.frames / scene.fps),
        "vertices": len(rest),
        "frames": scene.frames,
        "fps": scene.fps,
        "steps": report.steps,
        "halvings": report.halvings,
        "newton_iterations": report.newton,
        "linear_iterations": report.linear,
        "statistics": statistics(x, rest, faces, scene.fps, len(x) // 2),
    }
