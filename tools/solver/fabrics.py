"""The fabrics in a textile laboratory: `python -m tools.solver.fabrics` measures them on meshes from fine to coarse.

Draped cloth has many shapes to rest in, and which it takes depends on chance as much as on the mesh. So drape is the
mean over starts, with unlike numbers of folds in unlike places, and its standard error says what differences mean.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stages.fabrics import load_fabrics
from stages.simulate.fabric import named_fabric
from stages.simulate.fabrics_program import KAWABATA_LOAD
from stages.simulate.runtime import start_taichi
from stages.simulate.virtual_tests import bending_length, drape_coefficient, extension, theoretical_bending_length
from tools.solver import tables

EDGES = (0.005, 0.010, 0.014, 0.020)
"""Of the meshes [m]."""
FOLDS, TURNS = (5, 6, 7), (0.0, 0.25, 0.5, 0.75)
"""Starts of the drape test: numbers of folds, and where these start on the mesh."""
FINE_TURNS = (0.0,)
"""Of them those on the finest mesh, which takes longest."""

COLUMNS = {
    "fabric": "fabric",
    "edge_mm": "edge [mm]",
    "bending_length_mm": "bending length [mm]",
    "bending_length_theory_mm": "theory",
    "bending_length_published_mm": "published",
    "drape": "drape coefficient [%]",
    "drape_error": "standard error",
    "drape_published": "published [%]",
    "over_10_mm": "over that at 10 mm",
    "extension": "extension at 490 N/m [%]",
    "extension_published": "published [%]",
}

TEXT = """# Fabrics by virtual experiments

`make fabrics` makes this table: the cantilever test (a strip that overhangs by twice its bending length), Cusick's
drape test (a disc of 30 cm on a support of 18 cm; the mean over {starts} starts of five to seven folds, {few} on the
finest mesh) and the extension of a strip under 500 gf/cm, on meshes of {edges} mm. Theory is Peirce's (B / w)^(1/3).
What is published, and where, stands in `stages/fabrics.toml`; nothing is published of what is empty.

Commit {commit}, {date}.

"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the fabrics; 0 unless the arguments are wrong."""
    known = load_fabrics()
    parser = argparse.ArgumentParser(prog="python -m tools.solver.fabrics", description="Measure the fabrics.")
    parser.add_argument("--fabrics", default=",".join(known), help="which of them")
    parser.add_argument("--edges", type=float, nargs="+", default=EDGES, help="edges of the meshes [m]")
    parser.add_argument("--threads", type=int, default=0, help="CPU threads; 0 for all")
    parser.add_argument("--out", type=Path, default=tables.DOCS, help="folder of the table")
    given = parser.parse_args(arguments)
    names = given.fabrics.split(",")
    unknown = [name for name in names if name not in known]
    if unknown:
        parser.error(f"no fabric is called {unknown[0]!r}; there are {', '.join(known)}")
    about = {**tables.made(), "threads": start_taichi(given.threads or None)}
    rows = [measure(name, edge, given.threads) for name in names for edge in given.edges]
    for row in rows:
        base = [other["drape"] for other in rows if other["fabric"] == row["fabric"] and other["edge_mm"] == 10.0]
        row["over_10_mm"] = row["drape"] / base[0] if base else None
    starts, few = len(FOLDS) * len(TURNS), len(FOLDS) * len(FINE_TURNS)
    edges = ", ".join(f"{1e3 * edge:g}" for edge in given.edges)
    text = TEXT.format(starts=starts, few=few, edges=edges, commit=about["commit"], date=about["date"])
    tables.write("fabrics", {"made": about, "rows": rows}, text + tables.table(COLUMNS, rows) + "\n", given.out)
    return 0


def measure(name: str, edge: float, threads: int) -> dict[str, Any]:
    """The row of a fabric on meshes of edges of `edge` [m]."""
    fabric, published = named_fabric(name), load_fabrics()[name].published
    turns = FINE_TURNS if edge < 0.0075 else TURNS
    drape = 100 * drape_coefficient(fabric, edge, FOLDS, threads, turns)
    row = {
        "fabric": name,
        "edge_mm": round(1e3 * edge, 3),
        "bending_length_mm": 1e3 * bending_length(fabric, edge, threads),
        "bending_length_theory_mm": 1e3 * theoretical_bending_length(fabric),
        "bending_length_published_mm": _range(published.bending_length, 1e3),
        "drape": float(drape.mean()),
        "drape_error": float(drape.std(ddof=1) / np.sqrt(drape.size)),
        "drape_each": drape.tolist(),
        "drape_published": _range(published.drape_coefficient, 100),
        "extension": 100 * extension(fabric, KAWABATA_LOAD, edge, threads),
        "extension_published": _range(published.extension, 100),
    }
    print(f"{name}, {row['edge_mm']:g} mm: drape {row['drape']:.1f} %", flush=True)
    return row


def _range(limits: tuple[float, float] | None, scale: float) -> str | None:
    return limits and f"{scale * limits[0]:.3g} to {scale * limits[1]:.3g}"


if __name__ == "__main__":
    sys.exit(main())
