"""The report on outfits as a page."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import Any

BARS = {"sharp": 1e-3, "rejected": 0.01, "mass": 0.01}
"""Limits that the report is held to: shares of faces, of outfits, and of mass."""


def page(report: dict[str, Any]) -> str:
    """The page, in Markdown."""
    s, trials = report["summary"], report["trials"]
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
        f"| CPU time an outfit, median and 95th percentile [s] | {s['seconds_median']:.2f}, {s['seconds_p95']:.2f} | |",
        f"| memory of the process, tests included [MB] | {s['memory_mb']:.0f} | 1000 |",
        f"| vertices an outfit, median | {s['vertices_median']:.0f} | |",
        "",
        "## By garment",
        "",
        "| garment | made | sharp faces | smallest angle | shortest and longest edge over target |",
        "|---|---|---|---|---|",
    ]
    by: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for t in trials:
        for name, g in t.get("garments", {}).items():
            by[name].append(g)
    for name, group in sorted(by.items()):
        sharp, faces = sum(g["sharp"] for g in group), sum(g["faces"] for g in group)
        lines.append(
            f"| {name} | {len(group)} | {sharp} of {faces} | {min(g['smallest_angle'] for g in group):.1f} "
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
