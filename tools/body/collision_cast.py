"""Who does what in the report on self-collision."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path

import numpy as np

from stages.body.clips import CLIPS

SUFFIXES = (".bvh", ".amc", ".npz")
CORNERS = ((3, 3), (-3, 3), (3, -3), (-3, -3))
"""The first two betas, size and fatness."""


@dataclass(frozen=True)
class Member:
    """One sequence."""

    gender: str
    betas: tuple[float, ...]
    shape: str
    """What the shape is, in words."""
    motion: str


def cast(folder: Path, count: int) -> list[Member]:
    """`count` sequences: embedded clips and the folder's files in turn, people at corners of shape space in turn.

    Of four people two are at a corner of all ten betas, one at a corner of size and fatness, one drawn uniformly, as
    the stage does it. Seeded: the same each time.
    """
    files = [str(path) for path in sorted(folder.glob("**/*")) if path.suffix.lower() in SUFFIXES]
    motions = list(islice(cycle([*CLIPS, *files]), count))
    rng = np.random.default_rng(4)
    members = []
    for k, motion in enumerate(motions):
        signs, drawn = rng.choice([-3.0, 3.0], 10), rng.uniform(-3.0, 3.0, 10).round(2)
        if k % 4 < 2:
            betas, shape = signs, "corner of all"
        elif k % 4 == 2:
            betas, shape = np.array([*CORNERS[k // 4 % 4], *[0.0] * 8]), "corner of two"
        else:
            betas, shape = drawn, "drawn"
        members.append(Member(("female", "male")[k // 2 % 2], tuple(map(float, betas)), shape, motion))
    return members
