"""Solves one extreme case and judges what came out, by measures that aren't the solver's own."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from time import perf_counter
from typing import Any
from unittest.mock import patch

import igl
import numpy as np

from model.mesh.intersection import self_intersecting_faces
from stages.simulate import solve as solving
from stages.simulate.config import SimulateConfig
from stages.simulate.scene import Scene
from stages.simulate.stepper import Stepper
from stages.spec import DataError
from tools.solver.energy import Energy, EnergyMeter
from tools.solver.extreme_cases import Case

ENERGY_SLACK = 0.01
"""By how much energy may grow where nothing moves, as a share of the greatest fall in height energy so far."""
RESTING_SPEED = 0.01
"""Cloth no faster than this on average counts as at rest [m/s]: the slack where there is no fall."""
BODY_SHARE = 3.0
"""Greatest speed of cloth over that of the body or pins which moves it: 2 is an elastic hit, the rest whip."""
DEPTH = 0.5e-3
"""Depth in the body that counts as penetration [m]."""
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
        energy_gain: Greatest energy less that of the start, over the greatest fall in height energy.
        depth_start_mm, depth_worst_mm, depth_end_mm: In the body.
        crossings_start, crossings_end: Pairs of faces of the cloth that pass through each other.
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
    energy_gain: float | None = None
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

    def begin(self, stepper: Stepper) -> None:
        """Take note of the start."""
        self.stepper = stepper
        self.meter = EnergyMeter(self.scene, stepper.springs, self.gravity)
        self.look()

    def look(self, *_: int) -> None:
        """Take note of the state."""
        assert self.stepper is not None
        x, v = self.stepper.x, self.stepper.v
        self.energies.append(self.meter(x, v))
        self.speeds.append(float(np.linalg.norm(v, axis=1).max()))


def judge(case: Case, threads: int = 0) -> Verdict:
    """Solve `case` and judge it."""
    config = SimulateConfig(threads=threads, **case.settings)
    try:
        scene = case.build()
    except DataError as error:
        return Verdict("refused", f"before the scene: {error}")
    watch = Watch(scene, config.gravity)
    make = solving.make_stepper

    def watched(scene: Scene, config: SimulateConfig) -> Stepper:
        stepper = make(scene, config)
        watch.begin(stepper)
        return stepper

    verdict = Verdict("finite", vertices=len(scene.start), frames=scene.frames)
    clock = perf_counter()
    try:
        with patch.object(solving, "make_stepper", watched):
            solution = solving.solve(scene, config, watch.look)
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
    mass = float(watch.stepper.springs.mass.sum())
    start = watch.energies[0]
    fall = max(start.height - min(e.height for e in watch.energies), 0.0)
    verdict.max_speed = round(max(watch.speeds), 3)
    faults = []
    if case.still:
        gain = max(e.total for e in watch.energies) - start.total
        scale = max(fall, 0.5 * mass * RESTING_SPEED**2 / ENERGY_SLACK)
        verdict.energy_gain = round(gain / scale, 5)
        if gain > ENERGY_SLACK * scale:
            frame = int(np.argmax([e.total for e in watch.energies]))
            faults.append(f"energy grew by {100 * gain / scale:.1f} % of the fall, greatest in frame {frame}")
    else:
        drop = scene.start[:, 2].max() - watch.stepper.x[:, 2].min()
        bound = BODY_SHARE * fastest_drive(scene) + np.sqrt(2 * 9.81 * max(drop, 0.0)) + case.push
        verdict.speed_bound = round(float(bound), 3)
        if verdict.max_speed > bound:
            frame = int(np.argmax(watch.speeds))
            faults.append(f"cloth reached {verdict.max_speed:.1f} m/s in frame {frame}, more than {bound:.1f}")
    return faults


def fastest_drive(scene: Scene) -> float:
    """Greatest speed of any body vertex or pin from frame to frame, or of the cloth at the start [m/s]."""
    fastest = float(np.linalg.norm(scene.velocity))
    for k in range(1, scene.body_frames):
        step = np.linalg.norm(scene.body(k) - scene.body(k - 1), axis=1).max(initial=0.0)
        fastest = max(fastest, float(step) * scene.fps)
    if scene.pin_goal is not None:
        goals = [scene.pin_goal(k / scene.fps).copy() for k in range(scene.frames + 1)]
        steps = np.linalg.norm(np.diff(goals, axis=0), axis=2)
        fastest = max(fastest, float(steps.max(initial=0.0)) * scene.fps)
    return fastest


def _places(scene: Scene, x: np.ndarray, verdict: Verdict) -> list[str]:
    """Faults in the recorded positions x (T, N, 3): not finite, in the body."""
    finite = np.isfinite(x).all((1, 2))
    if not finite.all():
        return [f"frame {int(np.argmin(finite))} isn't finite"]
    _, faces, _, _ = solving.joined(scene)
    if len(faces) <= MOST_FACES:
        verdict.crossings_start = len(self_intersecting_faces(scene.start, faces))
        verdict.crossings_end = len(self_intersecting_faces(x[-1], faces))
    if not len(scene.body_faces):
        return []
    looks = np.unique(np.linspace(0, len(x) - 1, LOOKS).round().astype(int))
    start = depth_in_body(scene, scene.start, 0)
    depths = [depth_in_body(scene, x[k], scene.record + int(k)) for k in looks]
    verdict.depth_start_mm, verdict.depth_worst_mm, verdict.depth_end_mm = (
        round(1e3 * d, 3) for d in (start, max(depths), depths[-1])
    )
    faults = []
    if max(depths) > max(start, DEPTH):
        frame = int(looks[int(np.argmax(depths))])
        faults.append(f"{1e3 * max(depths):.1f} mm inside the body in frame {frame}, {1e3 * start:.1f} at the start")
    if depths[-1] > DEPTH:
        faults.append(f"still {1e3 * depths[-1]:.1f} mm inside the body at the end")
    return faults


def depth_in_body(scene: Scene, x: np.ndarray, frame: int) -> float:
    """Greatest depth [m] of any vertex of x (N, 3) in the body of `frame`, 0 if none."""
    surface = np.ascontiguousarray(scene.body(min(frame, scene.body_frames - 1)), np.float64)
    faces = np.ascontiguousarray(scene.body_faces, np.int64)
    distance = igl.signed_distance(np.ascontiguousarray(x, np.float64), surface, faces)[0]
    return max(0.0, -float(distance.min()))
