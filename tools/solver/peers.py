"""The solver and Blender in turn on common scenes: `python -m tools.solver.peers --peers FOLDER`.

Both are scored by the peers' own script. Absolute times drift on shared machines, so that the speed is the ratio of the
two solvers in the same round; the median over the rounds counts.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from tools.solver import tables
from tools.solver.blender import LIMIT, PYTHON, Blender
from tools.solver.child import ROOT, Ended, run
from tools.solver.kept import once, sources
from tools.solver.statistics import errors

SCENES = ("A", "A20", "C", "B128")
STANDARD, FINE, BLENDER = "standard", "fine", "Blender 14"
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
    "commit": "commit",
    "fault": "fault",
}

TEXT = """# Beside Blender on common scenes

`make peers` makes this table: level `standard` and Blender's cloth (Cotton, {quality} steps a frame, self-collision) in
turn, {runs} rounds, {cores} cores; `s per simulated s` is the median, the ratio the median of each round's. Blender's
time is that of its frames after the first, ours that of all; both leave out start-up and setting up the scene, which
with its plan takes us `set-up` seconds. `load` is the load average when the first round began. The scorer is the peers'
own: strain of the edges over all frames, penetration and self-intersections the worst of the frames scored.

A solver's own error is that against its own reference over the first 0.5 s and 1 s: for our levels `reference`, whose
step is an eighth of fine's; for Blender {fine} steps a frame, four times as many. References are solved for the first
second alone; their own errors are unmeasured here. They and `preview` are solved once, not in turn, perhaps while the
machine has other work: their times say little. Scenes that weren't measured again stay as they were, by the commit in
their rows.

