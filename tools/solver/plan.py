"""What the plan of a scene gains and costs: `python -m tools.solver.plan` solves scenes with everything and without.

In every round each variant of a scene is solved in turn, and the ratio is taken within the round, as the speed of a
machine drifts. The time to make the plan counts for those that need one.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from stages.simulate.config import SimulateConfig
from stages.simulate.fabric import Fabric
from stages.simulate.make_stepper import joined
from stages.simulate.plan import ITEMS, make_plan
from stages.simulate.runtime import start_taichi
from stages.simulate.scene import Scene
from stages.simulate.scene_file import read_scene
from stages.simulate.scene_program import scene_of
from stages.simulate.solve import solve
from stages.simulate.stepper import Stepper
from tools.solver import tables
from tools.solver.child import ROOT
from tools.solver.judging import depth_in_body
from tools.solver.people import person
from tools.solver.plan_plot import plot
from tools.solver.plan_text import describe, text_of
from tools.solver.statistics import errors, relative, statistics

WORN: dict[str, tuple[str, dict[str, Any]]] = {
    "shirt": (
        "t-shirt and trousers, walk",
        {"gender": "male", "outfit": "tshirt+trousers", "betas": (0.5, 0.5), "motion": "walk"},
    ),
    "dress": (
        "dress, dance",
        {"gender": "female", "outfit": "dress", "betas": (0.0, -0.5), "motion": "dance"},
    ),
    "skirt": (
        "top and skirt, turn",
        {"gender": "female", "outfit": "top+skirt", "betas": (-0.5, 0.5), "motion": "turn", "start": 30},
    ),
}
"""The pipeline's own scenes, transition included, as every sequence has one."""
FRAMES = 60
"""Frames of the sequence after the transition."""
COMMON = {"A": "tube dress on a walker", "C": "sheet dropped on a ball", "B64": "sheet hung from two corners"}
"""Scenes of the peers' folder."""

EVERYTHING, HALF, WHOLE = "everything", "everything, half step", "plan"
VARIANTS: dict[str, tuple[str, ...]] = {
    EVERYTHING: (),
    "body faces": ("body",),
    "pairs of cloth": ("pairs",),
    "steps": ("steps",),
    WHOLE: ITEMS,
}
"""What is decided in each variant; the rest is as in `everything`."""
FORCES = ("without air", "without elastics", "without strain limit")
"""Variants in which the scene itself lacks a force: what leaving it out could gain, and what would be wrong."""
LOOKS = 20
"""Frames in which depth in the body is measured."""


