"""Several pictures laid out on one sheet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]


def contact_sheet(pictures: Sequence[Picture], columns: int, gap: int = 0, paper: int = 255) -> Picture:
    """Pictures of one size in rows, from left to right and downwards.

    Args:
        pictures: Pictures, each of shape [H, W, 3].
        columns: Pictures in a row.
        gap: Space between neighbours [px].
        paper: Grey of the space and of empty places, 0 to 255.

    Returns:
        The sheet, shape [rows (H + gap) - gap, columns (W + gap) - gap, 3].
    """
    height, width, _ = pictures[0].shape
    rows = -(-len(pictures) // columns)
    sheet = np.full((rows * (height + gap) - gap, columns * (width + gap) - gap, 3), paper, dtype=np.uint8)
    for k, picture in enumerate(pictures):
        top, left = (k // columns) * (height + gap), (k % columns) * (width + gap)
        sheet[top : top + height, left : left + width] = picture
    return sheet
