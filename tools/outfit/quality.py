"""The report on outfits: `python -m tools.outfit.quality --count 500` -> docs/outfit/quality.md, .json.

Outfits of every kind for both genders at the corners of [-3, 3]^10 are made as the stage makes them; each garment is
then measured by code that the stage does not use: CGAL and libigl through exact tests, and plain formulas.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from tools.outfit.quality_cast import cast
from tools.outfit.quality_page import page
from tools.outfit.quality_statics import statics
from tools.outfit.quality_trial import masses, trial

EDGE = 0.010
MASS_EDGES = (0.005, 0.010, 0.020)
"""Edge lengths of the outfits, and those at which masses are compared [m]."""


def summary(trials: list[dict[str, Any]], mass: list[dict[str, list[float]]]) -> dict[str, Any]:
    """What all outfits say together."""
    kept = [t for t in trials if "rejected" not in t]
    garments = [g for t in kept for g in t["garments"].values()]
    spread = [float(np.ptp(m) / m[MASS_EDGES.index(EDGE)]) for found in mass for m in found.values()]
    seconds = [t["seconds"] for t in kept]
    return {
        "outfits": len(trials),
        "rejected": len(trials) - len(kept),
        "causes": sorted({t["rejected"] for t in trials if "rejected" in t}),
        "garments": len(garments),
        "manifold": sum(g["manifold"] for g in garments),
        "oriented": sum(g["oriented"] for g in garments),
        "one_component": sum(g["components"] == 1 for g in garments),
        "self_crossing": sum(g["self_crossings"] > 0 for g in garments),
        "body_crossing": sum(g["body_crossings"] > 0 for g in garments),
        "inside": sum(g["inside"] > 0 for g in garments),
        "layered": sum(len(t["garments"]) > 1 for t in kept),
        "layers_meet": sum(t["layer_crossings"] > 0 for t in kept),
        "least_body_distance_mm": 1e3 * min(g["body_distance"] for g in garments),
        "faces": sum(g["faces"] for g in garments),
        "sharp_faces": sum(g["sharp"] for g in garments),
        "smallest_angle": min(g["smallest_angle"] for g in garments),
        "edges": sum(g["edges"] for g in garments),
        "short_edges": sum(g["short"] for g in garments),
        "long_edges": sum(g["long"] for g in garments),
        "mean_edge": float(np.mean([g["mean_edge"] for g in garments])),
        "seconds_mean": float(np.mean(seconds)),
        "seconds_p95": float(np.percentile(seconds, 95)),
        "memory_mb": max(t["memory_mb"] for t in kept),
        "vertices_median": float(np.median([sum(g["vertices"] for g in t["garments"].values()) for t in kept])),
        "mass_garments": len(spread),
        "mass_spread_worst": max(spread, default=0.0),
    }


def main() -> None:
    """Makes the report."""
    parser = argparse.ArgumentParser(prog="python -m tools.outfit.quality", description=__doc__)
    parser.add_argument("--count", type=int, default=500, help="outfits")
    parser.add_argument("--masses", type=int, default=12, help="outfits made at 5, 10 and 20 mm to compare masses")
    parser.add_argument("--statics", type=int, default=40, help="static people that the pipeline makes, timed")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop after so much time")
    parser.add_argument("--out", type=Path, default=Path("docs/outfit"))
    given = parser.parse_args()
    end = time.monotonic() + 60 * given.minutes
    with TemporaryDirectory() as folder:
        static = statics(given.statics, Path(folder))
    trials: list[dict[str, Any]] = []
    mass = [masses(member, MASS_EDGES) for member in cast(given.masses)]
    for number, member in enumerate(cast(given.count), start=1):
        trials.append(trial(member, EDGE))
        done = trials[-1]
        said = done.get("rejected") or "; ".join(done["faults"]) or "clean"
        print(f"{number}: {member.gender} {member.kind} {said} {done.get('seconds', 0):.2f} s", flush=True)
        if time.monotonic() > end:
            break
    report = {
        "edge_m": EDGE,
        "mass_edges_m": MASS_EDGES,
        "summary": summary(trials, mass),
        "statics": static,
        "masses_kg": mass,
        "trials": trials,
    }
    given.out.mkdir(parents=True, exist_ok=True)
    (given.out / "quality.json").write_text(json.dumps(report, separators=(",", ":")) + "\n")
    (given.out / "quality.md").write_text(page(report))


if __name__ == "__main__":
    main()
