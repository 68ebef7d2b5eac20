"""The plot of plans: steps planned and taken in each frame, and what each item gains."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

PLANNED, TAKEN, INK = "#d1603d", "#3f7cac", "#333333"


def plot(scenes: Mapping[str, Mapping[str, Any]], path: Path) -> None:
    """Draw a column for each scene into a PNG: steps above, gains below."""
    figure, panels = plt.subplots(2, len(scenes), figsize=(3.2 * len(scenes), 5.2), squeeze=False)
    for (name, scene), upper, lower in zip(scenes.items(), panels[0], panels[1]):
        steps = scene["plan"]["steps"]
        frames = [k + 1 - scene["recorded_from"] for k in range(len(steps["taken"]))]
        upper.step(frames, steps["planned"], where="mid", color=PLANNED, linewidth=1.0, label="planned")
        upper.step(frames, steps["taken"], where="mid", color=TAKEN, linewidth=1.0, label="taken")
        if scene["recorded_from"] > 0:
            upper.axvline(0, color=INK, linewidth=0.6, linestyle=":")
        upper.set_ylim(bottom=0)
        upper.set_title(f"{name}: {scene['title']}", fontsize=8, color=INK)
        upper.set_xlabel("frame", fontsize=8, color=INK)
        upper.set_ylabel("steps", fontsize=8, color=INK)
        upper.legend(frameon=False, fontsize=7)
        rows = [row for row in scene["rows"] if "gain" in row and row["variant"] != "everything"][::-1]
        gains = [row["gain"] for row in rows]
        error = [[r["gain"] - r["gain_min"] for r in rows], [r["gain_max"] - r["gain"] for r in rows]]
        lower.barh([r["variant"] for r in rows], gains, xerr=error, color=TAKEN, height=0.6, ecolor=INK)
        lower.axvline(1, color=INK, linewidth=0.6)
        lower.set_xlabel("times faster than everything", fontsize=8, color=INK)
        for panel in (upper, lower):
            panel.tick_params(labelsize=7, colors=INK)
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)
