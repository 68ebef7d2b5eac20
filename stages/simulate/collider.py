"""What cloth collides with: the body without the segments that its own stage left out, closed where they were."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from stages.spec import DataError

COVERED = 0.002
"""A garment covers what was left out if more than this share of its vertices is nearest to it."""


def closed(faces: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """The faces kept [F], and a fan over each hole that the others leave: a closed surface again, shape [G, 3]."""
    if kept.all():
        return faces
    rest = faces[kept]
    edges = np.concatenate([rest[:, [0, 1]], rest[:, [1, 2]], rest[:, [2, 0]]])
    known = {(int(a), int(b)) for a, b in edges}
    after = {b: a for a, b in known if (b, a) not in known}  # along the hole, as a face over it runs
    caps: list[tuple[int, int, int]] = []
    while after:
        first, at = after.popitem()
        loop = [first, at]
        while at in after:
            at = after.pop(at)
            loop.append(at)
        caps += [(first, b, c) for b, c in pairwise(loop[1:]) if c != first]
    return np.concatenate([rest, np.array(caps, rest.dtype).reshape(-1, 3)])


def refuse_covered(
    names: Sequence[str], garments: Mapping[str, np.ndarray], rest: np.ndarray, faces: np.ndarray, kept: np.ndarray
) -> None:
    """Refuse an outfit that covers what the body's stage left out of the collider.

    Args:
        names: What was left out, for messages.
        garments: Name -> vertices in the rest frame [m], shape [N, 3].
        rest: Body at rest [m], shape [V, 3].
        faces: Shape [F, 3]; kept: those that cloth collides with, shape [F].

    Raises:
        DataError: Naming the garment and what it covers.
    """
    if kept.all():
        return
    out = np.ones(len(rest), bool)
    out[faces[kept]] = False
    tree = cKDTree(rest)
    for name, x in garments.items():
        share = float(out[tree.query(x)[1]].mean())
        if share > COVERED:
            raise DataError(
                f"{name}: covers {', '.join(names)} with {share:.1%} of its vertices, which the body can only be "
                f"dressed without; at most {COVERED:.1%} may; choose an outfit with shorter sleeves or another motion"
            )
