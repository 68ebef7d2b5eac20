"""The curve of error against time: `python -m tools.solver.curve` solves every scene at every point of a ladder.

Each point is solved in a process of its own and kept under build/curve, by the solver's sources and the settings, so
that an interrupted run goes on where it stopped and a changed solver is measured anew.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stages.simulate.scene_file import read_scene
from tools.solver import tables
from tools.solver.blender import PYTHON, Blender
from tools.solver.child import ROOT, run
from tools.solver.curve_plot import plot
from tools.solver.curve_points import FINEST, LEVELS, POINTS, QUICK, REFERENCE, SCENES, measure
from tools.solver.kept import sources
from tools.solver.statistics import errors, relative, statistics

LIMIT = 12 * 3600.0
"""Longest time of a point [s]."""
QUALITIES = (7, 14, 28)
"""Blender's steps a frame; each compared with FINEST_QUALITY."""
FINEST_QUALITY = 112

COLUMNS = {
    "point": "settings",
    "wall_s_per_simulated_s": "s per simulated s",
    "error_0.5s_mm": "error to 0.5 s [mm]",
    "error_1s_mm": "to 1 s [mm]",
    "strain_p99": "strain p99",
    "curvature": "curvature",
    "silhouette_m2": "silhouette",
    "kinetic_j_per_kg": "kinetic energy",
    "steps": "steps",
    "halvings": "halvings",
    "load": "load",
}

TEXT = """# Error against time

`make curve` makes this table and the plot. Each scene is solved at every point; the error is the root mean square
distance of all vertices over the first 0.5 s and 1 s from the converged reference: level `reference`, all f64, Newton
to the end, its step a quarter of the finest that is compared. The reference's own error is that against itself at half
its step, where that was solved; it is unmeasured elsewhere. Beyond that time trajectories of cloth part however small
the error was, and statistics are compared: over the second half of the frames, each over the reference's (1.00 is
equal). Blender's rows are its own curve: Cotton, self-collision, that many steps a frame, against its own {finest}.
Wall time is that of the solve alone, kernels loaded and the scene set up; `load` is the load average when it began.
Scenes that weren't measured again stay as they were.

![error against time](curve.png)
"""

MADE = "Commit {commit}, {date}, {processor}, {cores} core(s), {threads} thread(s)."


@dataclass(frozen=True)
class Work:
    """Where points are kept, and what they are solved with.

    Attributes:
        folder: Of the points; peers: the peers' folder, None if there is none.
        frames: Frames to solve, 0 for those of each scene; threads: CPU threads, 0 for all.
    """

    folder: Path
    peers: Path | None
    frames: int
    threads: int

    def place(self, scene: str, what: dict[str, Any]) -> Path:
        """File of the positions of a point, without its ending."""
        text = json.dumps({**what, "frames": self.frames or SCENES[scene].frames}, sort_keys=True)
        return self.folder / scene / hashlib.sha256(text.encode()).hexdigest()[:16]


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the curve; 0 if every point could be solved."""
    parser = argparse.ArgumentParser(prog="python -m tools.solver.curve", description="Measure error against time.")
    parser.add_argument("--peers", type=Path, default=ROOT.parent / "shared" / "peers", help="the peers' folder")
    parser.add_argument("--blender", type=Path, default=PYTHON, help="Python that has bpy")
    parser.add_argument("--scenes", help=f"of {','.join(SCENES)}; all if left out")
    parser.add_argument("--quick", action="store_true", help="few points, 30 frames, no reference: does it work?")
    parser.add_argument("--frames", type=int, default=0, help="frames of every scene; 0 for its own number")
    parser.add_argument("--threads", type=int, default=0, help="CPU threads; 0 for all")
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "curve", help="where points are kept")
    parser.add_argument("--out", type=Path, help="folder of the table; docs/solver if left out, unless --quick")
    parser.add_argument("--point", nargs=3, metavar=("SCENE", "POINT", "FILE"), help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    peers = given.peers.resolve() if (given.peers / "scenes").is_dir() else None
    frames = given.frames or (30 if given.quick else 0)
    if given.point:
        name, point, file = given.point
        print(json.dumps(measure(name, point, peers, frames, given.threads, Path(file))))
        return 0
    names = given.scenes.split(",") if given.scenes else list(SCENES)
    unknown = [name for name in names if name not in SCENES]
    if unknown:
        parser.error(f"no scene is called {unknown[0]!r}; there are {', '.join(SCENES)}")
    if peers is None:
        print(f"{given.peers}: no peers' scenes there; only the pipeline's own are measured", file=sys.stderr)
        names = [name for name in names if not SCENES[name].file]
    work = Work(given.work, peers, frames, given.threads)
    points = list(QUICK if given.quick else POINTS)
    blender = None if peers is None else Blender(given.blender.absolute(), peers)
    if blender is not None and blender.missing:
        print(f"{blender.missing}; its curve is left out", file=sys.stderr)
        blender = None
    about = tables.made()
    about["threads"] = given.threads or about["cores"]
    scenes = {name: _scene(name, points, work, blender, given.quick) | {"made": about} for name in names}
    folder = given.out or (work.folder if given.quick else tables.DOCS)
    publish(_others(names, folder) | scenes, about, folder)
    return 1 if any("fault" in row for s in scenes.values() for row in s["points"] + s["blender"]) else 0


def _scene(name: str, points: Sequence[str], work: Work, blender: Blender | None, quick: bool) -> dict[str, Any]:
    """Rows of a scene: our points, and Blender's."""
    yardstick = QUICK[-1] if quick else REFERENCE
    chosen = [p for p in points if p != FINEST or SCENES[name].half_step]
    ours = [_ours(name, point, work) for point in chosen]
    _compare(ours, yardstick, FINEST)
    theirs: list[dict[str, Any]] = []
    if blender is not None and SCENES[name].file and SCENES[name].blender:
        qualities = QUALITIES[:2] if quick else (*QUALITIES, FINEST_QUALITY)
        theirs = [_blenders(name, quality, work, blender) for quality in qualities]
        _compare(theirs, theirs[-1]["point"], "")
    return {"title": SCENES[name].title, "yardstick": yardstick, "points": ours, "blender": theirs}


