"""The two garment-shaped surfaces around the body, from which template garments are cut."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.body_asset.assemble import Assembly
from tools.body_asset.source import Source

KINDS = ("tights", "skirt")
"""`tights` is a bodysuit from neck to wrists with the feet enclosed, `skirt` a tube from the waist to the shins."""


@dataclass(frozen=True, eq=False)
class GarmentHelper:
    """A quad surface around the mean body, in the T-pose frame of `BodyModel.v_template`."""

    vertices: NDArray[np.float64]
    """Positions [m], shape [n, 3]."""
    quads: NDArray[np.int32]
    """Corners, counter-clockwise seen from outside, shape [q, 4]."""
    weights: NDArray[np.float64]
    """Skinning weights, rows sum to 1, shape [n, 24]."""


def garment_helper(source: Source, assembly: Assembly, kind: str) -> GarmentHelper:
    """One helper surface on the mean body.

    Args:
        source: The data.
        assembly: Shape space and T-pose of the gender.
        kind: `tights` or `skirt`.

    Returns:
        The surface, with its own vertex numbers.

    Raises:
        ValueError: There is no such kind.
    """
    if kind not in KINDS:
        raise ValueError(f"kind must be one of {', '.join(KINDS)}, got {kind!r}")
    quads = source.base_mesh().groups[f"helper-{kind}"]
    keep, corners = np.unique(quads, return_inverse=True)
    return GarmentHelper(
        vertices=assembly.field()[keep],
        quads=corners.reshape(quads.shape).astype(np.int32),
        weights=assembly.rerest.weights[keep],
    )