@dataclass
class Measured:
    """What is measured of a variant of a scene: all rounds' times [s], and the rest from the first round.

    Attributes:
        x: Positions in all frames, shape [T + 1, N, 3]; row: figures of the table; record: the plan's.
    """

    x: np.ndarray
    row: dict[str, Any]
    record: dict[str, Any]
    seconds: list[float] = field(default_factory=list)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the plans; 0 unless the arguments are wrong."""
    parser = argparse.ArgumentParser(prog="python -m tools.solver.plan", description="Measure what a plan gains.")
    parser.add_argument("--peers", type=Path, default=ROOT.parent / "shared" / "peers", help="the peers' folder")
    parser.add_argument("--scenes", help=f"of {','.join([*WORN, *COMMON])}; all there are if left out")
    parser.add_argument("--rounds", type=int, default=3, help="how often each variant is solved")
    parser.add_argument("--quick", action="store_true", help="one round of few frames: does it work?")
    parser.add_argument("--threads", type=int, default=0, help="CPU threads; 0 for all")
    parser.add_argument("--out", type=Path, help="folder of the table; docs/solver if left out, unless --quick")
    given = parser.parse_args(arguments)
    known = [*WORN, *(name for name in COMMON if (given.peers / "scenes" / f"{name}.npz").exists())]
    names = given.scenes.split(",") if given.scenes else known
    unknown = [name for name in names if name not in known]
    if unknown:
        parser.error(f"no scene is called {unknown[0]!r}; there are {', '.join(known)}")
    if len(known) == len(WORN):
        print(f"{given.peers}: no peers' scenes there; only the pipeline's own are measured", file=sys.stderr)
    config = SimulateConfig(threads=given.threads)
    rounds = 1 if given.quick else given.rounds
    about = {**tables.made(), "rounds": rounds, "threads": start_taichi(given.threads or None)}
    scenes = {}
    for name in names:
        scenes[name] = compare(build(name, given.peers, given.quick), config, rounds, name)
        scenes[name]["title"] = WORN[name][0] if name in WORN else COMMON[name]
    folder = given.out or (ROOT / "build" / "plan" if given.quick else tables.DOCS)
    tables.write("plan", {"made": about, "scenes": scenes}, text_of(scenes, about), folder)
    plot(scenes, folder / "plan.png")
    return 0


def build(name: str, peers: Path, quick: bool) -> Scene:
    """The scene called `name`; a short one if `quick`."""
    if name in WORN:
        return person(**WORN[name][1], frames=4 if quick else FRAMES, edge=0.014)
    scene = scene_of(read_scene(peers / "scenes" / f"{name}.npz"), Fabric())
    return replace(scene, frames=8) if quick else scene


def without(scene: Scene, force: str) -> Scene:
    """`scene` whose garments lack one of FORCES."""
    garments = []
    for g in scene.garments:
        if force == FORCES[0]:
            g = replace(g, fabric=replace(g.fabric, drag=0.0))
        elif force == FORCES[1]:
            g = replace(g, rest_scale=np.ones_like(g.rest_scale))
        else:
            g = replace(g, fabric=replace(g.fabric, stiffening=1.0))
        garments.append(g)
    return replace(scene, garments=garments)


def compare(scene: Scene, config: SimulateConfig, rounds: int, name: str) -> dict[str, Any]:
    """Solve every variant of `scene` in turn, `rounds` times: the rows of its table, and its plan."""
    ways: dict[str, tuple[Scene, SimulateConfig, tuple[str, ...]]] = {
        label: (scene, config, decide) for label, decide in VARIANTS.items()
    }
    pulled = any((g.rest_scale != 1).any() for g in scene.garments)
    ways |= {force: (without(scene, force), config, ()) for force in FORCES if pulled or force != FORCES[1]}
    solve(replace(scene, frames=1, record=0), config)  # compiles the kernels, or loads them
    found: dict[str, Measured] = {}
    for number in range(rounds):
        # There and back, so that none is always the first.
        for label, (variant, settings, decide) in list(ways.items())[:: 1 if number % 2 == 0 else -1]:
            taken = measure(variant, settings, decide, label != EVERYTHING and label not in FORCES)
            found.setdefault(label, taken).seconds.append(taken.row["wall_s"])
            print(f"{name}, round {number + 1}, {label}: {taken.row['wall_s']:.2f} s", flush=True)
    # How far everything is from its own limit tells what a difference means. Fast motion has steps by what it travels.
    found[HALF] = measure(scene, replace(config, dt=config.dt / 2, travel=config.travel / 2), (), False)
    found[HALF].seconds.append(found[HALF].row["wall_s"])
    base = found[EVERYTHING]
    rows = []
    for label, one in found.items():
        gain = [a / b for a, b in zip(base.seconds, one.seconds)] if label != HALF else []
        row = {"variant": label, **one.row, "wall_s": float(np.median(one.seconds))}
        row |= {"gain": float(np.median(gain)), "gain_min": min(gain), "gain_max": max(gain)} if gain else {}
        if label != EVERYTHING:
            row |= errors(one.x, base.x, scene.fps)
            row["same_bits"] = bool(np.array_equal(one.x, base.x))
        row["relative"] = relative(row.pop("statistics"), base.row["statistics"])
        row["left_out"], row["bound"] = describe(label, one.record, base.record, found[WHOLE].record)
        rows.append(row)
    return {
        "vertices": len(scene.start),
        "frames": scene.frames,
        "recorded_from": scene.record,
        "plan": found[WHOLE].record,
        "rows": rows,
    }


def measure(scene: Scene, config: SimulateConfig, decide: tuple[str, ...], counted: bool) -> Measured:
    """Solve `scene` once; the time to make the plan counts if `counted`."""
    x: list[np.ndarray] = []

    def keep(frame: int, stepper: Stepper) -> None:
        x.append(stepper.x.copy())

    clock = perf_counter()
    plan = make_plan(scene, config, decide)
    made = perf_counter() - clock
    clock = perf_counter()
    solution = solve(scene, config, observe=keep, plan=plan)
    wall = perf_counter() - clock - solution.report.seconds["set-up"] + (made if counted else 0.0)
    rest, faces, _, _ = joined(scene)
    shown = solution.x
    looks = np.unique(np.linspace(0, len(shown) - 1, LOOKS).round().astype(int))
    depth = 0.0
    if len(scene.body_faces):
        depth = max(depth_in_body(scene, shown[k], scene.record + int(k)) for k in looks)
    row = {
        "wall_s": wall,
        "wall_s_per_simulated_s": wall / (scene.frames / scene.fps),
        "plan_s": made,
        "steps": solution.report.steps,
        "halvings": solution.report.halvings,
        "depth_mm": 1e3 * depth,
        "events": solution.plan["events"],
        "statistics": statistics(shown, rest, faces, scene.fps, len(shown) // 2),
    }
    return Measured(np.stack(x), row, solution.plan)


if __name__ == "__main__":
    sys.exit(main())
