"""Words and numbers for the page: quality badges, cards and tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.report.config import ReportConfig
from stages.report.gather import Person
from stages.report.quality import Figures, measure

# Columns of the metrics table in their order, with their formats; other numbers follow under their own names.
COLUMNS = {
    "surface_mm": ("surface [mm]", "{:.2f}"),
    "surface_mm_by_category": ("by category [mm]", "{:.2f}"),
    "normals_rad": ("normals [rad]", "{:.3f}"),
    "mask_iou": ("mask IoU", "{:.3f}"),
    "inside_share": ("inside the body", "{:.2%}"),
    "kl": ("KL", "{:.1f}"),
}
HIDDEN = ("items", "kl_per_dimension")

# The solver's own figures: label, scale and unit; others go by their own names.
SOLVER = {
    "max_penetration_m": ("depth in body", 1e3, "mm"),
    "strain_p99": ("stretch p99", 100.0, "%"),
    "strain_max": ("stretch max", 100.0, "%"),
    "share_over_10_percent": ("edges > 10 %", 100.0, "%"),
    "contacts": ("contacts with the body", 1.0, ""),
    "pairs": ("pairs of cloth that touch", 1.0, ""),
    "seconds_transition": ("transition", 1.0, "s"),
    "step_error_rms_m": ("error bar of the step, rms", 1e3, "mm"),
    "step_error_max_m": ("error bar of the step, max", 1e3, "mm"),
    "mesh_error_rms_m": ("error bar of the mesh, rms", 1e3, "mm"),
    "mesh_error_max_m": ("error bar of the mesh, max", 1e3, "mm"),
}


@dataclass(frozen=True, kw_only=True)
class Badge:
    """One requirement, what was measured and whether it holds."""

    name: str
    value: str
    limit: str
    passed: bool


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table as text; `best` marks the cells that win their column."""

    title: str
    header: list[str]
    rows: list[list[str]]
    best: set[tuple[int, int]]


def measure_person(person: Person, config: ReportConfig) -> dict[str, Figures]:
    """The figures of each garment of a simulated person."""
    return {
        garment.name: measure(
            garment.vertices, garment.rest, garment.faces, person.vertices, person.faces, config.stretch_limit
        )
        for garment in person.garments
    }


def badges(figures: Mapping[str, Figures], config: ReportConfig) -> list[Badge]:
    """Whether a simulated sequence is good, by figures measured here."""
    finite = all(f.finite for f in figures.values())
    # NaN, where something is not finite, fails every comparison.
    depth = float(np.max([f.depth.max() for f in figures.values()]))
    stretched = float(np.max([f.stretched.max() for f in figures.values()]))
    return [
        Badge(name="finite", value="yes" if finite else "no", limit="every coordinate", passed=finite),
        Badge(
            name="depth in body",
            value=f"{1e3 * depth:.2f} mm",
            limit=f"at most {1e3 * config.max_depth:g} mm",
            passed=depth <= config.max_depth,
        ),
        Badge(
            name=f"edges > {100 * config.stretch_limit:g} %",
            value=f"{100 * stretched:.2f} %",
            limit=f"at most {100 * config.max_stretched:g} % in the worst frame",
            passed=stretched <= config.max_stretched,
        ),
    ]


def signed(values: Any) -> str:
    """Numbers with their signs, such as "+0.5  -1.2"."""
    return "  ".join(f"{float(v):+.2f}" for v in values)


def card(person: Person, figures: Mapping[str, Figures]) -> list[tuple[str, str]]:
    """What a sequence is, as label and value."""
    body, frames = person.body, len(person.pose)
    rows = [
        ("motion", f"{body['action']} ({body['motion']})" if body["action"] != body["motion"] else str(body["motion"])),
        ("length", f"{frames} frames, {frames / float(body['fps']):.1f} s at {float(body['fps']):g} fps"),
        ("betas", signed(person.betas)),
        ("tightness", signed(person.outfit["tightness"])),
    ]
    for garment in person.garments:
        seen = figures[garment.name]
        stretch = f"stretch p99 {100 * seen.stretch_p99:.1f} %, max {100 * seen.stretch_max:.1f} %"
        rows.append((garment.name, f"{garment.fabric}, {len(garment.rest):,} vertices; {stretch}"))
    solver = person.simulation.get("quality", {})
    rows += [_solver_row(name, float(value)) for name, value in solver.items() if _is_number(value)]
    return rows


def _solver_row(name: str, value: float) -> tuple[str, str]:
    """One of the solver's own figures, as label and value."""
    label, scale, unit = SOLVER.get(name, (name.replace("_", " "), 1.0, ""))
    return f"solver: {label}", f"{number(scale * value)} {unit}".rstrip()


def number(value: float) -> str:
    """A number with four digits that matter, or all of a whole one."""
    return f"{value:,.0f}" if float(value).is_integer() else f"{value:.4g}"


def metric_tables(rows: Sequence[Mapping[str, Any]]) -> list[Table]:
    """One table for each set of the metrics ("static", "sequence"), with the best of each column marked.

    Args:
        rows: Scores; each has "model", "set", perhaps "held_out" and "items", and numbers.
    """
    tables = []
    for kind in dict.fromkeys(str(row["set"]) for row in rows):
        chosen = [row for row in rows if str(row["set"]) == kind]
        extra = dict.fromkeys(k for row in chosen for k, v in row.items() if _is_number(v) and k not in HIDDEN)
        names = [k for k in dict.fromkeys((*COLUMNS, *extra)) if any(_is_number(row.get(k)) for row in chosen)]
        cells = [[_cell(k, row.get(k)) for k in names] for row in chosen]
        best = set()
        for j, name in enumerate(names):
            values = {i: cells[i][j] for i, row in enumerate(chosen) if _is_number(row.get(name))}
            if name != "kl" and len(values) > 1:
                pick = max if name == "mask_iou" else min
                winner = cells[pick(values, key=lambda i: float(chosen[i][name]))][j]
                # Equal to the digits shown is as good.
                best |= {(i, j + 1) for i, text in values.items() if text == winner}
        held_out = all(row.get("held_out", False) for row in chosen)
        samples = f"{chosen[0]['items']} " if "items" in chosen[0] else ""
        where = f"{samples}held-out samples" if held_out else f"{samples}training samples: none was held out"
        tables.append(
            Table(
                title=f"{kind}: {where}",
                header=["model", *(COLUMNS[k][0] if k in COLUMNS else k.replace("_", " ") for k in names)],
                rows=[[str(row["model"]), *line] for row, line in zip(chosen, cells)],
                best=best,
            )
        )
    return tables


def _cell(name: str, value: Any) -> str:
    if not _is_number(value):
        return "–"
    return COLUMNS[name][1].format(value) if name in COLUMNS else number(float(value))


def loss_series(losses: Mapping[str, Mapping[str, Sequence[float]]]) -> dict[str, tuple[list[float], list[float]]]:
    """Epochs and total losses of each network, from `{network: {"step": [...], "total": [...], ...}}`."""
    return {name.upper(): (list(seen["step"]), list(seen["total"])) for name, seen in losses.items()}


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
