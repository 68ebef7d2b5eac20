"""Twenty dressed people in real motion: `python -m tools.solver.sequences --motion FOLDER` makes and judges them."""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from stages.receipt import PUBLISHED, REJECTED
from tools.solver import sequences_audit, tables
from tools.solver.child import ROOT, run
from tools.solver.kept import sources
from tools.solver.sequences_audit import DEPTH, EXPLODED, FALL_SPEED, FALLEN, FROZEN, LASTING, STRETCHED, audit, faults
from tools.solver.sequences_cast import Member, cast
from tools.solver.sequences_scene import draw_film, draw_sheet, person, receipts

COUNT, FRAMES, ACCURACY = 20, 300, "standard"
"""What docs/solver/sequences.md is made of."""
FILMS = 10
"""Sequences that are filmed, besides those with a fault."""
MEMORY_MB = 2000.0
"""What the simulation of a sequence may take."""
LIMIT = 7200.0
"""For making one sequence [s]."""

COLUMNS = {
    "name": "sequence",
    "gender": "body",
    "betas": "betas",
    "tightness": "tightness",
    "fabrics": "fabrics",
    "frames": "frames",
    "vertices": "vertices",
    "depth_mm": "in body [mm]",
    "crossings_most": "crossings, most",
    "crossed_frames": "frames with any",
    "crossing_lasts": "longest [frames]",
    "stretch_max": "greatest stretch",
    "stretched_share": f"edges > {STRETCHED:.0%}",
    "slip_mm": "slipped [mm]",
    "lag": "least speed over skin's",
    "wildness": "greatest over skin's",
    "speed": "fastest [m/s]",
    "steps": "steps",
    "halvings": "halvings",
    "unsolved": "unsolved",
    "s_per_frame": "s per frame",
    "peak_memory_mb": "peak memory [MB]",
    "fault": "fault",
    "rejected": "rejected before",
}

TEXT = f"""# Sequences of the pipeline

`make sequences MOTION=FOLDER` makes this table: {{count}} sequences of up to {{frames}} frames, simulated at level
`{{accuracy}}` through the pipeline's own stages, one after the other. All kinds of outfit on both genders; clips of a
folder of recordings, one of every kind of motion in turn, shorter ones whole; people at the corners of the first two
betas, at +-3 of each of the others, and of mixed signs in all ten; garments at the ends of their tightness. Somebody
whose limbs can't be freed in a motion is rejected by the body stage, or by the simulation if sleeves cover what could
only be left out; and the opposite shape takes the place.

Every frame is judged from positions, by code that isn't the solver's. A sequence has a fault if

- a vertex is over {1e3 * DEPTH:g} mm inside the body: winding number, and exact distance, by libigl;
- cloth passes through cloth, its own or another garment's, at the same vertex for over {LASTING} frames in a row;
- its waistband, or the {100 * sequences_audit.TOP:g} cm around its shoulders, has slid down the body by over
  {1e3 * FALLEN:g} mm on either side since it was made;
- it moves at less than {FROZEN:g} of the speed of the skin it lies on over half a second in which that moves: frozen;
- a vertex is over {EXPLODED:g} times as fast as the fastest skin half a second before and after, and {FALL_SPEED:g} m/s
  that it may fall: exploded;
- its simulation takes more than {MEMORY_MB:g} MB, or fails.

Time is that of the whole simulation, transition to the first pose included, over the frames kept; load {{load}} on
{{cores}} cores. {{summary}}. Commit {{commit}}, {{date}}.

"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Make and judge the sequences; 0 if none has a fault."""
    parser = argparse.ArgumentParser(prog="python -m tools.solver.sequences", description="Make and judge sequences.")
    parser.add_argument("--motion", type=Path, required=True, help="folder of BVH files")
    parser.add_argument("--count", type=int, default=COUNT, help="number of sequences")
    parser.add_argument("--first", type=int, default=1, help="number of the first one")
    parser.add_argument("--frames", type=int, default=FRAMES, help="of each, at most")
    parser.add_argument("--accuracy", default=ACCURACY, help="the solver's level")
    parser.add_argument("--films", type=int, default=FILMS, help="how many to film, besides those with a fault")
    parser.add_argument("--threads", type=int, default=0, help="CPU threads of the solver; 0 takes all")
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "sequences", help="where sequences are kept")
    parser.add_argument("--out", type=Path, help="folder of the table; docs/solver for the whole of it, else WORK")
    given = parser.parse_args(arguments)
    if not given.motion.is_dir():
        parser.error(f"{given.motion}: no such folder; name a folder of BVH files: --motion FOLDER")
    people = cast(given.motion, given.first - 1 + given.count, given.frames)[given.first - 1 :]
    if not people:
        parser.error(f"{given.motion}: no BVH files there; name a folder of BVH files: --motion FOLDER")
    about = tables.made() | {"accuracy": given.accuracy, "frames": given.frames}
    whole = (given.first, given.count, given.frames, given.accuracy) == (1, COUNT, FRAMES, ACCURACY)
    rows = []
    for place, takes in enumerate(people, start=1):
        row = _row(takes, given, place <= given.films)
        rows.append(row)
        # What is there so far, should the run be cut off.
        publish(rows, about, given.work)
        said = f"FAULT: {row['fault']}" if row["fault"] else f"{row['s_per_frame']} s per frame"
        print(f"{place}/{len(people)} {row['name']}: {said}", flush=True)
    folder = given.out or (tables.DOCS if whole else given.work)
    publish(rows, about, folder)
    return 1 if any(row["fault"] for row in rows) else 0


