"""Draws an outfit in the rest pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from model.body import load_free_body
from stages.outfit.making import Garment
from stages.outfit.resizing import tight_betas
from stages.outfit.template import rest_body
from stages.report.camera import Camera
from stages.report.palette import SKIN, SKIN_GLOSS, fabric_colour
from stages.report.render import Mesh, Studio
from stages.report.sheet import Picture

FRONT, BACK, SIDE = -0.5 * np.pi, 0.5 * np.pi, -0.95 * np.pi
"""Directions to the camera [rad]."""

SCALE = 2
"""Pictures are drawn this much larger and then made smaller: smooth outlines."""


def outfit_picture(
    garments: Sequence[Garment],
    gender: str,
    betas: NDArray[np.float64],
    *,
    who: str,
    middle: float,
    span: float,
    size: tuple[int, int],
    azimuth: float = FRONT,
    tightness: tuple[float, float] | None = (0.0, 0.0),
) -> Picture:
    """An outfit on the body that it is made for.

    Args:
        garments: The garments.
        gender: The wearer's gender.
        betas: The wearer's shape, shape [B].
        who: Name that picks the colours.
        middle: Height in the middle of the picture, over the root joint [m].
        span: What the picture's height covers [m].
        size: Width and height [px].
        azimuth: Direction to the camera [rad].
        tightness: That of the outfit, so that the body is that of shape and tightness; None leaves the body out.

    Returns:
        The picture, shape [height, width, 3].
    """
    model = load_free_body(gender)
    meshes = [
        Mesh(
            vertices=garment.vertices,
            faces=garment.faces,
            colour=fabric_colour(garment.plan.fabric, f"{who}/{garment.plan.name}", layer),
        )
        for layer, garment in enumerate(garments)
    ]
    if tightness is not None:
        body = rest_body(model, tight_betas(betas, tightness))
        meshes.append(Mesh(vertices=body, faces=model.faces, colour=SKIN, gloss=SKIN_GLOSS))
    camera = Camera.around(np.array([0.0, 0.0, middle]), azimuth, height=span, elevation=0.12)
    width, height = size
    large = Studio(meshes, floor=None).picture(camera, SCALE * width, SCALE * height)
    return np.asarray(Image.fromarray(large).resize(size, Image.Resampling.LANCZOS))


def labelled(picture: Picture, text: str, height: int = 18) -> Picture:
    """A picture with a line of text above it."""
    board = Image.new("RGB", (picture.shape[1], picture.shape[0] + height), "white")
    board.paste(Image.fromarray(picture), (0, height))
    ImageDraw.Draw(board).text((4, 2), text, fill=(40, 40, 40), font=ImageFont.load_default(size=height - 6))
    return np.asarray(board)
