"""Error bars: parts of a sequence simulated again, at half the step and on a finer mesh, and how far they differ.

A window starts from the sequence's own state at its first frame, so that what is measured is the error that builds up
within it, not the drift of two sequences that have parted. The integrator is of second order: the step's error is
about 4/3 of its difference, where the step is short enough. On the finer mesh the state is interpolated linearly, flat
across each old triangle; that it has to round its folds first is part of the difference.

Cloth in contact is chaotic: of a leather skirt and a cotton top on a walking person, moved by noise of 1 um, vertices
were 0.03 mm apart (RMS) after one frame and 1.5 mm after five; half the step made it 0.2 and 4.4 mm.
So the first frames of a window tell of the solver, and the last ones of how far its positions can be predicted at all.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import islice
from time import perf_counter

import numpy as np

from stages.simulate.config import SimulateConfig
from stages.simulate.finer import Finer, cut_in_four
from stages.simulate.make_stepper import make_stepper
from stages.simulate.plan import make_plan
from stages.simulate.scene import Scene
from stages.simulate.snapshot import Snapshot, restore, take
from stages.simulate.solve import Solution, advance_frame, ease_in, leave_order, presentable, solve
from stages.simulate.stepper import Stepper
from stages.spec import DataError

log = logging.getLogger(__name__)

COST = {"step": 2, "mesh": 12}
"""About how many frames of the sequence a frame costs at half the step, and on the finer mesh (measured on a skirt and
top of 16,700 vertices: 2.2 and 13); for the progress."""


class Windows:
    """Where to look, and the state at the start of each window; an observer for `solve`.

    Attributes:
        starts: Frame of the scene that each window starts from, apart and spread evenly over what is recorded.
        length: Frames that are compared in each, those after its start.
        states: The state at each start that has been observed.
    """

    def __init__(self, scene: Scene, config: SimulateConfig) -> None:
        room = scene.frames - scene.record
        self.length = min(config.error_bar_frames, room)
        count = min(config.error_bar_windows, room // self.length) if room > 0 else 0
        self.starts = [scene.record + int((k + 0.5) * room / count - self.length / 2) for k in range(count)]
        self.states: dict[int, Snapshot] = {}

    def __call__(self, frame: int, stepper: Stepper) -> None:
        """Keep the state at `frame`, if a window starts there."""
        if frame in self.starts:
            self.states[frame] = take(stepper)

    @property
    def cost(self) -> int:
        """About how many frames of the sequence it costs to compare them all."""
        return len(self.starts) * self.length * sum(COST.values())


@dataclass(frozen=True, kw_only=True)
class ErrorBars:
    """How far the cloth at half the step ("step"), and on the finer mesh ("mesh"), is from the sequence.

    Attributes:
        garments: Their names.
        frames: Recorded frame that each figure belongs to, shape [W, L].
        errors: By kind, root of the mean square and maximum [m] of the distance between the vertices of the sequence
            and their second positions, shape [W, L, garments, 2].
        failed: Windows of which a second simulation failed; they aren't among W.
        seconds: Time spent, by kind.
    """

    garments: list[str]
    frames: np.ndarray
    errors: dict[str, np.ndarray]
    failed: int = 0
    seconds: dict[str, float]

    def arrays(self) -> dict[str, np.ndarray]:
        """What is stored with the sequence, by the names of its schema; nothing if there is no window."""
        if not len(self.frames):
            return {}
        found = {"error_frames": self.frames}
        for kind, errors in self.errors.items():
            for i, garment in enumerate(self.garments):
                found[f"garments/{garment}/{kind}_error_rms"] = errors[:, :, i, 0]
                found[f"garments/{garment}/{kind}_error_max"] = errors[:, :, i, 1]
        return found

    def summary(self) -> dict[str, float]:
        """RMS of the garments' at the windows' last frames, and the greatest anywhere [m]; what failed, if any."""
        found: dict[str, float] = {}
        if len(self.frames):
            for kind, errors in self.errors.items():
                found[f"{kind}_error_rms_m"] = float(np.sqrt((errors[:, -1, :, 0] ** 2).mean()))
                found[f"{kind}_error_max_m"] = float(errors[..., 1].max())
        if self.failed:
            found["error_windows_failed"] = self.failed
        return found


def solve_with_bars(
    scene: Scene, config: SimulateConfig, progress: Callable[[float, float, str], None]
) -> tuple[Solution, ErrorBars]:
    """Simulate `scene`, and its windows again if the knob `error_bars` says so; `progress(done, total, label)`.

    Raises:
        DataError: If the scene can't be simulated, or a step fails at the floor of the step size.
    """
    windows = Windows(scene, config) if config.error_bars else None
    total = scene.frames + (windows.cost if windows else 0)
    solution = solve(scene, config, lambda done, last: progress(done, total, f"frame {done} of {last}"), windows)
    if windows is None:
        return solution, ErrorBars(garments=[], frames=np.zeros((0, 0), np.int32), errors={}, seconds={})
    bars = compare(
        scene, config, windows, solution.x, lambda spent: progress(scene.frames + spent, total, "error bars")
    )
    return solution, bars


def simulate_again(
    scene: Scene, config: SimulateConfig, share: float
) -> Callable[[Snapshot, int], Iterator[np.ndarray]]:
    """A function of a state and its frame that yields the positions (N, 3) [m] of the frames after it.

    Args:
        scene: The scene.
        config: The knobs of the sequence.
        share: Length of a step over that in the sequence.
    """
    stepper = make_stepper(scene, config, make_plan(scene, config))
    drag = stepper.drag.copy()

    def follow(state: Snapshot, start: int) -> Iterator[np.ndarray]:
        restore(stepper, state)
        for frame in range(start + 1, scene.frames + 1):
            ease_in(stepper, scene, drag, frame)
            leave_order(stepper, scene, frame)
            advance_frame(stepper, frame, share)
            yield presentable(stepper)

    return follow


def compare(
    scene: Scene,
    config: SimulateConfig,
    windows: Windows,
    x: np.ndarray,
    progress: Callable[[float], None] = lambda spent: None,
) -> ErrorBars:
    """Simulate each window twice more.

    A window that can't be simulated again says nothing against the sequence: it is left out, counted and logged.

    Args:
        scene: The scene.
        config: The knobs of the sequence.
        windows: What `solve` has shown of it.
        x: Its recorded positions [m], shape [T, N, 3].
        progress: Told after every frame how much of `windows.cost` is spent.
    """
    finer = cut_in_four(scene)
    at_half_step, on_finer_mesh = simulate_again(scene, config, 0.5), simulate_again(finer.scene, config, 1.0)
    names = [g.name for g in scene.garments]
    parts = np.cumsum([len(g.vertices) for g in scene.garments])[:-1]
    errors: dict[str, list[np.ndarray]] = {"step": [], "mesh": []}
    seconds = dict.fromkeys(errors, 0.0)
    starts, spent = [], 0.0
    for start in windows.starts:
        state, first = windows.states[start], start + 1 - scene.record
        ways = {
            "step": at_half_step(state, start),
            "mesh": (y[finer.old] for y in on_finer_mesh(_spread(state, finer), start)),
        }
        window: dict[str, np.ndarray] = {}
        try:
            for kind, way in ways.items():
                clock = perf_counter()
                found = []
                for k, y in enumerate(islice(way, windows.length), start=first):
                    apart = np.split(np.linalg.norm(y - x[k], axis=1), parts)
                    found.append([(np.sqrt((d**2).mean()), d.max()) for d in apart])
                    spent += COST[kind]
                    progress(spent)
                window[kind] = np.array(found)
                seconds[kind] += perf_counter() - clock
        except DataError as error:
            log.warning("error bars: the window from frame %d on is left out: %s", first - 1, error)
            continue
        starts.append(first)
        for kind, values in window.items():
            errors[kind].append(values)
    return ErrorBars(
        garments=names,
        frames=(np.array(starts, np.int32).reshape(-1, 1) + np.arange(windows.length)).astype(np.int32),
        errors={kind: np.array(values) for kind, values in errors.items()},
        failed=len(windows.starts) - len(starts),
        seconds=seconds,
    )


def _spread(state: Snapshot, finer: Finer) -> Snapshot:
    """The state on the finer mesh; its pairs of cloth and the preconditioner are to be made anew."""
    cloth, contact = (
        {name: finer.spread(values) for name, values in kept.items()} for kept in (state.cloth, state.contact)
    )
    contact["reaction"] /= 4  # a force, of a quarter of the area
    return replace(state, cloth=cloth, contact=contact, levels={}, pairs={})
