"""The report on outfits as a page."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import Any

BARS = {"sharp": 1e-3, "rejected": 0.01, "mass": 0.01, "seconds": 1.5, "statics": 40, "memory_mb": 1000}
"""Limits that the report is held to: shares of faces, of outfits and of mass; CPU time of an outfit [s]; static people
a minute; memory [MB]."""


def a_minute(static: dict[str, Any]) -> float:
    """Static people that two cores make in a minute."""
    return 2 * 60 / static["seconds"]


def page(report: dict[str, Any]) -> str:
    """The page, in Markdown."""
    s, static, trials = report["summary"], report["statics"], report["trials"]
    every = s["garments"]
    edges = ", ".join(f"{1e3 * e:g}" for e in report["mass_edges_m"])
    lines = [
        "# Outfits, measured",
        "",
        f"Written by `python -m tools.outfit.quality`. {s['outfits']} outfits of every kind for both genders, every "
        f"beta at -3 or 3, edges of {1e3 * report['edge_m']:g} mm. Crossings are decided exactly (CGAL), distances and "
        "winding numbers are libigl's exact ones; the body is that of shape and tightness, which the garment is made "
        "for.",
        "",
        "| | measured | bar |",
        "|---|---|---|",
        f"| manifold garments | {s['manifold']} of {every} | all |",
        f"| consistently oriented, outwards | {s['oriented']} of {every} | all |",
        f"| one component | {s['one_component']} of {every} | all |",
        f"| garments that pass through themselves | {s['self_crossing']} | 0 |",
        f"| garments with a vertex inside the body | {s['inside']} | 0 |",
        f"| garments with a face through the body | {s['body_crossing']} | 0 |",
        f"| outfits of two garments that meet each other | {s['layers_meet']} of {s['layered']} | 0 |",
        f"| nearest vertex to a body [mm] | {s['least_body_distance_mm']:.2f} | > 0 |",
        f"| faces with an angle below 15 degrees | {s['sharp_faces']} of {s['faces']} "
        f"({s['sharp_faces'] / s['faces']:.4%}) | {BARS['sharp']:.1%} |",
        f"| smallest angle [degrees] | {s['smallest_angle']:.1f} | |",
        f"| edges below half the target | {s['short_edges']} of {s['edges']} | 0 |",
        f"| edges above twice the target | {s['long_edges']} of {s['edges']} | 0 |",
        f"| mean edge over target | {s['mean_edge']:.3f} | |",
        f"| largest difference of a garment's mass at {edges} mm | {s['mass_spread_worst']:.2%}, "
        f"of {s['mass_garments']} garments | {BARS['mass']:.0%} |",
        f"| rejected outfits | {s['rejected']} of {s['outfits']} | {BARS['rejected']:.0%} |",
        f"| CPU time an outfit, mean and 95th percentile [s] | {s['seconds_mean']:.2f}, {s['seconds_p95']:.2f} "
        f"| {BARS['seconds']} |",
        f"| CPU time a static person, body and outfit, made and published [s] | {static['seconds']:.2f} | |",
        f"| static people a minute on two cores | {a_minute(static):.0f} | {BARS['statics']} |",
        f"| memory of a worker that makes them [MB] | {static['memory_mb']:.0f} | {BARS['memory_mb']} |",
        f"| memory of this report's own process, its tests included [MB] | {s['memory_mb']:.0f} | |",
        f"| vertices an outfit, median | {s['vertices_median']:.0f} | |",
        "",
        f"Times are CPU time on one core. Static people: {static['published']} made by the pipeline with one worker a "
        f"stage, the start of its programs included, {static['rejected']} rejected; two cores take half the time.",
        "",
        "## By garment",
        "",
        "A garment with several cuts is in the row of each.",
        "",
        "| garment | made | faulty | sharp faces | smallest angle [degrees] | shortest and longest edge over target |",
        "|---|---|---|---|---|---|",
    ]
    by: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for t in trials:
        for name, g in t.get("garments", {}).items():
            faulty = any(fault.startswith(f"{name}: ") for fault in t["faults"])
            for row in (name, *(f"{name}, {cut.replace('_', ' ')}" for cut in g["cuts"])):
                by[row].append(g | {"faulty": faulty})
    for name, group in sorted(by.items()):
        sharp, faces, faulty = (sum(g[key] for g in group) for key in ("sharp", "faces", "faulty"))
        lines.append(
            f"| {name} | {len(group)} | {faulty} | {sharp} of {faces} | {min(g['smallest_angle'] for g in group):.1f} "
            f"| {min(g['shortest'] for g in group):.2f}, {max(g['longest'] for g in group):.2f} |"
        )
    faults = Counter(fault for t in trials for fault in t.get("faults", []))
    lines += ["", "## Faults and rejections", ""]
    lines += [f"- {count} x {fault}" for fault, count in faults.most_common()]
    lines += [
        f"- rejected: {t['kind']}, {t['gender']}, betas {t['betas']}, seed {t['seed']}: {t['rejected']}"
        for t in trials
        if "rejected" in t
    ]
    return "\n".join([*lines, *(["None."] if lines[-1] == "" else [])]) + "\n"
