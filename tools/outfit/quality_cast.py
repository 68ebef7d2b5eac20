"""Who wears what in the report on outfits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.body import GENDERS
from stages.outfit.plan import KINDS

BETAS = 10
CORNER = 3.0


@dataclass(frozen=True)
class Member:
    """One person, and the kind of outfit made for them."""

    gender: str
    kind: str
    betas: tuple[float, ...]
    """Each at one end of [-3, 3]."""
    seed: int
    """Of the outfit's random numbers."""


def cast(count: int) -> list[Member]:
    """`count` people at corners of shape space, kinds of outfit and genders in turn.

    The four corners of size and fatness come in turn too; the other betas are -3 or 3 by chance, seeded.
    """
    rng = np.random.default_rng(5)
    members = []
    for number in range(count):
        betas = rng.choice([-CORNER, CORNER], BETAS)
        turn = number // (len(GENDERS) * len(KINDS))
        betas[:2] = [(-CORNER, CORNER)[turn % 2], (-CORNER, CORNER)[turn // 2 % 2]]
        gender, kind = GENDERS[number % len(GENDERS)], KINDS[number // len(GENDERS) % len(KINDS)]
        members.append(Member(gender, kind, tuple(map(float, betas)), 1000 + number))
    return members
