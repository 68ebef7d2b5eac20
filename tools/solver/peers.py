"""The solver and Blender in turn on common scenes: `python -m tools.solver.peers --peers FOLDER`.

Both are scored by the peers' own script. Absolute times drift on shared machines, so that the speed is the ratio of the
two solvers in the same round; the median over the rounds counts.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from tools.solver import tables
from tools.solver.blender import LIMIT, PYTHON, Blender
from tools.solver.child import ROOT, Ended, run
from tools.solver.statistics import errors

SCENES = ("A", "A20", "C", "B128")
STANDARD, BLENDER = "standard", "Blender 14"
QUALITY, FINE_QUALITY = 14, 56
"""Blender's steps a frame, and those of the reference for its own error: four times as many."""

HORIZON = 33
"""Frames for which references are solved: a second, and two for the body's motion to be the same up to there."""

COLUMNS = {
    "scene": "scene",
    "solver": "solver",
    "wall": "s per simulated s",
    "range": "least to most",
    "setup_s": "set-up [s]",
    "ratio": "Blender's time over this",
    "error_0.5s_mm": "own error to 0.5 s [mm]",
    "error_1s_mm": "to 1 s [mm]",
    "strain_mean": "strain mean",
    "strain_p99": "p99",
    "stretch_max": "max",
    "penetration_mm_max": "penetration [mm]",
    "self_intersections_max": "self-intersections",
    "peak_memory_mb": "memory [MB]",
    "load": "load",
    "fault": "fault",
}

TEXT = """# Beside Blender on common scenes

`make peers` makes this table: level `standard` and Blender's cloth (Cotton, {quality} steps a frame, self-collision) in
turn, {runs} rounds, {cores} cores; `s per simulated s` is the median, the ratio the median of each round's. Blender's
time is that of its frames after the first, ours that of all; both leave out start-up and setting up the scene, which
takes us `set-up` seconds, however long the scene is. `load` is the load average when the first round began. The scorer
is the peers' own: strain of the edges over all frames, penetration and self-intersections the worst of the frames
scored.

A solver's own error is that against its own reference over the first 0.5 s and 1 s: for `preview` and `standard` level
`reference`, whose step is a ninth of standard's; for Blender {fine} steps a frame. References are solved for the first
second alone; their own errors are unmeasured here, see the [curve](curve.md).

Commit {commit}, {date}, {processor}.

"""


