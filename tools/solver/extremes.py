"""The stability matrix: `python -m tools.solver.extremes` solves every case in a process of its own and judges it."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tools.solver import tables
from tools.solver.child import run
from tools.solver.extreme_cases import CASES, Case
from tools.solver.extremes_plot import plot
from tools.solver.judging import BOUNCE, DEPTH, ENERGY_SLACK, LASTING, TANGLED, WHIP, Verdict, judge

START_UP = 60.0
"""Time to import, and to compile kernels, on top of a case's own limit [s]."""

COLUMNS = {
    "group": "extreme",
    "name": "case",
    "outcome": "outcome",
    "vertices": "vertices",
    "frames": "frames",
    "max_speed": "fastest [m/s]",
    "speed_bound": "bound [m/s]",
    "energy_gain_j": "energy gained [J]",
    "energy_bound_j": "bound [J]",
    "depth_start_mm": "in body, start [mm]",
    "depth_worst_mm": "worst [mm]",
    "depth_end_mm": "end [mm]",
    "crossings_start": "crossings, start",
    "crossings_end": "end",
    "steps": "steps",
    "halvings": "halvings",
    "wall_s": "s",
    "reason": "reason",
}

TEXT = f"""# The solver at the extremes

`make extremes` makes this table: {{count}} cases, each in a process of its own with a time limit. A case is finite, or
refused before its first step with a reason. Anything else is FAILED:

- a value that isn't finite, a process that crashes or doesn't end, a step that can't be solved;
- depth in the body beyond {1e3 * DEPTH:g} mm and beyond that of the start, by libigl's signed distance;
- crossings, pairs of the cloth's own faces that pass through each other, that last: in each of the last {LASTING}
  frames more than at the start by over {TANGLED:.2%} of the faces;
- energy from nowhere. The cloth's energy (motion, height, stretch, bending) may exceed that of the start by the work
  put in: as if all of it had bounced at {BOUNCE:g} times the speed of the fastest body vertex or pin, and had risen as
  far as the body; and by {100 * ENERGY_SLACK:g} % of its greatest fall in height energy. Where nothing but the cloth
  moves only the last counts. If it starts inside a body or tangled it may be lifted out, and gain 1 m/s (5 m/s for
  the crumpled sheet); only motion and height count then, as a sleeve that is too tight has to stretch;
- a vertex faster than {WHIP:g} times the fastest body and a free fall through the scene together: hems crack like
  whips, but not more than that.

![what every case takes of its bounds](extremes.png)

{{outcomes}}. Commit {{commit}}, {{date}}.

"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the matrix, or some cases of it; 0 if no case failed."""
    parser = argparse.ArgumentParser(prog="python -m tools.solver.extremes", description="Run the stability matrix.")
    parser.add_argument("--only", nargs="+", default=[], metavar="TEXT", help="cases whose name or group holds this")
    parser.add_argument("--out", type=Path, help="folder of the table; needed with --only, else docs/solver")
    parser.add_argument("--threads", type=int, default=0, help="CPU threads of a case; 0 takes all")
    parser.add_argument("--case", help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    if given.case:
        print(json.dumps(judge(CASES[given.case], given.threads).row()))
        return 0
    chosen = [c for c in CASES.values() if not given.only or any(t in c.name or t in c.group for t in given.only)]
    if not chosen:
        parser.error(f"no case holds {' or '.join(given.only)}; there are: {'; '.join(CASES)}")
    about = tables.made()
    rows = [_solve(case, given.threads, f"{k + 1}/{len(chosen)}") for k, case in enumerate(chosen)]
    folder = given.out or (None if given.only else tables.DOCS)
    if folder is not None:
        publish(rows, about, folder)
    failed = [row["name"] for row in rows if row["outcome"] == "FAILED"]
    if failed:
        print(f"FAILED: {'; '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def _solve(case: Case, threads: int, place: str) -> dict[str, Any]:
    """The row of one case, solved in its own process."""
    command = [sys.executable, "-m", "tools.solver.extremes", "--case", case.name, "--threads", str(threads)]
    ended = run(command, case.limit + START_UP)
    verdict = ended.line if not ended.fault else Verdict("FAILED", ended.fault, wall_s=round(ended.wall_s, 2)).row()
    row = {"group": case.group, "name": case.name, **verdict, "peak_memory_mb": round(ended.peak_mb)}
    print(f"{place} {case.name}: {row['outcome']}, {ended.wall_s:.1f} s {row['reason']}".rstrip(), flush=True)
    return row


def publish(rows: Sequence[dict[str, Any]], about: dict[str, Any], folder: Path) -> None:
    """Write extremes.json, extremes.md and extremes.png into `folder`."""
    counts = {what: sum(r["outcome"] == what for r in rows) for what in ("finite", "refused", "FAILED")}
    outcomes = ", ".join(f"{count} {what}" for what, count in counts.items())
    text = TEXT.format(count=len(rows), outcomes=outcomes, **{k: about[k] for k in ("commit", "date")})
    tables.write("extremes", {"made": about, "cases": list(rows)}, text + tables.table(COLUMNS, rows), folder)
    plot(rows, folder / "extremes.png")


if __name__ == "__main__":
    sys.exit(main())
