"""Solves one extreme case and judges what came out, by measures that aren't the solver's own."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from time import perf_counter
from typing import Any

import igl
import numpy as np

from model.mesh.intersection import self_intersecting_faces
from stages.simulate.config import SimulateConfig
from stages.simulate.make_stepper import joined
from stages.simulate.scene import Scene
from stages.simulate.solve import solve
from stages.simulate.stepper import Stepper
from stages.spec import DataError
from tools.solver.energy import Energy, EnergyMeter
from tools.solver.extreme_cases import Case

ENERGY_SLACK = 0.01
"""By how much energy may exceed what was put in, as a share of the greatest fall in height energy."""
RESTING_SPEED = 0.01
"""Cloth no faster than this on average counts as at rest [m/s]: the slack where there is no fall."""
BOUNCE = 2.0
"""Speed over that of what hit it, of cloth that bounces off without loss."""
WHIP = 5.0
"""Greatest speed of any vertex over that of body, pins and free fall together: hems crack like whips."""
DEPTH = 0.5e-3
"""Depth in the body that counts as penetration [m]."""
LASTING = 5
"""Frames at the end of which the least tangled counts: crossings that come and go within them don't last."""
TANGLED = 0.0005
"""Crossings that last count as a failure from so many, as a share of the faces: the table shows all."""
ROUNDING = 1e-6
"""Of depths [m]."""
LOOKS = 40
"""Frames in which depth is measured."""
MOST_FACES = 50_000
"""Meshes larger than this aren't searched for self-intersections."""


@dataclass
class Verdict:
    """What came out of a case; figures that don't apply are None.

    Attributes:
        outcome: "finite", "refused" (before the first step) or "FAILED"; reason: of a refusal or a failure.
        vertices, frames, steps, halvings: Counts; wall_s: time in the solver [s].
        max_speed, speed_bound: Of the cloth, at the end of any frame [m/s].
        energy_gain_j, energy_bound_j: Greatest energy less that of the start, and what may have been put in [J].
        depth_start_mm, depth_worst_mm, depth_end_mm: In the body.
        crossings_start, crossings_end: Pairs of faces of the cloth that pass through each other; the fewest of the last
            frames.
    """

    outcome: str
    reason: str = ""
    vertices: int = 0
    frames: int = 0
    steps: int = 0
    halvings: int = 0
    wall_s: float = 0.0
    max_speed: float | None = None
    speed_bound: float | None = None
    energy_gain_j: float | None = None
    energy_bound_j: float | None = None
    depth_start_mm: float | None = None
    depth_worst_mm: float | None = None
    depth_end_mm: float | None = None
    crossings_start: int | None = None
    crossings_end: int | None = None

    def row(self) -> dict[str, Any]:
        """The verdict as JSON values."""
        return asdict(self)


class Watch:
    """Looks at the stepper at the end of every frame."""

    def __init__(self, scene: Scene, gravity: float) -> None:
        self.scene, self.gravity = scene, gravity
        self.stepper: Stepper | None = None
        self.energies: list[Energy] = []
        self.speeds: list[float] = []

    def look(self, frame: int, stepper: Stepper) -> None:
        """Take note of the state at the end of `frame`."""
        if self.stepper is None:
            self.stepper = stepper
            self.meter = EnergyMeter(self.scene, stepper.springs, self.gravity)
        self.energies.append(self.meter(stepper.x, stepper.v))
        self.speeds.append(float(np.linalg.norm(stepper.v, axis=1).max()))


def judge(case: Case, threads: int = 0) -> Verdict:
    """Solve `case` and judge it."""
    config = SimulateConfig(threads=threads, **case.settings)
    try:
        scene = case.build()
    except DataError as error:
        return Verdict("refused", f"before the scene: {error}")
    watch = Watch(scene, config.gravity)
    verdict = Verdict("finite", vertices=len(scene.start), frames=scene.frames)
    clock = perf_counter()
    try:
        solution = solve(scene, config, observe=watch.look)
    except DataError as error:
        begun = watch.stepper is not None and watch.stepper.report.steps > 0
        verdict.outcome, verdict.reason = ("FAILED", f"gave up: {error}") if begun else ("refused", str(error))
        return verdict
    finally:
        verdict.wall_s = round(perf_counter() - clock, 2)
    verdict.steps, verdict.halvings = solution.report.steps, solution.report.halvings
    faults = [*_motion(case, scene, watch, verdict), *_places(scene, solution.x, verdict)]
    if faults:
        verdict.outcome, verdict.reason = "FAILED", "; ".join(faults)
    return verdict


