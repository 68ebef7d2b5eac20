"""The shell of the simulate stage: reads body and outfit, simulates, measures, publishes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stages.body_model import load_body_model
from stages.settings import build
from stages.simulate import SPEC
from stages.simulate.collider import closed, refuse_covered
from stages.simulate.config import SimulateConfig
from stages.simulate.error_bars import solve_with_bars
from stages.simulate.outfit_scene import dress, make_garment, split
from stages.simulate.quality import measure
from stages.simulate.record import counts, forget_peak, peak_memory_mb
from stages.spec import Progress, Task
from store import publish, read


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Simulates one outfit on one body sequence; returns figures for the receipt.

    Raises:
        DataError: The scene can't be simulated: a broken mesh, a body that isn't finite, a step that fails.
    """
    forget_peak()
    config = build(SimulateConfig, task.config)
    body, outfit = (read(*_place(task, stage)) for stage in ("body", "outfit"))
    about = outfit.attrs["garments"]
    garments = [
        make_garment(
            name,
            outfit[f"garments/{name}/vertices"],
            outfit[f"garments/{name}/faces"],
            outfit[f"garments/{name}/elastic"],
            outfit[f"garments/{name}/waistband"],
            about[name],
        )
        for name in outfit.attrs["layers"]
    ]
    trans, fps = np.asarray(body["trans"], np.float64), float(body.attrs["fps"])
    left_out = body.attrs.get("collision", {}).get("left_out", [])
    kept = np.asarray(body["face_kept"], bool) if left_out else np.ones(len(body["faces"]), bool)
    refuse_covered(left_out, {g.name: g.vertices for g in garments}, body["rest_vertices"], body["faces"], kept)
    scene, way = dress(
        garments,
        load_body_model(body.attrs).pose,
        closed(body["faces"], kept),
        rest_pose=body["rest_pose"],
        betas=body["betas"],
        tight_betas=outfit["tight_betas"],
        pose=body["pose"],
        trans=trans,
        vertices=body["vertices"],
        fps=fps,
        config=config,
    )
    solution, bars = solve_with_bars(scene, config, lambda done, total, label: progress(done, total + 1, label))
    springs, report = solution.springs, solution.report
    quality = measure(
        solution.x,
        springs.edges[: springs.woven],
        springs.rest_length[: springs.woven],
        lambda k: scene.body(scene.record + k),
        scene.body_faces,
    )
    quality |= counts(report) | {"seconds_transition": len(way.vertices) / fps} | bars.summary()
    arrays = bars.arrays() | {f"garments/{g.name}/faces": g.faces for g in garments}
    for name, x in split(solution.x, garments, trans).items():
        arrays[f"garments/{name}/vertices"] = x
    attrs = {"left_out": left_out, "fps": fps, "garments": about, "layers": outfit.attrs["layers"]}
    attrs |= {"quality": quality, "plan": solution.plan}
    publish(Path(task.output), SPEC.schema, task.key, arrays, attrs)
    spent = report.seconds | {f"error bars, {kind}": value for kind, value in bars.seconds.items()}
    seconds = {part: round(value, 2) for part, value in spent.items()}
    # Memory and time differ from run to run: they go into the receipt, and the shard keeps equal bytes.
    return quality | {"vertices": solution.x.shape[1], "peak_memory_mb": peak_memory_mb(), "seconds": seconds}


def _place(task: Task, stage: str) -> tuple[Path, str, str]:
    path, key = task.input(stage)
    return path, stage, key
