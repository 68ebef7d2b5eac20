"""Shows any motion on a body before anyone commits to a run: a video, a contact sheet and figures, in one command.

It stands beside the stages, as it uses two of them: the motion is put on a body as the stage `body` does, and drawn as
the stage `report` does. The recorded skeleton stands beside the body. Self-collisions are solved as the stage does it:
parts that cloth wouldn't collide with are grey; where the body would be rejected, it is shown as it is, with what is at
fault in red and a red bar over the frames in which it is.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from model.body import GENDERS, load_free_body
from model.body.smpl_file import read_smpl
from stages.body.config import BETA_COUNT
from stages.body.fidelity import compare
from stages.body.figure import Figure, measure
from stages.body.motion import FPS, Motion
from stages.body.readers import DEFAULT_RATE, read_motion, split_name, title
from stages.body.recording import Recording
from stages.body.sequence import embedded, prepared, put_on
from stages.body.sticks import beside, bones
from stages.preview_body import AT_FAULT, Solved
from stages.report.film import write_film
from stages.report.render import Studio
from stages.report.scene import Shot, Surface, frame_shot, heading
from stages.report.sheet import contact_sheet
from stages.spec import DataError

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

WIDTH, HEIGHT = 280, 360  # of each panel [px]
SHEET_COLUMNS, SHEET_FRAMES = 6, 12
BONE_COLOUR = (0.25, 0.33, 0.45)
BAR = 8  # height of the bar over frames at fault [px]
QUARTER = 0.7  # the camera stands this far to the right of who walks towards it [rad]


def main(arguments: Sequence[str] | None = None) -> int:
    """Makes the preview that the command line asks for; 0, or 1 with one line on stderr for what is at fault."""
    given = _parser().parse_args(arguments)
    try:
        for line in preview(given):
            print(line, flush=True)
    except (DataError, ValueError) as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        return 1
    except OSError as error:
        print(f"{error.filename}: {error.strerror}; check the path and its rights", file=sys.stderr)
        return 1
    return 0


def preview(given: argparse.Namespace) -> Iterator[str]:
    """Draws a motion.

    Args:
        given: What `_parser` parses.

    Returns:
        Lines that say what is done.

    Raises:
        DataError: The motion can't be used; one line.
    """
    if len(given.betas) > BETA_COUNT or not all(abs(beta) <= 5 for beta in given.betas):
        raise DataError(f"--betas must be at most {BETA_COUNT} numbers from -5 to 5, got {given.betas}")
    if not 1.0 <= given.rate <= 10000.0:
        raise DataError(f"--rate must be from 1 to 10000 frames/s, got {given.rate:g}")
    model = read_smpl(given.model, given.gender, BETA_COUNT) if given.model else load_free_body(given.gender)
    betas = np.zeros(BETA_COUNT)
    betas[: len(given.betas)] = given.betas
    figure = measure(model, betas)
    path, _ = split_name(given.motion)
    at_30: Recording | None = None
    if path.name == given.motion and not path.suffix:
        name = given.motion

        def move(person: Figure) -> Motion:
            return embedded(person, name)

        motion = move(figure)
        yield f"{name}: {len(motion)} frames, embedded"
    else:
        name = title(given.motion)
        recording = read_motion(given.motion, joints=_table(given.joint), rate=given.rate)
        at_30, mended = prepared(recording, path.name)
        steady = at_30

        def move(person: Figure) -> Motion:
            return put_on(person, steady, path.name)

        motion = move(figure)
        rate = 1 / recording.frame_time
        yield f"{name}: {len(recording.rotations)} frames at {rate:.4g} fps, {len(motion)} at 30 fps"
        for what in mended:
            yield f"mended: {what}"
        figures = compare(figure, motion, at_30, path.name)
        yield (
            f"bones point within {figures.direction:.1f} degrees of the recorded ones in the mean (95 %: "
            f"{figures.direction_95:.1f}); standing feet slide {figures.slide:.2f} mm/frame in the mean (95 %: "
            f"{figures.slide_95:.2f}) and bear weight in {figures.planted:.0%} of the frames"
        )
    if not 0 <= given.start < len(motion):
        raise DataError(f"--start must be from 0 to {len(motion) - 1}, got {given.start}")
    part = slice(given.start, given.start + max(1, given.frames))
    out = given.out or Path(f"{name}.mp4")
    if out.suffix.lower() != ".mp4":
        raise DataError(f"--out must end in .mp4, got {out}")
    out.parent.mkdir(parents=True, exist_ok=True)
    if given.raw:
        solved = Solved.raw(model, betas, motion.cut(part))
    else:
        solved = Solved.of(model, betas, lambda person: move(person).cut(part), name)
        yield solved.told
    view = View(solved, figure, motion, at_30, name, part)
    chosen = np.unique(np.rint(np.linspace(0, view.frames - 1, SHEET_FRAMES)).astype(int))
    if given.sheet_only:
        sheet = [view.picture(int(frame)) for frame in chosen]
    else:
        sheet = []

        def pictures() -> Iterator[Picture]:
            with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
                for frame, picture in enumerate(pool.map(view.picture, range(view.frames))):
                    if frame in chosen:
                        sheet.append(picture)
                    yield picture

        write_film(out, pictures(), view.width, HEIGHT, FPS)
        yield f"video: {out}"
    still = out.with_suffix(".png")
    Image.fromarray(contact_sheet(sheet, SHEET_COLUMNS, gap=4)).save(still, optimize=True)
    yield f"contact sheet: {still}"


class View:
    """A motion on a body as pictures, the recorded skeleton at its left, if there is one.

    Args:
        solved: The body, in the frames to show.
        figure: The person.
        motion: The whole motion on the person.
        recording: What it was made from, at 30 fps.
        name: Name of the motion, for errors.
        part: Frames to show.
    """

    def __init__(
        self,
        solved: Solved,
        figure: Figure,
        motion: Motion,
        recording: Recording | None,
        name: str,
        part: slice,
    ) -> None:
        self.frames, self._at_fault = len(solved.motion), solved.at_fault
        self._panels = [solved.surfaces]
        if recording is not None:
            sticks, faces = bones(*beside(recording, figure, motion, name))
            self._panels.insert(0, [Surface(vertices=sticks[part], faces=faces, cloth=BONE_COLOUR)])
        self.width = WIDTH * len(self._panels)
        surfaces = [surface for panel in self._panels for surface in panel]
        ahead = frame_shot(surfaces, solved.motion.trans, heading(solved.motion.pose[:, 0]), WIDTH, HEIGHT)
        self._shot = Shot(targets=ahead.targets, span=ahead.span, azimuths=(ahead.azimuths[0] - QUARTER,))

    def picture(self, frame: int) -> Picture:
        """One frame, shape [HEIGHT, width, 3]."""
        camera = self._shot.cameras(frame)[0]
        views = [Studio([p.at(frame) for p in panel]).picture(camera, WIDTH, HEIGHT) for panel in self._panels]
        picture = contact_sheet(views, len(views))
        if frame in self._at_fault:
            picture[:BAR] = np.rint(255 * np.array(AT_FAULT))
        return picture


def _table(entries: Sequence[str]) -> dict[str, str]:
    table = {}
    for entry in entries:
        ours, equals, theirs = entry.partition("=")
        if not equals:
            raise DataError(f"--joint must be such as left_knee=Calf_L, got {entry!r}")
        table[ours.strip()] = theirs.strip()
    return table


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m stages.body preview", description="Show a motion on a body: a video and a contact sheet."
    )
    parser.add_argument("motion", metavar="FILE", help="BVH, AMC or npz file (file.npz:sequence), or an embedded clip")
    parser.add_argument("--out", type=Path, metavar="VIDEO", help="video to write, .mp4; the sheet lies beside it")
    parser.add_argument("--gender", choices=GENDERS, default="female")
    parser.add_argument("--model", type=Path, metavar="FILE", help="body of SMPL's schema, in place of the free one")
    parser.add_argument("--betas", type=float, nargs="*", default=[], metavar="B", help="shape, from -3 to 3 each")
    parser.add_argument("--start", type=int, default=0, metavar="N", help="first frame, at 30 fps")
    parser.add_argument("--frames", type=int, default=300, metavar="N", help="at most so many frames, at 30 fps")
    parser.add_argument("--rate", type=float, default=DEFAULT_RATE, help="frames/s of a file that doesn't tell (120)")
    parser.add_argument(
        "--joint", action="append", default=[], metavar="OURS=THEIRS", help="as the recipe's [body.joints]"
    )
    parser.add_argument("--raw", action="store_true", help="the body as it is: self-collisions aren't solved")
    parser.add_argument("--sheet-only", action="store_true", help="no video")
    return parser


if __name__ == "__main__":
    sys.exit(main())
