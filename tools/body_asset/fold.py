"""Keeps the ends of each shape axis from folding the skin."""

import numpy as np
from numpy.typing import NDArray

BETA_LIMIT = 3.0
"""Largest |beta| that the embedded body promises to be usable at."""

LEAST_COSINE = 0.05
"""Cosine of the most that a triangle may turn between the mean body and the end of an axis: about 87 degrees."""

_STEPS = 12
"""Halvings of the search: the factor is exact to 1/4096."""


def unfolded_scale(template: NDArray[np.float64], direction: NDArray[np.float64], faces: NDArray[np.int32]) -> float:
    """The largest factor, at most 1, by which a shape direction may count so that its ends do not fold the skin.

    Linear extrapolation to three standard deviations turns triangles over in narrow places, such as the crotch of a
    very thin body. A smaller unit keeps the promised range of betas and gives up the folded end only.

    Args:
        template: Mean body [m], shape [V, 3].
        direction: Displacement per unit [m], shape [V, 3].
        faces: Triangles that must not fold, shape [F, 3].

    Returns:
        The factor, in (0, 1].
    """
    reference = _unit_normals(template, faces)

    def unfolded(scale: float) -> bool:
        ends = (template + sign * scale * BETA_LIMIT * direction for sign in (-1.0, 1.0))
        return all((_unit_normals(end, faces) * reference).sum(axis=1).min() > LEAST_COSINE for end in ends)

    if unfolded(1.0):
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if unfolded(middle) else (low, middle)
    return low


def _unit_normals(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    """Unit normals of the triangles, shape [F, 3]."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    lengths: NDArray[np.float64] = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.maximum(lengths, 1e-30)
