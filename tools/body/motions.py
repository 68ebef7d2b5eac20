"""Puts every motion of a folder on a body, measures it, and shows recorded skeletons and bodies side by side.

`python -m tools.body.motions FOLDER` writes docs/body/motion.md and docs/body/motion.jpg; `--sheets DIR` a contact
sheet of each motion besides.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from model.body import BodyModel, load_free_body
from stages.body.fidelity import Fidelity, compare
from stages.body.figure import Figure, measure
from stages.body.motion import Motion
from stages.body.readers import read_motion, title
from stages.body.readers.survey import motions_in
from stages.body.recording import Recording
from stages.body.sequence import prepared, put_on
from stages.preview import HEIGHT, WIDTH, View
from stages.preview import main as preview
from stages.preview_body import Solved
from stages.report.sheet import contact_sheet
from stages.spec import DataError

DOCS = Path(__file__).parents[2] / "docs" / "body"
COLUMNS = 4
SHRINK = 2

HEAD = """# Motion on the body

`python -m tools.body.motions FOLDER` puts every motion of a folder on the mean woman and measures it against its
recording; here {count} clips. Directions: the angle between bones of the body and recorded ones (four limbs, two
bones each, and the trunk). Slide: the path of the skin that touches the ground while the foot bears weight.

| motion | frames | fps | directions: mean, 95 %, worst bone [deg] | slide: mean, 95 % [mm/frame] | grounded | mended |
|---|---|---|---|---|---|---|
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Writes the report."""
    parser = argparse.ArgumentParser(prog="python -m tools.body.motions", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--sheets", type=Path, metavar="DIR", help="a contact sheet of each motion, into this folder")
    given = parser.parse_args(arguments)
    model = load_free_body("female")
    figure = measure(model, np.zeros(10))
    rows, pictures, figures = [], [], []
    for motion in [m for path in sorted(given.folder.glob("**/*")) if path.is_file() for m in motions_in(path)]:
        name = title(motion)
        try:
            recording = read_motion(motion)
            at_30, mended = prepared(recording, name)
            performed = put_on(figure, at_30, name)
        except DataError as error:
            rows.append(f"| {name} | | | refused: {error} | | | |")
            continue
        found = compare(figure, performed, at_30, name)
        figures.append(found)
        rows.append(row(name, recording, performed, found, mended))
        pictures.append(picture(model, figure, performed, at_30, name))
        print(rows[-1], flush=True)
        if given.sheets:
            preview([motion, "--sheet-only", "--raw", "--frames", "900", "--out", str(given.sheets / f"{name}.mp4")])
    if not figures:
        print(f"{given.folder}: there are no motions that can be read", file=sys.stderr)
        return 1
    rows.append(
        f"| mean | | | {np.mean([f.direction for f in figures]):.2f} | {np.mean([f.slide for f in figures]):.2f} | | |"
    )
    DOCS.mkdir(parents=True, exist_ok=True)
    (DOCS / "motion.md").write_text(HEAD.format(count=len(figures)) + "\n".join(rows) + "\n" + TAIL)
    Image.fromarray(contact_sheet(pictures, COLUMNS, gap=2)).save(DOCS / "motion.jpg", quality=85, optimize=True)
    return 0


TAIL = """
Mended: a fake first frame (a), and a root whose angles had been put together in the wrong order (b), as in a public
release of CMU's clips as exponential maps; without that, people who turn lean over and tip.

The middle frame of each, the recorded skeleton beside the body:

![recorded skeletons and bodies](motion.jpg)
"""


def row(name: str, recording: Recording, motion: Motion, found: Fidelity, mended: list[str]) -> str:
    """A motion's line in the table."""
    marks = "".join("a" if "first frame" in what else "b" if "order" in what else "c" for what in mended)
    return (
        f"| {name} | {len(motion)} | {1 / recording.frame_time:.0f} | {found.direction:.2f}, {found.direction_95:.1f}, "
        f"{found.worst_bone:.1f} | {found.slide:.2f}, {found.slide_95:.2f} | {found.planted:.0%} | {marks} |"
    )


def picture(model: BodyModel, figure: Figure, motion: Motion, recording: Recording, name: str) -> np.ndarray:
    """The middle frame, with the motion's name, shape [H, W, 3]."""
    frame = len(motion) // 2
    part = slice(frame, frame + 1)
    view = View(Solved.raw(model, np.zeros(10), motion.cut(part)), figure, motion, recording, name, part)
    shown = Image.fromarray(view.picture(0))
    small = shown.resize((2 * WIDTH // SHRINK, HEIGHT // SHRINK), Image.Resampling.LANCZOS)
    ImageDraw.Draw(small).text((6, 4), f"{name}, frame {frame}", fill=(60, 60, 60))
    return np.asarray(small)


if __name__ == "__main__":
    sys.exit(main())