def _row(takes: Sequence[Member], given: argparse.Namespace, film: bool) -> dict[str, Any]:
    """The row of one sequence: of the first take whose body isn't rejected."""
    rejected: list[str] = []
    for take in takes:
        found = _take(take, given, film)
        cause = found.pop("body_rejected", "")
        if not cause:
            return found | {"rejected": "; ".join(rejected)}
        rejected.append(cause)
    return _about(takes[0]) | {"fault": "nobody's limbs can be freed", "rejected": "; ".join(rejected)}


def _take(member: Member, given: argparse.Namespace, film: bool) -> dict[str, Any]:
    """Make, judge and draw one take; its row, with `body_rejected` if the body stage rejected it."""
    row, output = _about(member), given.work / member.name
    try:
        fault = _make(member, output, given)
        made = receipts(output, member.name)
        if "body" in made and made["body"].status == REJECTED:
            return row | {"body_rejected": made["body"].cause}
        simulated = made.get("simulate")
        if simulated is not None and simulated.status == REJECTED and made["body"].figures["collision"] == "special":
            return row | {"body_rejected": simulated.cause}
        if simulated is None or simulated.status != PUBLISHED:
            causes = [r.cause for r in made.values() if r.status == REJECTED]
            return row | {"fault": "; ".join(causes) or fault or "nothing was made"}
        seen = _judge(member, output, simulated.key)
        figures = simulated.figures
        memory = max(simulated.peak_bytes / 1e6, float(figures.get("peak_memory_mb", 0.0)))
        row |= {name: figures.get(name) for name in ("steps", "halvings", "unsolved")}
        row |= {"s_per_frame": round(simulated.wall_s / member.clip.frames, 3), "wall_s": simulated.wall_s}
        row |= {"peak_memory_mb": round(memory), "seconds": figures.get("seconds"), **seen}
        found = faults(seen)
        if memory > MEMORY_MB:
            found.append(f"{memory:.0f} MB of memory")
        row["fault"] = "; ".join(found)
        _draw(member, output, seen, film or bool(found))
    except Exception as error:  # one sequence that can't be judged doesn't cost the others
        traceback.print_exc()
        row["fault"] = f"{type(error).__name__}: {' '.join(str(error).split())}"
    return row


def _about(member: Member) -> dict[str, Any]:
    return {
        "name": member.name,
        "gender": member.gender,
        "outfit": member.outfit,
        "motion": member.clip.path.name,
        "start": member.clip.start,
        "frames": member.clip.frames,
        "betas": ", ".join(f"{i}: {b:+g}" for i, b in enumerate(member.betas, start=1) if b),
        "tightness": " to ".join(f"{t:g}" for t in dict.fromkeys(member.tightness)),
        "fabrics": f"{member.upper}, {member.lower}" if "+" in member.outfit else member.lower,
        "fault": "",
    }


