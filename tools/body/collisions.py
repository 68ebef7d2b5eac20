"""The report on self-collision: `python -m tools.body.collisions --motion FOLDER` writes docs/body/collisions.*.

Embedded clips and the folder's motion files are put on people at the corners of shape space, and freed as the body
stage does it; what comes out, in the fixed point of the shard, is tested by CGAL through libigl, which shares no code
with the solver.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from tools.body.collision_album import Album
from tools.body.collision_cast import cast
from tools.body.collision_text import text
from tools.body.collision_trial import summary, trial


def main() -> None:
    """Makes the report."""
    parser = argparse.ArgumentParser(prog="python -m tools.body.collisions", description=__doc__)
    parser.add_argument("--motion", type=Path, required=True, help="folder of motion files")
    parser.add_argument("--count", type=int, default=40, help="sequences")
    parser.add_argument("--frames", type=int, default=60, help="frames of each")
    parser.add_argument("--every", type=int, default=3, help="test one in so many frames by the independent library")
    parser.add_argument("--out", type=Path, default=Path("docs/body"))
    given = parser.parse_args()
    if not given.motion.is_dir():
        sys.exit(f"{given.motion}: no such folder; name one with motion files")
    trials: list[dict[str, Any]] = []
    album = Album()
    for number, member in enumerate(cast(given.motion, given.count), start=1):
        trials.append(trial(member, given.frames, given.every, album))
        done = trials[-1]
        print(f"{number}: {done['name']} {done['case']} {done['ms_per_frame']:.1f} ms a frame", flush=True)
    report = {"frames": given.frames, "every": given.every, "summary": summary(trials), "trials": trials}
    given.out.mkdir(parents=True, exist_ok=True)
    album.save(given.out / "collisions.png")
    (given.out / "collisions.json").write_text(json.dumps(report, indent=1) + "\n")
    (given.out / "collisions.md").write_text(text(report))


if __name__ == "__main__":
    main()
