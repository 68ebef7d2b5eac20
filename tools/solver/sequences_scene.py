"""Reads what a sequence's recipe made, and draws it: a video, and a sheet of frames with the worst ones."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw
from scipy.spatial.transform import Rotation

from model.body import REST_POSE, load_free_body
from stages import receipt
from stages.receipt import Receipt
from stages.report.film import write_film
from stages.report.gather import Person, read_person, spread
from stages.report.scene import film, frame_pictures, frame_shot, heading
from stages.report.sheet import contact_sheet
from stages.simulate.collider import closed
from stages.spec import Task
from store import read
from tools.solver.sequences_audit import Body, Cloth

STAGES = ("body", "outfit", "simulate")
FILM_SIZE = (320, 560)
"""Of each of the two views [px]."""
SHEET_SIZE = (200, 350)
"""Of each of the two views on a sheet [px]."""
SHEET_FRAMES, SHEET_COLUMNS = 8, 6
UP = (0.0, 1.0, 0.0)
"""From pelvis to head in the frame of the root joint."""


def receipts(output: Path, item: str) -> dict[str, Receipt]:
    """What each stage said of `item`, as far as the run got."""
    found = {stage: receipt.load(output / stage / "receipts" / f"{item}.json") for stage in STAGES}
    return {stage: made for stage, made in found.items() if made is not None}


def person(output: Path, item: str) -> tuple[Person, dict[str, Cloth], Body]:
    """The sequence as the report shows it, and as the audit judges it.

    Raises:
        ShardError: A shard isn't there, or isn't the receipt's.
    """
    keys = {stage: made.key for stage, made in receipts(output, item).items()}
    inputs = {stage: {item: {"path": str(output / stage / f"{item}.h5"), "key": keys[stage]}} for stage in keys}
    task = Task(
        stage="report", item="all", kind="dataset", key="", seed=0, config={}, params={}, inputs=inputs, output=""
    )
    who = read_person(task, item)
    outfit = read(output / "outfit" / f"{item}.h5", "outfit", keys["outfit"])
    collider = read(output / "body" / f"{item}.h5", "body", keys["body"])
    trans = np.asarray(who.trans, np.float64)
    garments = {
        g.name: Cloth(
            x=g.vertices + trans[:, None],
            faces=np.asarray(g.faces, np.int64),
            rest=np.asarray(g.rest, np.float64),
            held=np.asarray(outfit[f"garments/{g.name}/waistband"], bool),
        )
        for g in who.garments
    }
    model = load_free_body(who.body["gender"])
    body = Body(
        x=who.vertices + trans[:, None],
        faces=closed(np.asarray(who.faces, np.int64), np.asarray(collider["face_kept"], bool)),
        rest=np.asarray(model.pose(outfit["tight_betas"], REST_POSE[None], np.zeros((1, 3)))[0], np.float64),
        up=Rotation.from_rotvec(np.array(who.pose[:, 0], np.float64)).apply(UP),
        up_rest=Rotation.from_rotvec(np.array(REST_POSE[0], np.float64)).apply(UP),
    )
    return who, garments, body


def draw_film(path: Path, who: Person) -> None:
    """Write the video, front and side, with the camera following."""
    surfaces = who.surfaces()
    width, height = FILM_SIZE
    shot = frame_shot(surfaces, who.trans, heading(who.pose[:, 0]), width, height)
    unfinished = path.with_name(f"unfinished-{path.name}")
    write_film(unfinished, film(surfaces, shot, width, height), 2 * width, height, float(who.body["fps"]))
    unfinished.rename(path)


def draw_sheet(path: Path, who: Person, figures: Mapping[str, Any]) -> None:
    """Write a picture of frames spread over the sequence, front and side, and of those in which a figure is worst."""
    surfaces = who.surfaces()
    width, height = SHEET_SIZE
    shot = frame_shot(surfaces, who.trans, heading(who.pose[:, 0]), width, height)
    pictures = []
    for frame, label in labels(len(who.pose), figures).items():
        picture = Image.fromarray(frame_pictures(surfaces, frame, shot, width, height))
        ImageDraw.Draw(picture).text((6, 4), label, fill=(20, 20, 20))
        pictures.append(np.asarray(picture))
    unfinished = path.with_name(f"unfinished-{path.name}")
    Image.fromarray(contact_sheet(pictures, SHEET_COLUMNS, gap=4)).save(unfinished)
    unfinished.rename(path)


def labels(frames: int, figures: Mapping[str, Any]) -> dict[int, str]:
    """Frames to draw and what is written on each: evenly spread ones, and those in which something is worst."""
    words = {frame: f"{frame}" for frame in spread(range(frames), SHEET_FRAMES)}
    worst = {
        "depth_frame": ("depth_mm", "deepest {} mm"),
        "crossings_frame": ("crossings_most", "{} crossings"),
        "slip_frame": ("slip_mm", "slipped {} mm"),
        "speed_frame": ("speed", "{} m/s"),
    }
    for name, (value, text) in worst.items():
        if figures.get(value):
            frame = figures[name]
            words[frame] = f"{words.get(frame, frame)}: {text.format(figures[value])}"
    return words
