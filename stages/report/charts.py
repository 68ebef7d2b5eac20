"""Curves for the page, as SVG that takes the page's own colours."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

# Stand-ins that become CSS: the page is read in the light and in the dark.
INK, FAINT = "#010203", "#040506"
CURVES = ("#d1603d", "#3f7cac", "#5b9279", "#8f6bb0")


def loss_curves(curves: Mapping[str, tuple[Sequence[float], Sequence[float]]]) -> str:
    """Training losses over epochs on a logarithmic scale.

    Args:
        curves: Name -> (epochs, losses); points that are not positive are left out by the scale.

    Returns:
        An <svg> element, equal for equal curves; empty if there is no curve.
    """
    if not curves:
        return ""
    settings: Any = {"svg.hashsalt": "clothmill", "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9}
    with matplotlib.rc_context(settings):
        figure, axes = plt.subplots(figsize=(7.2, 2.6))
        for (name, (epochs, losses)), colour in zip(curves.items(), CURVES * len(curves)):
            axes.plot(epochs, losses, color=colour, linewidth=1.6, label=name, marker="o" if len(epochs) == 1 else None)
        axes.set_yscale("log")
        plain = FuncFormatter(lambda value, _: f"{value:g}")
        low, high = axes.get_ylim()
        axes.yaxis.set_major_formatter(plain)
        # Within a decade or so the powers of ten alone would leave the axis without numbers.
        axes.yaxis.set_minor_formatter(plain if high < 10.0 * low else NullFormatter())
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("epoch", color=INK)
        axes.set_ylabel("loss", color=INK)
        axes.tick_params(colors=INK, which="both", length=3)
        axes.grid(True, color=FAINT, linewidth=0.6, which="major")
        for side, spine in axes.spines.items():
            spine.set_visible(side in ("left", "bottom"))
            spine.set_color(FAINT)
        axes.legend(frameon=False, labelcolor=INK)
        figure.tight_layout()
        text = io.StringIO()
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
        plt.close(figure)
    svg = text.getvalue()
    # Inside HTML an <svg> needs neither its prologue nor the addresses of its namespaces.
    svg = re.sub(r"<metadata>.*?</metadata>|\s?xmlns(:\w+)?=\"[^\"]*\"", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    return svg.replace(INK, "var(--ink)").replace(FAINT, "var(--line)")
