"""What a plan says, in words and as a page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tools.solver import tables

COLUMNS = {
    "variant": "decided by the plan",
    "left_out": "left out",
    "bound": "because",
    "gain": "times faster",
    "spread": "in the rounds",
    "error_0.5s_mm": "difference to 0.5 s [mm]",
    "error_1s_mm": "to 1 s [mm]",
    "strain_p99": "strain p99",
    "curvature": "curvature",
    "kinetic_j_per_kg": "kinetic energy",
    "steps": "steps",
    "depth_mm": "depth [mm]",
    "events": "turned on",
}

TEXT = """# Only what the scene requires

`make plan` makes this table and the plot. A plan is made for each scene before it is solved, and stored with it. Each
scene is solved with everything (all skin, pairs of cloth looked for in every step, in every frame the step that the
fastest needs, all forces), with each item decided alone, and with the whole plan; in turn, {rounds} rounds, times
faster is the median of the ratios within the rounds. The time to make the plan is counted. The difference is the root
mean square distance from `everything` over the first 0.5 s and 1 s of the scene, its transition included; that of
`everything, half step` is what `everything` is wrong by itself. Beyond that, statistics over the second half of what is
recorded, over those of `everything`. The rows `without ...` lack a force for good: they show what leaving it out could
gain, which is why no plan does, and what it would change.

Whatever is left out is watched: "turned on" counts how often the run found that it was needed.

![steps and gain](plan.png)

Commit {commit}, {date}, {processor}, {threads} threads, load {load}.
"""


def describe(
    variant: str, own: Mapping[str, Any], everything: Mapping[str, Any], plan: Mapping[str, Any]
) -> tuple[str, str]:
    """What a variant leaves out, and why it may."""
    forces, body, steps = plan["forces"], own["body_faces"], own["steps"]
    parts: list[tuple[str, str]] = []
    if "body" in own["decided"]:
        near = "" if body["least_distance_m"] is None else f", {1e3 * body['least_distance_m']:.0f} mm at least"
        parts.append((
            f"{body['left_out'] / max(body['all'], 1):.0%} of the body's faces",
            f"expected further than {1e3 * body['guard_m']:.0f} mm from cloth{near}",
        ))  # fmt: skip
    if "pairs" in own["decided"]:
        kept = own["pairs"]["kept_for_steps"]
        parts.append((
            f"searches in up to {kept - 1} of {kept} steps", "closing speeds, looked at in each search"
        ))  # fmt: skip
    if "steps" in own["decided"]:
        taken, all_of_it = sum(steps["taken"]), sum(everything["steps"]["taken"])
        parts.append((
            f"{1 - taken / all_of_it:.0%} of the steps",
            f"{min(steps['taken'])} to {max(steps['taken'])} a frame, planned {min(steps['planned'])} to "
            f"{max(steps['planned'])}: skin into cloth at {steps['fastest_skin_into_cloth_m_s']:.1f} m/s at most",
        ))  # fmt: skip
    if variant == "without air":
        parts.append(("drag", f"at most {forces['air']['over_weight']:.2g} of the weight"))
    if variant == "without elastics":
        parts.append(("elastics", f"{forces['elastics']['edges']} edges have one"))
    if variant == "without strain limit":
        limit = forces["strain_limit"]
        most = max(limit["hanging_strain_over_limit"], limit["starting_strain_over_limit"])
        parts.append(("stiffening", f"strain of {most:.2g} times its limit"))
    return "; ".join(part[0] for part in parts), "; ".join(part[1] for part in parts)


def text_of(scenes: Mapping[str, Mapping[str, Any]], about: Mapping[str, Any]) -> str:
    """The page."""
    text = TEXT.format(**about)
    for name, scene in scenes.items():
        rows = []
        for row in scene["rows"]:
            spread = f"{row['gain_min']:.2f} to {row['gain_max']:.2f}" if "gain" in row else None
            rows.append({**row, **row["relative"], "spread": spread, "events": len(row["events"])})
        text += f"\n## {name}: {scene['title']}\n\n{scene['vertices']} vertices, {scene['frames']} frames, "
        text += f"recorded from frame {scene['recorded_from']}. {_garments(scene['plan'])}\n\n"
        text += tables.table(COLUMNS, rows) + "\n"
        for event in scene["plan"]["events"]:
            text += f"\nFrame {event['frame']}: {event['what']}, as {event['why']}.\n"
    return text


def _garments(plan: Mapping[str, Any]) -> str:
    parts = [
        f"{' and '.join(pair['pair'])} "
        + ("can meet" if pair["meet"] else f"stay {1e3 * pair['least_distance_m']:.0f} mm apart")
        for pair in plan["garments"]
    ]
    return "; ".join(parts).capitalize() + "." if parts else "One garment."