Last made at commit {commit}, {date}, {processor}.

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
        judge = self.blender.folder / "measure.py"
        scored = run([sys.executable, judge, self.scene(name), self.out(name, solver)], LIMIT)
        return {"fault": f"score: {scored.fault}"} if scored.fault else scored.line


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure; 0 if nothing failed."""
    parser = argparse.ArgumentParser(prog="python -m tools.solver.peers", description="Run the solver beside Blender.")
    parser.add_argument("--peers", type=Path, default=ROOT.parent / "shared" / "peers", help="the peers' folder")
    parser.add_argument("--blender", type=Path, default=PYTHON, help="Python that has bpy")
    parser.add_argument("--scenes", default=",".join(SCENES), help="scenes of that folder")
    parser.add_argument("--runs", type=int, default=3, help="rounds")
    parser.add_argument("--frames", type=int, default=0, help="frames of every scene, the start counted; 0 for all")
    parser.add_argument(
        "--errors", default="A,C", help="scenes to solve references of, for own errors; they take longest"
    )
    parser.add_argument("--references", action="store_true", help="only solve the references, to have them kept")
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "peers", help="folder of the trajectories")
    parser.add_argument("--out", type=Path, default=tables.DOCS, help="folder of the table")
    given = parser.parse_args(arguments)
    bench = Bench(Blender(given.blender.absolute(), given.peers.resolve()), given.work.resolve(), given.frames)
    if bench.blender.missing:
        parser.error(bench.blender.missing)
    names = given.scenes.split(",")
    erring = [name for name in given.errors.split(",") if name in names]
    absent = [name for name in names if not (bench.blender.folder / "scenes" / f"{name}.npz").exists()]
    if absent:
        parser.error(f"{bench.blender.folder / 'scenes'} holds no {absent[0]}.npz")
    bench.work.mkdir(parents=True, exist_ok=True)
    if given.references:
        return 1 if any(ended.fault for name in erring for _, ended in references(bench, name)) else 0
    about = {**tables.made(), "runs": given.runs, "frames": given.frames}
    rows = [
        row | {"commit": about["commit"]} for name in names for row in measure(bench, name, given.runs, name in erring)
    ]
    publish(rows + _others(names, given.out), about, given.out)
    return 1 if any(row.get("fault") for row in rows) else 0


def measure(bench: Bench, name: str, runs: int, self_errors: bool) -> list[dict[str, Any]]:
    """Rows of one scene: both solvers in turn, `runs` times; then the levels and references that own errors need.

    With these, level `fine` takes its turn too: it is the one whose error is to be Blender's.
    """
    levels = (STANDARD, FINE) if self_errors else (STANDARD,)
    times: dict[str, list[Ended]] = {solver: [] for solver in (*levels, BLENDER)}
    load = round(os.getloadavg()[0], 2)
    for number in range(runs):
        for solver in (BLENDER, *levels):
            # What an earlier round wrote must not be scored as this one's.
            bench.out(name, solver).unlink(missing_ok=True)
            ended = bench.theirs(name, QUALITY) if solver == BLENDER else bench.ours(name, solver)
            times[solver].append(ended)
            _tell(name, f"{solver}, round {number + 1}", ended)
    rows = [_row(bench, name, solver, ended, load) for solver, ended in times.items()]
    for row, level in zip(rows, levels):
        both = [(_wall(a), _wall(b)) for a, b in zip(times[BLENDER], times[level])]
        both = [(a, b) for a, b in both if a and b]
        if both:
            ratios = [a / b for a, b in both]
            row |= {"ratio": median(ratios), "ratios": ratios, "walls_in_turn": [b for _, b in both]}
    if self_errors:
        rows += [_row(bench, name, solver, [ended], load) for solver, ended in references(bench, name)]
        _own_errors(bench, name, rows)
    return rows


def references(bench: Bench, name: str) -> list[tuple[str, Ended]]:
    """What own errors need besides the levels that take turns; kept, as they take longest and no one times them."""
    fine = f"Blender {FINE_QUALITY}"
    runs: list[tuple[str, str, Callable[[], Ended]]] = [
        ("preview", sources(), lambda: bench.ours(name, "preview")),
        ("reference", sources(), lambda: bench.ours(name, "reference", HORIZON)),
        (fine, fine, lambda: bench.theirs(name, FINE_QUALITY, HORIZON)),
    ]
    ends = []
    for solver, key, solve in runs:
        ends.append((solver, once(bench.out(name, solver), f"{key} {bench.frames}", solve)))
        _tell(name, *ends[-1])
    return ends


def _others(names: Sequence[str], folder: Path) -> list[dict[str, Any]]:
    """Rows of the table in `folder` of scenes that aren't among `names`."""
    before = tables.read("peers", folder) or {"made": {}, "rows": []}
    commit = {"commit": before["made"].get("commit")}
    return [commit | row for row in before["rows"] if row["scene"] not in names]


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
    pairs = {"preview": "reference", STANDARD: "reference", FINE: "reference", BLENDER: f"Blender {FINE_QUALITY}"}
    for row in rows:
        best = pairs.get(row["solver"])
        paths = [] if best is None else [bench.out(name, row["solver"]), bench.out(name, best)]
        if not paths or not all(path.exists() for path in paths):
            continue
        with np.load(bench.scene(name)) as scene:
            fps = float(scene["fps"])
        row |= errors(np.load(paths[0])["x"], np.load(paths[1])["x"], fps)


def publish(rows: Sequence[dict[str, Any]], about: dict[str, Any], folder: Path) -> None:
    """Write peers.json and peers.md into `folder`, the scenes in order."""
    rows = sorted(rows, key=lambda row: SCENES.index(row["scene"]) if row["scene"] in SCENES else len(SCENES))
    text = TEXT.format(
        quality=QUALITY, fine=FINE_QUALITY, **{k: about[k] for k in ("runs", "cores", "commit", "date", "processor")}
    )
    tables.write("peers", {"made": about, "rows": rows}, text + tables.table(COLUMNS, rows), folder)


if __name__ == "__main__":
    sys.exit(main())
