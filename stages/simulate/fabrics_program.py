"""`python -m stages.simulate fabrics`: virtual experiments on the named fabrics, beside published figures."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from stages.fabrics import load_fabrics
from stages.settings import suggestion
from stages.simulate.fabric import Fabric
from stages.simulate.virtual_tests import bending_length, drape_coefficient, extension, theoretical_bending_length

KAWABATA_LOAD = 490.5
"""500 gf/cm [N/m], at which extensions are published."""


def main(arguments: Sequence[str]) -> int:
    """Print a table of the fabrics named in `arguments`, or of all; 65 if one of them is unknown."""
    known = load_fabrics()
    parser = argparse.ArgumentParser(
        prog="python -m stages.simulate fabrics", description="Measure fabrics by virtual experiments."
    )
    parser.add_argument("names", nargs="*", help=f"fabrics: {', '.join(known)}; all if none is named")
    parser.add_argument("--edge", type=float, nargs="+", default=[0.01], help="edges of the meshes [m]")
    parser.add_argument("--threads", type=int, default=0, help="CPU threads; 0 takes all")
    given = parser.parse_args(arguments)
    for name in given.names:
        if name not in known:
            print(f"fabric {name!r} is unknown; {suggestion(name, known)}", file=sys.stderr)
            return 65
    print(f"{'':26}{'bending length [mm]':>32}{'drape coefficient [%]':>32}{'extension at 490 N/m [%]':>32}")
    print(f"{'fabric':14}{'edge [mm]':>12}" + f"{'theory':>12}{'measured':>10}{'published':>10}" + f"{'measured':>20}"
          f"{'published':>12}" + f"{'measured':>20}{'published':>12}")  # fmt: skip
    for name in given.names or known:
        fabric, published = Fabric.of(known[name].as_attrs(), name), known[name].published
        for edge in given.edge:
            drape = 100 * drape_coefficient(fabric, edge, threads=given.threads)
            print(
                f"{name:14}{1e3 * edge:12g}{1e3 * theoretical_bending_length(fabric):12.1f}"
                f"{1e3 * bending_length(fabric, edge, given.threads):10.1f}{_range(published.bending_length, 1e3):>10}"
                f"{f'{drape.mean():.0f} ({drape.min():.0f}-{drape.max():.0f})':>20}"
                f"{_range(published.drape_coefficient, 100):>12}"
                f"{100 * extension(fabric, KAWABATA_LOAD, threads=given.threads):20.1f}"
                f"{_range(published.extension, 100):>12}",
                flush=True,
            )
    return 0


def _range(limits: tuple[float, float] | None, scale: float) -> str:
    return "-" if limits is None else f"{scale * limits[0]:.3g}-{scale * limits[1]:.3g}"
