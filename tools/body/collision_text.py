"""The report on self-collision as a page."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np

CASES = ("free", "solved", "thinner", "special", "rejected")


def text(report: dict[str, Any]) -> str:
    """The page, in Markdown."""
    s, trials = report["summary"], report["trials"]
    share = {case: s["cases"].get(case, 0) / s["sequences"] for case in CASES}
    lines = [
        "# Self-collision of the body",
        "",
        "Written by `python -m tools.body.collisions --motion FOLDER`. "
        f"{s['sequences']} sequences of up to {report['frames']} frames, from the middle of embedded clips and of real "
        "motion capture; of four people two are at a corner of [-3, 3]^10, one at a corner of size and fatness, one "
        "drawn uniformly. Intersections are counted by CGAL through libigl, in the positions that the shard stores, in "
        f"one of {report['every']} frames: {s['tested_frames']} frames.",
        "",
        ", ".join(f"{case} {share[case]:.0%}" for case in CASES if share[case]) + ".",
        "",
        f"- Intersecting pairs of faces between the treated segments: {s['crossings_before']} before, "
        f"**{s['crossings_after']}** after. Within one segment, or between ankle and foot or wrist and hand, which "
        f"aren't treated: {s['untreated_before']} before, {s['untreated_after']} after (toes, ears and lips, and folds "
        "of the waist).",
        f"- CPU time, one thread: opening limbs {s['opening_ms_per_frame']:.1f} ms a frame, parting skin "
        f"{s['parting_ms_per_frame']:.1f} ms a frame, {s['opening_ms_per_frame'] + s['parting_ms_per_frame']:.1f} ms "
        "together, thinner bodies that were tried included.",
        "- Jerk of skin that was moved, relative to the skin beside it, after over before: "
        f"{s['jerk_growth_median']:.2f} in the median sequence, {s['jerk_growth_worst']:.2f} in the worst; "
        "the largest jerk of any moved vertex grows "
        f"{s['jerk_largest_growth']:.2f} times at most.",
        "",
        "![Before and after](collisions.png)",
        "",
        "Armpit, elbow, groin, knee and chin where skin was moved farthest, from two sides, each before and after.",
        "",
        "## By action",
        "",
        "| action | sequences | frames | " + " | ".join(CASES) + " |",
        "|---|---|---|" + "---|" * len(CASES),
    ]
    actions: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for t in trials:
        actions[t["action"]].append(t)
    for action, group in sorted(actions.items()):
        counts = [sum(t["case"] == case for t in group) for case in CASES]
        cells = [action, str(len(group)), str(sum(t["frames"] for t in group)), *map(str, counts)]
        lines.append("| " + " | ".join(cells) + " |")
    lines += [
        "",
        "## By pair",
        "",
        "| pair | sequences | frames | depth [mm] | moved, median and most [mm] |",
        "|---|---|---|---|---|",
    ]
    pairs: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for t in trials:
        for pair in t.get("pair_moved_mm", {}):
            pairs[pair].append(t)
    for pair, group in sorted(pairs.items(), key=lambda item: -len(item[1])):
        moved = [t["pair_moved_mm"][pair] for t in group]
        depth = max(t["pair_depth_mm"][pair] for t in group)
        frames = sum(t["pair_frames"][pair] for t in group)
        lines.append(f"| {pair} | {len(group)} | {frames} | {depth:.1f} | {np.median(moved):.1f}, {max(moved):.1f} |")
    lines += [
        "",
        "## Sequences",
        "",
        "| motion | person | case | intersections before, after | ms a frame | why |",
        "|---|---|---|---|---|---|",
    ]
    for t in trials:
        before, after = (sum(t.get(f"crossings_{word}", {}).values()) for word in ("before", "after"))
        met = f"{before}, {after}" if t["case"] != "rejected" else "-"
        why = "; ".join(t.get("why", [])[:1])
        what = {"thinner": f" by {t.get('thinner')}", "special": " without " + ", ".join(t.get("left_out", []))}
        lines.append(
            f"| {t['name']} | {t['gender']}, {t['shape']} | {t['case']}{what.get(t['case'], '')} | {met} "
            f"| {t['ms_per_frame']:.1f} | {why} |"
        )
    return "\n".join(lines) + "\n"