@dataclass(frozen=True)
class Bench:
    """What is measured with.

    Attributes:
        blender: The runner; work: folder of the trajectories; frames: to simulate, 0 for all.
    """

    blender: Blender
    work: Path
    frames: int

    def scene(self, name: str, most: int = 0) -> Path:
        """The scene's file; a copy if it is cut, to `frames` or to `most`."""
        path = self.blender.folder / "scenes" / f"{name}.npz"
        frames = min((n for n in (self.frames, most) if n), default=0)
        if not frames:
            return path
        short = self.work / f"{name}-first{frames}.npz"
        if not short.exists():
            with np.load(path) as data:
                arrays = {key: data[key] for key in data.files}
            for key in ("body_v", "pin_pos"):
                arrays[key] = arrays[key][:frames]
            np.savez(short, **{**arrays, "frames": min(frames, int(arrays["frames"]))})
        return short

    def out(self, name: str, solver: str) -> Path:
        """The trajectory of a solver on a scene."""
        return self.work / f"{name}-{solver.replace(' ', '')}.npz"

    def ours(self, name: str, level: str, most: int = 0) -> Ended:
        """Solve a scene at a level of accuracy, all of it or `most` frames."""
        scene, out = self.scene(name, most), self.out(name, level)
        return run([sys.executable, "-m", "stages.simulate", "scene", scene, "--out", out, "--accuracy", level], LIMIT)

    def theirs(self, name: str, quality: int, most: int = 0) -> Ended:
        """Simulate a scene with Blender, all of it or `most` frames."""
        return self.blender(self.scene(name, most), self.out(name, f"Blender {quality}"), quality)

    def score(self, name: str, solver: str) -> dict[str, Any]:
        """The neutral scorer's figures."""
        command = [sys.executable, self.blender.folder / "measure.py", self.scene(name), self.out(name, solver)]
        scored = run(command, LIMIT)
        return {"fault": f"score: {scored.fault}"} if scored.fault else scored.line


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure; 0 if nothing failed."""
    parser = argparse.ArgumentParser(prog="python -m tools.solver.peers", description="Run the solver beside Blender.")
    parser.add_argument("--peers", type=Path, default=ROOT.parent / "shared" / "peers", help="the peers' folder")
    parser.add_argument("--blender", type=Path, default=PYTHON, help="Python that has bpy")
    parser.add_argument("--scenes", default=",".join(SCENES), help="scenes of that folder")
    parser.add_argument("--runs", type=int, default=3, help="rounds")
    parser.add_argument("--frames", type=int, default=0, help="frames of every scene, the start counted; 0 for all")
    parser.add_argument("--no-self-errors", action="store_true", help="leave out the references, which take longest")
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "peers", help="folder of the trajectories")
    parser.add_argument("--out", type=Path, default=tables.DOCS, help="folder of the table")
    given = parser.parse_args(arguments)
    bench = Bench(Blender(given.blender.absolute(), given.peers.resolve()), given.work.resolve(), given.frames)
    if bench.blender.missing:
        parser.error(bench.blender.missing)
    names = given.scenes.split(",")
    absent = [name for name in names if not (bench.blender.folder / "scenes" / f"{name}.npz").exists()]
    if absent:
        parser.error(f"{bench.blender.folder / 'scenes'} holds no {absent[0]}.npz")
    bench.work.mkdir(parents=True, exist_ok=True)
    about = {**tables.made(), "runs": given.runs, "frames": given.frames}
    rows = [row for name in names for row in measure(bench, name, given.runs, not given.no_self_errors)]
    publish(rows, about, given.out)
    return 1 if any(row.get("fault") for row in rows) else 0


def measure(bench: Bench, name: str, runs: int, self_errors: bool) -> list[dict[str, Any]]:
    """Rows of one scene: both solvers in turn, `runs` times; then the levels and references that own errors need."""
    times: dict[str, list[Ended]] = {STANDARD: [], BLENDER: []}
    load = round(os.getloadavg()[0], 2)
    for number in range(runs):
        for solver in (BLENDER, STANDARD):
            # What an earlier round wrote must not be scored as this one's.
            bench.out(name, solver).unlink(missing_ok=True)
            ended = bench.ours(name, solver) if solver == STANDARD else bench.theirs(name, QUALITY)
            times[solver].append(ended)
            _tell(name, f"{solver}, round {number + 1}", ended)
    rows = [_row(bench, name, solver, ended, load) for solver, ended in times.items()]
    rounds = [(_wall(a), _wall(b)) for a, b in zip(times[BLENDER], times[STANDARD])]
    both = [(a, b) for a, b in rounds if a and b]
    if both:
        ratios = [a / b for a, b in both]
        rows[0] |= {"ratio": median(ratios), "ratios": ratios, "walls_in_turn": [b for _, b in both]}
    if self_errors:
        for solver, solve in (
            ("preview", lambda: bench.ours(name, "preview")),
            ("reference", lambda: bench.ours(name, "reference", HORIZON)),
            (f"Blender {FINE_QUALITY}", lambda: bench.theirs(name, FINE_QUALITY, HORIZON)),
        ):
            ended = solve()
            _tell(name, solver, ended)
            rows.append(_row(bench, name, solver, [ended], load))
        _own_errors(bench, name, rows)
    return rows


def _tell(name: str, what: str, ended: Ended) -> None:
    print(f"{name}, {what}: {ended.fault or format(_wall(ended), '.3g') + ' s per simulated s'}", flush=True)


def _wall(ended: Ended) -> float:
    return 0.0 if ended.fault else float(ended.line["wall_s_per_simulated_s"])


def _row(bench: Bench, name: str, solver: str, runs: Sequence[Ended], load: float) -> dict[str, Any]:
    """Times and scores of one solver on one scene; a run that failed is named, the others count."""
    row: dict[str, Any] = {"scene": name, "solver": solver, "load": load}
    faults = [ended.fault for ended in runs if ended.fault]
    good = [ended for ended in runs if not ended.fault]
    if good:
        walls = sorted(_wall(ended) for ended in good)
        row |= {"wall": median(walls), "walls": walls, "range": f"{walls[0]:.3g} to {walls[-1]:.3g}"}
        row["peak_memory_mb"] = round(max(ended.peak_mb for ended in good))
        row |= {key: good[-1].line[key] for key in ("setup_s", "steps", "halvings") if key in good[-1].line}
        row |= bench.score(name, solver)
    if faults:
        row["fault"] = "; ".join([*faults, *([row["fault"]] if row.get("fault") else [])])
    return row


def _own_errors(bench: Bench, name: str, rows: Sequence[dict[str, Any]]) -> None:
    """Add every solver's error against its own reference to its row, where both were solved."""
    pairs = {"preview": "reference", STANDARD: "reference", BLENDER: f"Blender {FINE_QUALITY}"}
    for row in rows:
        best = pairs.get(row["solver"])
        paths = [] if best is None else [bench.out(name, row["solver"]), bench.out(name, best)]
        if not paths or not all(path.exists() for path in paths):
            continue
        with np.load(bench.scene(name)) as scene:
            fps = float(scene["fps"])
        row |= errors(np.load(paths[0])["x"], np.load(paths[1])["x"], fps)


def publish(rows: Sequence[dict[str, Any]], about: dict[str, Any], folder: Path) -> None:
    """Write peers.json and peers.md into `folder`."""
    text = TEXT.format(
        quality=QUALITY, fine=FINE_QUALITY, **{k: about[k] for k in ("runs", "cores", "commit", "date", "processor")}
    )
    tables.write("peers", {"made": about, "rows": list(rows)}, text + tables.table(COLUMNS, rows), folder)


if __name__ == "__main__":
    sys.exit(main())
