"""The plot of error against time: one panel a scene, both axes logarithmic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

OURS, THEIRS, INK = "#3f7cac", "#d1603d", "#333333"
PANELS_A_ROW = 4


def plot(scenes: Mapping[str, Mapping[str, Any]], levels: Sequence[str], path: Path) -> None:
    """Draw the error over the first second, over 0.5 s where there is no more, against wall time into a PNG.

    Args:
        scenes: Rows of every scene, see `tools.solver.curve`.
        levels: Points of ours to be named and joined by a line; the others are dots.
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
        panel.margins(0.15)
        for axis in (panel.xaxis, panel.yaxis):
            # A panel may span less than a decade: powers of ten alone would leave it without numbers.
            axis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_locator(NullLocator())
        panel.grid(True, linewidth=0.4, color="#dddddd")
        panel.tick_params(labelsize=8, colors=INK)
        panel.set_xlabel("wall s per simulated s", fontsize=8, color=INK)
        whole = any("error_1s_mm" in row for row in scene["points"])
        panel.set_ylabel(f"error to {1 if whole else 0.5:g} s [mm]", fontsize=8, color=INK)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)


def _curve(
    panel: Any, rows: Sequence[Mapping[str, Any]], colour: str, marker: str, label: str, named: Sequence[str]
) -> None:
    """The points that have an error; those of `named`, or all if there are none, are joined by a line."""
    known = sorted((row["wall_s_per_simulated_s"], _error(row), row["point"]) for row in rows if _error(row))
    if not known:
        return
    joined = [point for point in known if point[2] in named or not named]
    others = [point for point in known if point not in joined]
    panel.plot(
        [p[0] for p in joined],
        [p[1] for p in joined],
        color=colour,
        marker=marker,
        markersize=5,
        linewidth=0.8,
        label=label,
    )
    panel.plot([p[0] for p in others], [p[1] for p in others], color=colour, marker=marker, markersize=3, linewidth=0)
    for time, error, name in joined:
        panel.annotate(
            name if named else name.removeprefix("Blender, ").removesuffix(" steps"),
            (time, error), fontsize=7, color=INK, textcoords="offset points",
            xytext=(-4, -9) if named else (4, 3), ha="right" if named else "left",
        )  # fmt: skip


def _error(row: Mapping[str, Any]) -> float | None:
    value: float | None = row.get("error_1s_mm", row.get("error_0.5s_mm"))
    return value