def _make(member: Member, output: Path, given: argparse.Namespace) -> str:
    """Run the pipeline until the sequence is simulated, if it isn't yet by the solver as it is; what went wrong."""
    recipe, stamp = output.with_suffix(".toml"), output / "solver.txt"
    output.mkdir(parents=True, exist_ok=True)
    recipe.write_text(member.recipe(given.accuracy, given.threads))
    command = [sys.executable, "-m", "pipeline"]
    if stamp.exists() and stamp.read_text() != sources():
        # The stage's version says nothing of small changes, and a table is of one solver.
        run([*command, "clean", recipe.resolve(), "--output", output.resolve(), "--stage", "simulate"], LIMIT)
    stamp.write_text(sources())
    print(f"{member.name}: {member.clip.frames} frames", flush=True)
    ended = run(
        [*command, "run", recipe.resolve(), "--until", "simulate", "--jobs", "1", "--output", output.resolve()], LIMIT
    )
    return ended.fault if ended.code != 0 else ""


def _judge(member: Member, output: Path, key: str) -> dict[str, Any]:
    """The audit's figures, kept until the shard or the audit changes."""
    kept, clock = output / "audit.json", perf_counter()
    of = hashlib.sha256(key.encode() + Path(sequences_audit.__file__).read_bytes()).hexdigest()
    of += (output / "solver.txt").read_text()
    if kept.exists() and (before := json.loads(kept.read_text()))["of"] == of:
        return dict(before["figures"])
    who, garments, body = person(output, member.name)
    figures = audit(garments, body, float(who.body["fps"]))
    spent = (perf_counter() - clock) / member.clip.frames
    print(f"{member.name}: judged, {spent:.2f} s per frame", flush=True)
    kept.write_text(json.dumps({"of": of, "figures": figures}, indent=1))
    # What was drawn of another simulation goes.
    for old in (_sheet(output), _film(output)):
        old.unlink(missing_ok=True)
    return figures


def _sheet(output: Path) -> Path:
    return output.parent / "sheets" / f"{output.name}.png"


def _film(output: Path) -> Path:
    return output.parent / "films" / f"{output.name}.mp4"


def _draw(member: Member, output: Path, figures: dict[str, Any], film: bool) -> None:
    """Draw the sheet, and the film if it is wanted, unless they are there."""
    sheet, video = _sheet(output), _film(output)
    if sheet.exists() and (video.exists() or not film):
        return
    who, _, _ = person(output, member.name)
    for path in (sheet, video):
        path.parent.mkdir(exist_ok=True)
    if not sheet.exists():
        draw_sheet(sheet, who, figures)
    if film and not video.exists():
        clock = perf_counter()
        draw_film(video, who)
        print(f"{member.name}: filmed in {perf_counter() - clock:.0f} s", flush=True)


def publish(rows: Sequence[dict[str, Any]], about: dict[str, Any], folder: Path) -> None:
    """Write sequences.json and sequences.md into `folder`."""
    text = TEXT.format(count=len(rows), summary=summary(rows), **about)
    tables.write("sequences", {"made": about, "rows": list(rows)}, text + tables.table(COLUMNS, rows), folder)


def summary(rows: Sequence[dict[str, Any]]) -> str:
    """How many have a fault, and what a frame takes."""
    bad = sum(bool(row["fault"]) for row in rows)
    timed = [row for row in rows if row.get("wall_s")]
    if not timed:
        return f"{bad} of {len(rows)} have a fault"
    frames = sum(row["frames"] for row in timed)
    each = [row["s_per_frame"] for row in timed]
    mean = sum(row["wall_s"] for row in timed) / frames
    memory = max(row["peak_memory_mb"] for row in timed)
    return (
        f"{bad} of {len(rows)} have a fault; {frames} frames took {mean:.2f} s each on average, {min(each):.2f} to "
        f"{max(each):.2f} by sequence, and at most {memory} MB"
    )


if __name__ == "__main__":
    sys.exit(main())
