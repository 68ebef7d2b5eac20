"""The plan of a scene: what its simulation can do without, decided before it from what will move where.

Nothing is left out for good: `Watch` checks during the run what the plan takes for granted, and turns on what is needed
after all. What would save nothing is kept, whatever the scene: drag, elastics and stiffening are terms of kernels that
run anyway, and garments that don't meet are parted by the boxes of their patches; the plan only says if they matter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.simulate.body_motion import BodyMotion
from stages.simulate.config import SimulateConfig
from stages.simulate.contact import BodyContact
from stages.simulate.reach import Forecast, foresee_reach
from stages.simulate.scene import Scene
from stages.simulate.springs import unique_edges

ITEMS = ("body", "pairs", "steps")
"""What a plan decides: which skin is left out, whether pairs of cloth are kept for several steps, the step of each
frame. An item that isn't decided is everything: all skin, pairs looked for in every step, the shortest step of all."""

BRISK = 1.0
"""Speed of the cloth from which on it needs the level's step [m/s]; the error of a step of second order grows with the
speed and the step squared."""
BETWEEN = 0.02
"""Distance of cloth from the nearest skin vertex of those that tell its speed, at most about this [m]."""
PRELUDE = 3
"""The last frames before the first recorded one, in which steps are as in those."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What is planned.

    Attributes:
        decided: Those of ITEMS that were.
        forecast: What was foreseen of the scene.
        left_out [P]: Patches of the body, as `BodyMotion` cuts it, that the cloth isn't expected to come near.
        guard: How near [m]: further away they can neither touch it nor have a say in the length of its steps.
        pair_every: Most steps for which pairs of cloth are kept.
        step: The level's step that it was made for [s].
        dt [T + 1]: Longest step in each frame [s]; calm [T + 1]: whether cloth that moves fast forbids it.
        steps [T + 1]: How many steps each frame is expected to take.
        record: The plan, its bounds and why, as JSON values.
    """

    decided: tuple[str, ...]
    forecast: Forecast
    left_out: np.ndarray
    guard: float
    pair_every: int
    step: float
    dt: np.ndarray
    calm: np.ndarray
    steps: np.ndarray
    record: dict[str, Any]


def make_plan(scene: Scene, config: SimulateConfig, decide: tuple[str, ...] | None = None) -> Plan:
    """The plan of `scene`; `decide` names the ITEMS to be decided, by the knob `plan` if left out."""
    decided = decide if decide is not None else (ITEMS if config.plan == "scene" else ())
    body = BodyMotion(scene.body_faces, scene.body, scene.body_frames, scene.fps)
    guard = max(config.margin + BodyContact.SPARE + BodyContact.SURPRISE, 4 * config.travel + BETWEEN)
    forecast = foresee_reach(scene, body, guard)
    left_out = (forecast.gap > guard) if "body" in decided else np.zeros(len(forecast.gap), bool)
    dt, calm = _longest_steps(scene, config, forecast, "steps" in decided)
    # Skin may go `travel` past cloth in a step; cloth is counted on to come half way.
    needed = np.minimum(dt, np.maximum(config.travel / np.maximum(forecast.into, 1e-9), config.shortest_dt))
    steps = np.ceil(1 / (scene.fps * needed) - 1e-6).astype(int)
    if "steps" not in decided:
        steps[:] = steps.max()
        dt = np.full(len(dt), 1 / (scene.fps * steps[0]))
    size = np.diff(body.patch_start)
    record = {
        "decided": list(decided),
        "body_faces": {
            "all": len(body.faces),
            "left_out": int(size[left_out].sum()),
            "least_distance_m": float(forecast.gap[left_out].min()) if left_out.any() else None,
            "guard_m": guard,
        },
        "garments": _garments(scene, forecast),
        "pairs": {"kept_for_steps": config.pair_every if "pairs" in decided else 1},
        "steps": {
            "shortest_s": config.shortest_dt,
            "longest_s": float(dt.max()),
            "fastest_skin_into_cloth_m_s": float(forecast.into.max()),
            "planned": steps[1:].tolist(),
        },
        "forces": _forces(scene, config, forecast),
    }
    return Plan(
        decided=decided,
        forecast=forecast,
        left_out=left_out,
        guard=guard,
        pair_every=config.pair_every if "pairs" in decided else 1,
        step=config.dt,
        dt=dt,
        calm=calm,
        steps=steps,
        record=record,
    )


def longer(speed: Any, most: float) -> Any:
    """How many times the level's step is short enough at `speed` [m/s]: at most `most`, 1 from BRISK on."""
    return np.clip(np.sqrt(BRISK / np.maximum(speed, 1e-9)), 1.0, most)


def _longest_steps(
    scene: Scene, config: SimulateConfig, forecast: Forecast, decided: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Longest step of every frame [s], and whether it holds only while the cloth is slow."""
    ratio, calm = np.ones(scene.frames + 1), np.zeros(scene.frames + 1, bool)
    if decided:
        ratio[:] = longer(np.maximum(forecast.speed, forecast.into), config.calm)
        calm[:] = True
        # Nobody sees the transition: it has to end well, not to be right on its way.
        unseen = max(0, scene.record - PRELUDE)
        if unseen:
            ratio[: unseen + 1], calm[: unseen + 1] = config.calm, False
    return np.minimum(config.dt * ratio, max(config.dt, 1 / scene.fps)), calm


def _garments(scene: Scene, forecast: Forecast) -> list[dict[str, Any]]:
    """Which garments can meet, and how far from each other the others stay at least [m]."""
    names = [g.name for g in scene.garments]
    return [
        {"pair": [names[i], names[j]], "meet": distance <= 0, "least_distance_m": distance}
        for (i, j), distance in forecast.apart.items()
    ]


def _forces(scene: Scene, config: SimulateConfig, forecast: Forecast) -> dict[str, Any]:
    """Bounds of what air, elastics and stiffening can do, for the garment where each does most."""
    air, hung, pulled, tight = 0.0, 0.0, 0, 0.0
    offset = 0
    for g in scene.garments:
        f, weight = g.fabric, g.fabric.density * abs(config.gravity)
        air = max(air, f.drag * forecast.fastest / max(weight, 1e-9))
        # What hangs by a strip of itself, all of it as far below as the cloth is long.
        hung = max(hung, weight * min(forecast.length, 1e3) / f.sheet_stiffness / max(f.stretch_limit, 1e-9))
        pulled += int((g.rest_scale != 1).sum())
        edges, _ = unique_edges(g.faces)
        x = scene.start[offset : offset + len(g.vertices)]
        rest = np.linalg.norm(g.vertices[edges[:, 0]] - g.vertices[edges[:, 1]], axis=1) * g.rest_scale
        strain = np.linalg.norm(x[edges[:, 0]] - x[edges[:, 1]], axis=1) / np.maximum(rest, 1e-9) - 1
        tight = max(tight, float(strain.max(initial=0.0)) / max(f.stretch_limit, 1e-9))
        offset += len(g.vertices)
    return {
        "air": {"over_weight": float(air), "matters": bool(air > 0.01)},
        "elastics": {"edges": pulled, "matters": pulled > 0},
        "strain_limit": {
            "hanging_strain_over_limit": float(hung),
            "starting_strain_over_limit": float(tight),
            "matters": bool(max(hung, tight) > 1),
        },
    }