def _motion(case: Case, scene: Scene, watch: Watch, verdict: Verdict) -> list[str]:
    """Faults in speed and energy."""
    if not np.isfinite(watch.speeds).all():
        return [f"not finite in frame {int(np.argmin(np.isfinite(watch.speeds)))}"]
    assert watch.stepper is not None
    start, mass = watch.energies[0], float(watch.stepper.springs.mass.sum())
    fall = max(start.height - min(e.height for e in watch.energies), 0.0)
    slack = max(ENERGY_SLACK * fall, 0.5 * mass * RESTING_SPEED**2)
    drive, rise = (0.0, 0.0) if case.still else driven(scene)
    if case.push and len(scene.body_faces):
        rise += depth_in_body(scene, scene.start, 0)
    put_in = 0.5 * mass * ((BOUNCE * drive) ** 2 + case.push**2) + mass * abs(watch.gravity) * rise
    # What a start in the wrong place holds in its contacts, stretch and bending may take over: a sleeve too tight.
    totals = [(e.free - start.free) if case.push else (e.total - start.total) for e in watch.energies]
    gain = max(totals)
    drop = float(scene.start[:, 2].max() - watch.stepper.x[:, 2].min())
    bound = WHIP * (drive + np.sqrt(2 * abs(watch.gravity) * max(drop, 0.0)) + RESTING_SPEED) + case.push
    verdict.energy_gain_j, verdict.energy_bound_j = float(f"{gain:.3g}"), float(f"{put_in + slack:.3g}")
    verdict.max_speed, verdict.speed_bound = round(max(watch.speeds), 3), round(float(bound), 3)
    faults = []
    if gain > put_in + slack:
        frame = int(np.argmax(totals))
        share = f", {100 * gain / fall:.1f} % of the fall" if fall > 0 else ""
        faults.append(
            f"energy grew by {gain:.2g} J, more than {put_in + slack:.2g} J{share}, greatest in frame {frame}"
        )
    if verdict.max_speed > bound:
        frame = int(np.argmax(watch.speeds))
        faults.append(f"cloth reached {verdict.max_speed:.1f} m/s in frame {frame}, more than {bound:.1f}")
    return faults


def driven(scene: Scene) -> tuple[float, float]:
    """Greatest speed [m/s] of any body vertex or pin from frame to frame, and how far any rises [m]."""
    speed, low, high = float(np.linalg.norm(scene.velocity)), np.inf, -np.inf
    before = None
    for k in range(max(scene.body_frames, scene.frames + 1 if scene.pin_goal is not None else 0)):
        now = np.asarray(scene.body(min(k, scene.body_frames - 1)), np.float64)
        if scene.pin_goal is not None:
            now = np.concatenate([now, scene.pin_goal(k / scene.fps)])
        if before is not None and len(now):
            step = now - before
            speed = max(speed, float(np.linalg.norm(step, axis=1).max()) * scene.fps)
        if len(now):
            low, high = min(low, float(now[:, 2].mean())), max(high, float(now[:, 2].mean()))
        before = now
    return speed, max(high - low, 0.0) if np.isfinite(low) else 0.0


def _places(scene: Scene, x: np.ndarray, verdict: Verdict) -> list[str]:
    """Faults in the recorded positions x (T, N, 3): not finite, in the body."""
    finite = np.isfinite(x).all((1, 2))
    if not finite.all():
        return [f"frame {int(np.argmin(finite))} isn't finite"]
    _, faces, _, _ = joined(scene)
    if len(faces) <= MOST_FACES:
        verdict.crossings_start = len(self_intersecting_faces(scene.start, faces))
        verdict.crossings_end = min(len(self_intersecting_faces(y, faces)) for y in x[1:][-LASTING:])
    faults = []
    allowed = (verdict.crossings_start or 0) + TANGLED * len(faces)
    if verdict.crossings_start is not None and (verdict.crossings_end or 0) > allowed:
        faults.append(
            f"{verdict.crossings_end} crossings of its own at the end, {verdict.crossings_start} at the start"
        )
    if not len(scene.body_faces):
        return faults
    looks = np.unique(np.linspace(1, len(x) - 1, LOOKS).round().astype(int))
    start = depth_in_body(scene, scene.start, 0)
    depths = [depth_in_body(scene, x[k], scene.record + int(k)) for k in looks]
    verdict.depth_start_mm, verdict.depth_worst_mm, verdict.depth_end_mm = (
        round(1e3 * d, 3) for d in (start, max(depths), depths[-1])
    )
    if max(depths) > max(start, DEPTH) + ROUNDING:
        frame = int(looks[int(np.argmax(depths))])
        faults.append(f"{1e3 * max(depths):.1f} mm inside the body in frame {frame}, {1e3 * start:.1f} at the start")
    if depths[-1] > DEPTH + ROUNDING:
        faults.append(f"still {1e3 * depths[-1]:.1f} mm inside the body at the end")
    return faults


def depth_in_body(scene: Scene, x: np.ndarray, frame: int) -> float:
    """Greatest depth [m] of any vertex of x (N, 3) in the body of `frame`, 0 if none."""
    surface = np.ascontiguousarray(scene.body(min(frame, scene.body_frames - 1)), np.float64)
    faces = np.ascontiguousarray(scene.body_faces, np.int64)
    distance = igl.signed_distance(np.ascontiguousarray(x, np.float64), surface, faces)[0]
    return max(0.0, -float(distance.min()))
