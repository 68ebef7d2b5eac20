"""The plot of error against time: one panel a scene, both axes logarithmic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, NullFormatter

OURS, THEIRS, INK = "#3f7cac", "#d1603d", "#333333"
PANELS_A_ROW = 4


def plot(scenes: Mapping[str, Mapping[str, Any]], levels: Sequence[str], path: Path) -> None:
    """Draw the error over the first second, over 0.5 s where there is no more, against wall time into a PNG.

    Args:
        scenes: Rows of every scene, see `tools.solver.curve`.
        levels: Points to be named in the plot.
        path: The picture to write.
    """
    columns = min(len(scenes), PANELS_A_ROW)
    rows = -(-len(scenes) // PANELS_A_ROW)
    figure, panels = plt.subplots(rows, columns, figsize=(3.4 * columns, 3.1 * rows), squeeze=False)
    for panel in panels.flat[len(scenes) :]:
        panel.set_visible(False)
    for panel, scene in zip(panels.flat, scenes.values()):
        _curve(panel, scene["points"], OURS, "o", "clothmill", levels)
        _curve(panel, scene["blender"], THEIRS, "s", "Blender", ())
        panel.set_title(scene["title"], fontsize=9, color=INK)
        panel.set_xscale("log")
        panel.set_yscale("log")
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())
        panel.grid(True, which="both", linewidth=0.4, color="#dddddd")
        panel.tick_params(labelsize=8, colors=INK)
        panel.set_xlabel("wall s per simulated s", fontsize=8, color=INK)
        panel.set_ylabel("error to 1 s [mm]", fontsize=8, color=INK)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)


def _curve(
    panel: Any, rows: Sequence[Mapping[str, Any]], colour: str, marker: str, label: str, named: Sequence[str]
) -> None:
    """The points that have an error, joined by time."""
    known = [(row["wall_s_per_simulated_s"], _error(row), row["point"]) for row in rows if _error(row)]
    if not known:
        return
    known.sort()
    time, error, names = zip(*known)
    panel.plot(time, error, color=colour, marker=marker, markersize=4, linewidth=0.8, label=label)
    for t, e, name in zip(time, error, names):
        if name in named:
            panel.annotate(name, (t, e), fontsize=7, color=INK, xytext=(4, 4), textcoords="offset points")


def _error(row: Mapping[str, Any]) -> float | None:
    value: float | None = row.get("error_1s_mm", row.get("error_0.5s_mm"))
    return value
