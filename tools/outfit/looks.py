"""The report on outfits in pictures: `python -m tools.outfit.looks` -> docs/outfit/README.md and its pictures.

For each type of garment a strip that varies one parameter at a time, and a sheet of outfits drawn as a recipe draws
them.
"""

from __future__ import annotations

import argparse
from collections.abc import Collection
from pathlib import Path

from PIL import Image

from stages.report.sheet import Picture
from tools.outfit.looks_drawn import drawn_sheet
from tools.outfit.looks_strips import STRIPS, strip

QUALITY = 82
"""Of the pictures, which stay under 1.5 MB together."""


def main() -> None:
    """Makes the pictures and their page."""
    parser = argparse.ArgumentParser(prog="python -m tools.outfit.looks", description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="outfits on the sheet")
    parser.add_argument("--only", nargs="*", default=[*STRIPS, "drawn"], help="strips to draw, and `drawn`")
    parser.add_argument("--edge", type=float, default=0.014, help="edge length [m]")
    parser.add_argument("--out", type=Path, default=Path("docs/outfit"))
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    for name in STRIPS:
        if name in given.only:
            save(given.out / f"{name}.jpg", strip(name, given.edge))
    if "drawn" in given.only:
        save(given.out / "drawn.jpg", drawn_sheet(given.count, given.edge))
    there = [name for name in (*STRIPS, "drawn") if (given.out / f"{name}.jpg").is_file()]
    (given.out / "README.md").write_text(page(there, given.count, given.edge))


def save(path: Path, picture: Picture) -> None:
    """Writes one picture and says so."""
    Image.fromarray(picture).save(path, quality=QUALITY, optimize=True)
    print(f"{path}: {picture.shape[1]} x {picture.shape[0]}, {path.stat().st_size / 1e3:.0f} kB", flush=True)


def page(pictures: Collection[str], count: int, edge: float) -> str:
    """The page in Markdown, with those pictures that there are."""
    drawn = [
        f"## {count} outfits",
        "",
        "Drawn with the default ranges as a recipe's static people are: kinds of outfit and genders in turn, shape and "
        "all else by chance; whose outfit the stage rejects is passed over. Colours tell fabrics: earthy ones cotton, "
        "violet and teal silk, blue denim, dark leather.",
        "",
        "![outfits](drawn.jpg)",
        "",
    ]
    lines = [
        "# Outfits, seen",
        "",
        f"Drawn by `make outfits`: garments in the rest pose, edges of {1e3 * edge:g} mm, as the stage publishes them, "
        "before any simulation.",
        "",
        *(drawn if "drawn" in pictures else ()),
        "## One parameter at a time",
        "",
        "Each row goes through the default range of one parameter from its lowest to its highest value; all others "
        "stay in the middle, but limbs are shown whole where their width is varied. Rows that say back or side are "
        "seen from there. Tightness is shown without the body, which would stick out of a garment that is too small "
        "for it at rest.",
    ]
    for name, rows in STRIPS.items():
        if name not in pictures:
            continue
        lines += ["", f"### {name}", "", f"{', '.join(row.label for row in rows)}.", "", f"![{name}]({name}.jpg)"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