def _ours(name: str, point: str, work: Work) -> dict[str, Any]:
    place = work.place(name, {"sources": sources(), "settings": POINTS[point]})
    command: list[str | Path] = [sys.executable, "-m", "tools.solver.curve", "--threads", str(work.threads)]
    command += ["--frames", str(work.frames), "--point", name, point, place.with_suffix(".npz")]
    if work.peers is not None:
        command += ["--peers", work.peers]
    return _kept(place, point, lambda: run(command, LIMIT), f"{name}, {point}")


def _blenders(name: str, quality: int, work: Work, blender: Blender) -> dict[str, Any]:
    """A point of Blender's; positions are in the same format as ours."""
    scene, point = SCENES[name], f"Blender, {quality} steps"
    path = blender.folder / "scenes" / scene.file
    place = work.place(name, {"blender": quality, "collider": scene.body})
    out = place.with_suffix(".npz")
    # It counts the start as a frame.
    frames = (work.frames or scene.frames) + 1
    row = _kept(place, point, lambda: blender(path, out, quality, frames, scene.body), f"{name}, {point}")
    if "fault" not in row and "statistics" not in row:
        file, x = read_scene(path), np.load(out)["x"]
        row |= {"fps": file.fps, "statistics": statistics(x, file.cloth_v, file.cloth_f, file.fps, len(x) // 2)}
        place.with_suffix(".json").write_text(json.dumps({k: v for k, v in row.items() if k != "x"}))
    return row


def _kept(place: Path, point: str, solve: Any, label: str) -> dict[str, Any]:
    """The row of a point: as it was kept, or solved now; with the place of its positions as "x"."""
    kept, x = place.with_suffix(".json"), place.with_suffix(".npz")
    if kept.exists() and x.exists():
        return {**json.loads(kept.read_text()), "x": x}
    place.parent.mkdir(parents=True, exist_ok=True)
    load = round(os.getloadavg()[0], 2)
    ended = solve()
    print(f"{label}: {ended.fault or format(ended.line['wall_s_per_simulated_s'], '.3g')}", flush=True)
    if ended.fault:
        return {"point": point, "fault": ended.fault, "load": load}
    row = {"point": point, **ended.line, "peak_memory_mb": round(ended.peak_mb), "load": load}
    kept.write_text(json.dumps(row))
    return {**row, "x": x}


def _compare(rows: list[dict[str, Any]], yardstick: str, finest: str) -> None:
    """Add errors and relative statistics to the rows, in place: against `yardstick`, that itself against `finest`."""
    solved = {row["point"]: row for row in rows if "fault" not in row}
    if yardstick in solved:
        best, own = solved[yardstick], solved.get(finest)
        reference = np.load(best["x"])["x"]
        for row in solved.values():
            row["relative"] = relative(row["statistics"], best["statistics"])
            if row is not best and row is not own:
                row |= errors(np.load(row["x"])["x"], reference, row["fps"])
        if own is not None:
            best |= errors(reference, np.load(own["x"])["x"], best["fps"])
    for row in rows:
        row.pop("x", None)


def _others(names: Sequence[str], folder: Path) -> dict[str, dict[str, Any]]:
    """Scenes of the table in `folder` that aren't among `names`."""
    before = tables.read("curve", folder) or {"made": {}, "scenes": {}}
    return {k: {"made": before["made"]} | scene for k, scene in before["scenes"].items() if k not in names}


def publish(scenes: dict[str, dict[str, Any]], about: dict[str, Any], folder: Path) -> None:
    """Write curve.json, curve.md and curve.png into `folder`."""
    text = TEXT.format(finest=FINEST_QUALITY)
    scenes = {name: scenes[name] for name in SCENES if name in scenes}
    for name, scene in scenes.items():
        rows = []
        for row in scene["points"] + scene["blender"]:
            bold = f"**{row['point']}**" if row["point"] in LEVELS else row["point"]
            point = bold if "fault" not in row else f"{bold}: {row['fault']}"
            rows.append({**row, **row.get("relative", {}), "point": point})
        text += f"\n## {name}: {scene['title'].removeprefix(f'{name}: ')}\n\n{MADE.format(**scene['made'])}\n\n"
        text += f"{tables.table(COLUMNS, rows)}\n"
    tables.write("curve", {"made": about, "scenes": scenes}, text, folder)
    plot(scenes, LEVELS, folder / "curve.png")


if __name__ == "__main__":
    sys.exit(main())
