"""The plot of extremes: how much of each bound every case takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from tools.solver.judging import DEPTH

INK = "#333333"
COLOURS = {"finite": "#3f7cac", "refused": "#b9b9b9", "FAILED": "#d1603d"}
PANELS = {
    "greatest speed over its bound": lambda row: row["max_speed"] / row["speed_bound"],
    "energy gained over its bound": lambda row: max(row["energy_gain_j"], 0.0) / row["energy_bound_j"],
    f"depth in the body at the end over {1e3 * DEPTH:g} mm": lambda row: (row["depth_end_mm"] or 0.0) / (1e3 * DEPTH),
}


def plot(rows: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Draw a line for each case and a panel for each bound into a PNG; what was refused or failed is said in words."""
    figure, panels = plt.subplots(
        1, len(PANELS), figsize=(11, 0.16 * len(rows) + 1), sharey=True, squeeze=False, layout="constrained"
    )
    for panel, (title, share) in zip(panels[0], PANELS.items()):
        for place, row in enumerate(rows):
            _bar(panel, place, row, share(row) if row["outcome"] == "finite" else None)
        panel.axvline(1, color=INK, linewidth=0.8)
        panel.set_xlim(0, 1.1)
        panel.set_title(title, fontsize=8, color=INK)
        panel.tick_params(labelsize=7, colors=INK)
    panels[0][0].set_yticks(range(len(rows)), [row["name"] for row in rows], fontsize=6)
    panels[0][0].set_ylim(len(rows) - 0.5, -0.5)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=100, metadata={"Software": None})
    plt.close(figure)


def _bar(panel: Axes, place: int, row: Mapping[str, Any], share: float | None) -> None:
    colour = COLOURS[row["outcome"]]
    if share is None:
        panel.text(0.01, place, row["outcome"], fontsize=6, color=INK, va="center")
    else:
        # What takes nothing of its bound is shown to have been measured.
        panel.barh(place, min(max(share, 0.004), 1.1), color=colour, height=0.7)
