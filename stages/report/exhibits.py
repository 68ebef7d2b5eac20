"""Draws what the page shows into the report's folder; returns what the page says beside each picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from stages.report.config import ReportConfig
from stages.report.facts import badges, card, measure_person, signed
from stages.report.film import write_film
from stages.report.gather import Generated, Person, spread
from stages.report.scene import Surface, film, frame_shot, heading, portrait
from stages.report.sheet import contact_sheet

Picture = NDArray[np.uint8]
FRONT, SIDE = -0.5 * np.pi, -np.pi
MARGIN = 1.18
# Portraits of outfits: slightly from the side, where folds show; the arms are spread out in the rest pose.
STILL_VIEW, STILL_SPAN = FRONT - 0.35, 2.0
STILL_SIZE = (400, 420)
GENERATED_SIZE = (340, 420)


def sequence(folder: Path, person: Person, config: ReportConfig, seen: Callable[[float], None]) -> dict[str, Any]:
    """The video, its poster and the strip of a sequence, and its figures.

    Args:
        folder: The report's folder.
        person: The item.
        config: Sizes and limits.
        seen: Called after each frame with the share of the frames that are drawn.
    """
    surfaces = person.surfaces()
    width, height = config.picture_width, config.picture_height
    shot = frame_shot(surfaces, person.trans, heading(person.pose[:, 0]), width, height)
    frames = len(person.pose)
    chosen = spread(range(frames), config.strip_frames)
    kept: dict[int, Picture] = {}

    def pictures() -> Iterator[Picture]:
        for frame, picture in enumerate(film(surfaces, shot, width, height)):
            if frame in (*chosen, frames // 2):
                kept[frame] = picture
            yield picture
            seen((frame + 1) / frames)

    place = f"sequences/{person.item}"
    (folder / "sequences").mkdir(exist_ok=True)
    write_film(folder / f"{place}.mp4", pictures(), 2 * width, height, float(person.body["fps"]))
    save(folder / f"{place}-poster.jpg", kept[frames // 2])
    save(folder / f"{place}-strip.jpg", contact_sheet([kept[frame][:, :width] for frame in chosen], len(chosen)))
    figures = measure_person(person, config)
    marks = badges(figures, config)
    return {
        "item": person.item,
        "title": f"{person.body['gender']}, {person.outfit['kind']}",
        "place": place,
        "width": 2 * width,
        "height": height,
        "strip_frames": len(chosen),
        "badges": marks,
        "good": all(mark.passed for mark in marks),
        "card": card(person, figures),
    }


def still(folder: Path, person: Person) -> dict[str, Any]:
    """The portrait of an outfit at rest."""
    place = f"outfits/{person.item}.jpg"
    (folder / "outfits").mkdir(exist_ok=True)
    surfaces = person.surfaces()
    save(
        folder / place, portrait(surfaces, (STILL_VIEW,), *STILL_SIZE, max(STILL_SPAN, _span(surfaces[0], STILL_SIZE)))
    )
    fabrics = ", ".join(f"{garment.name} of {garment.fabric}" for garment in person.garments)
    return {
        "item": person.item,
        "place": place,
        "title": f"{person.body['gender']}, {person.outfit['kind']}",
        "note": f"{fabrics}; betas {signed(person.betas[:2])}; tightness {signed(person.outfit['tightness'])}",
    }


def generated(folder: Path, garment: Generated) -> dict[str, Any]:
    """Front and side of a garment that the model made."""
    place = f"generated/{garment.name}.jpg"
    (folder / "generated").mkdir(exist_ok=True)
    span = _span(garment.surfaces[0], GENERATED_SIZE)
    save(folder / place, portrait(garment.surfaces, (FRONT, SIDE), *GENERATED_SIZE, span))
    title, note = (
        ", ".join(str(garment.about[k]) for k in names if garment.about.get(k))
        for names in (("gender", "type"), ("fabric", "note"))
    )
    return {"place": place, "title": title or garment.name, "note": note}


def _span(body: Surface, size: tuple[int, int]) -> float:
    """What the height of a picture of `size` [px] must cover to hold a whole body in its first frame [m]."""
    extent = np.ptp(body.vertices[0], axis=0)
    return float(MARGIN * max(extent[2], max(extent[0], extent[1]) * size[1] / size[0]))


def save(path: Path, picture: Picture) -> None:
    """Writes a picture as JPEG without loss of colour resolution."""
    Image.fromarray(picture).save(path, quality=88, subsampling=0, optimize=True)
