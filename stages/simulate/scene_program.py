"""`python -m stages.simulate scene SCENE.npz --out OUT.npz`: solves a scene file and says how fast."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

import numpy as np

from stages.simulate.config import LEVELS, SimulateConfig
from stages.simulate.fabric import Fabric, named_fabric
from stages.simulate.record import counts, peak_memory_mb
from stages.simulate.scene import Garment, Scene
from stages.simulate.scene_file import SceneFile, read_scene
from stages.simulate.solve import solve
from stages.simulate.springs import unique_edges
from stages.spec import DataError


def main(arguments: Sequence[str]) -> int:
    """Solve the scene named in `arguments`; 0 if it went well, 65 if the scene is at fault."""
    parser = argparse.ArgumentParser(prog="python -m stages.simulate scene", description="Solve a cloth scene file.")
    parser.add_argument(
        "scene", type=Path, help="scene .npz: cloth_v, cloth_f, body_v, body_f, pins, pin_pos, fps, frames"
    )
    parser.add_argument("--out", type=Path, required=True, help=".npz to write: x (frames + 1, N, 3) [m]")
    parser.add_argument("--accuracy", choices=tuple(LEVELS), default="standard", help="level of accuracy")
    parser.add_argument("--device", choices=("cpu", "gpu"), default="cpu", help="where the kernels run")
    parser.add_argument("--dt", type=float, help="longest time step [s], instead of the level's")
    parser.add_argument(
        "--fabric", help="a fabric of stages/fabrics.toml, or a .toml file of that form with one fabric"
    )
    given = parser.parse_args(arguments)
    try:
        fabric = named_fabric(given.fabric) if given.fabric else Fabric()
        config = SimulateConfig(accuracy=given.accuracy, dt=given.dt, device=given.device)
        return _solve(read_scene(given.scene), fabric, config, given.out)
    except DataError as error:
        print(error, file=sys.stderr)
        return 65


def _solve(file: SceneFile, fabric: Fabric, config: SimulateConfig, out: Path) -> int:
    scene = scene_of(file, fabric)
    # A first step compiles the kernels, or loads them; neither that nor what comes before the first step is timed.
    solve(Scene(**{**scene.__dict__, "frames": 1}), config)
    clock = perf_counter()
    solution = solve(scene, config)
    before = solution.report.seconds["set-up"] + solution.report.seconds["plan"]
    wall = perf_counter() - clock - before
    np.savez(out, x=solution.x.astype(np.float32))
    report = solution.report
    line = {
        "wall_s_per_simulated_s": wall / (scene.frames / scene.fps),
        "setup_s": round(before, 3),
        **counts(report),
        "peak_memory_mb": peak_memory_mb(),
        "plan": solution.plan,
        "seconds": {part: round(spent, 3) for part, spent in report.seconds.items()},
    }
    print(json.dumps(line))
    return 0


def scene_of(file: SceneFile, fabric: Fabric) -> Scene:
    """The scene that a file describes, of one fabric; pins move straight from frame to frame."""
    count = len(file.cloth_v)
    garment = Garment(
        name="cloth",
        vertices=file.cloth_v,
        faces=file.cloth_f,
        fabric=fabric,
        rest_scale=np.ones(len(unique_edges(file.cloth_f)[0])),
        tied=np.zeros(count, bool),
    )
    last = len(file.pin_pos) - 1

    def pin_goal(time: float) -> np.ndarray:
        place = min(time * file.fps, last)
        k = min(int(place), max(last - 1, 0))
        s = place - k
        goal: np.ndarray = (1 - s) * file.pin_pos[k] + s * file.pin_pos[min(k + 1, last)]
        return goal

    still = np.zeros((0, 3))
    return Scene(
        garments=[garment],
        start=file.cloth_v,
        body_faces=file.body_f.reshape(-1, 3),
        body=(lambda k: file.body_v[k]) if len(file.body_v) else (lambda k: still),
        body_frames=max(len(file.body_v), 1),
        frames=file.frames,
        fps=file.fps,
        pins=file.pins,
        pin_goal=pin_goal if len(file.pins) else None,
    )
