"""Colours of bodies and fabrics in the pictures."""

from __future__ import annotations

import zlib

Colour = tuple[float, float, float]

SKIN: Colour = (0.87, 0.71, 0.62)
SKIN_GLOSS = 0.05

# Screen colours (sRGB). A fabric keeps to its family, so that a glance at a picture tells what is worn.
FABRICS: dict[str, tuple[Colour, ...]] = {
    "cotton": ((0.86, 0.42, 0.30), (0.93, 0.73, 0.32), (0.45, 0.62, 0.48), (0.91, 0.88, 0.83)),
    "denim": ((0.22, 0.34, 0.53), (0.33, 0.46, 0.63)),
    "silk": ((0.63, 0.30, 0.47), (0.20, 0.51, 0.53), (0.52, 0.43, 0.70)),
    "leather": ((0.36, 0.25, 0.20), (0.25, 0.24, 0.25)),
}
OTHER: tuple[Colour, ...] = ((0.48, 0.56, 0.66), (0.62, 0.58, 0.50), (0.56, 0.47, 0.58))


def fabric_colour(fabric: str, item: str, layer: int = 0) -> Colour:
    """Colour of a garment.

    Args:
        fabric: Name of its fabric; an unknown one gets a neutral colour.
        item: Whose garment it is; picks the shade.
        layer: Place in the outfit: neighbouring layers of one fabric differ.
    """
    shades = FABRICS.get(fabric, OTHER)
    return shades[(zlib.crc32(item.encode()) + layer) % len(shades)]
