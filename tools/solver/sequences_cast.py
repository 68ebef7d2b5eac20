"""Who wears what and does what in the twenty sequences: real clips in turn, shapes and tightness at their extremes."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, zip_longest
from pathlib import Path

from pipeline.dataset import GENDERS, OUTFITS
from pipeline.motion import read_motion
from stages.outfit.config import Config as OutfitConfig

SHORTEST = 30
"""Rests of a clip shorter than this aren't taken [frames]."""
CORNERS = ((3, 3), (-3, 3), (3, -3), (-3, -3))
"""The first two betas, size and fatness: four people at their corners, the others of the mean shape."""
MIXED = ((1, 1, -1, 1, -1, -1, 1, -1, 1, -1), (-1, 1, 1, -1, -1, 1, -1, 1, 1, -1))
"""Signs of all ten betas, each with its opposite: at 3 the body itself would fold."""
MIXED_SIZE = 1.5


@dataclass(frozen=True)
class Clip:
    """A piece of a motion file: from frame `start` on, `frames` of them, at 30 fps."""

    path: Path
    start: int
    frames: int

    @property
    def name(self) -> str:
        """The file, and where in it the piece starts if it isn't at its beginning."""
        return f"{self.path.stem}_from{self.start}" if self.start else self.path.stem

    @property
    def kind(self) -> str:
        """Kind of motion: files of one kind differ in a number at the end of their name."""
        return re.sub(r"[_\d]+$", "", self.path.stem)


@dataclass(frozen=True)
class Member:
    """One sequence: a person in an outfit, and what they do.

    Attributes:
        name: Of the sequence; gender, outfit, betas: of the person.
        clip: What they do.
        tightness: Range of both its components; upper, lower: fabrics of what is worn above and below the waist.
    """

    name: str
    gender: str
    outfit: str
    clip: Clip
    betas: tuple[float, ...]
    tightness: tuple[float, float]
    upper: str
    lower: str

    def recipe(self, accuracy: str, threads: int) -> str:
        """The recipe of this sequence alone: a recipe gives one shape to everybody."""
        # A path is written as JSON, which TOML reads the same.
        return f"""# Written by python -m tools.solver.sequences.

[dataset]
name = "{self.name}"

[[dataset.sequence]]
id = "{self.name}"
gender = "{self.gender}"
motion = {json.dumps(str(self.clip.path))}
start = {self.clip.start}
frames = {self.clip.frames}
outfit = "{self.outfit}"
split = "train"

[body]
betas = {[float(b) for b in self.betas]}

[outfit]
tightness_range = {list(self.tightness)}
upper_fabrics = ["{self.upper}"]
lower_fabrics = ["{self.lower}"]

[simulate]
accuracy = "{accuracy}"
threads = {threads}
"""


def shapes() -> list[tuple[float, ...]]:
    """Betas of the people in turn: corners of the first two, each of the others alone at +-3, all ten mixed."""
    corners = [(*corner, *[0] * 8) for corner in CORNERS]
    alone = [tuple(3 * (-1) ** k if i == k else 0 for i in range(10)) for k in range(2, 10)]
    mixed = [tuple(sign * MIXED_SIZE * s for s in signs) for signs in MIXED for sign in (1, -1)]
    opposite = [tuple(-b for b in betas) for betas in alone]
    # In turn, so that the first few already have every kind.
    return [tuple(map(float, b)) for b in chain(*zip_longest(corners, alone, mixed, opposite)) if b is not None]


def clips(folder: Path, frames: int) -> list[Clip]:
    """Pieces of up to `frames` of the folder's BVH files, one of every kind of motion in turn, the longest first.

    Rests of a file come after its whole pieces.
    """
    kinds = defaultdict(list)
    for path in sorted(folder.glob("**/*.bvh")):
        length = read_motion(path, str(folder)).frames
        for start in range(0, length, frames):
            if length - start >= min(SHORTEST, frames) or start == 0:
                clip = Clip(path.resolve(), start, min(frames, length - start))
                kinds[clip.kind].append(clip)
    for pieces in kinds.values():
        pieces.sort(key=lambda clip: (clip.start // frames > 0 and clip.frames < frames, -clip.frames))
    return [clip for turn in zip_longest(*kinds.values()) for clip in turn if clip is not None]


def cast(folder: Path, count: int, frames: int) -> list[list[Member]]:
    """`count` sequences: the clips of `folder` in turn, each with another person, outfit, tightness and fabrics.

    Each is a list of takes: the body stage rejects people whose limbs can't be freed in a motion, and then somebody of
    the opposite shape takes their place, then they do something else: what is left over, of the same kind if possible.
    """
    found = clips(folder, frames)
    members = [_member(k, found[k % len(found)]) for k in range(count)] if found else []
    return [[member, _opposite(member), *_elsewhere(member, found[count:])] for member in members]


def _member(k: int, clip: Clip) -> Member:
    config, people = OutfitConfig(), shapes()
    kinds, uppers, lowers = len(OUTFITS), config.upper_fabrics, config.lower_fabrics
    low, high = config.tightness_range
    # All in turn, but out of step: within two rounds of the outfits each is worn by both genders.
    return Member(
        name=f"{k + 1:02}_{OUTFITS[k % kinds].replace('+', '_')}_{clip.name}",
        gender=GENDERS[(k + k // kinds) % len(GENDERS)],
        outfit=OUTFITS[k % kinds],
        clip=clip,
        betas=people[k % len(people)],
        tightness=((low, low), (high, high), (low, high))[(k + k // kinds) % 3],
        upper=uppers[(k + k // 2) % len(uppers)],
        lower=lowers[(k + k // 4) % len(lowers)],
    )


def _opposite(member: Member) -> Member:
    return replace(member, name=f"{member.name}_opposite", betas=tuple(-b for b in member.betas))


def _elsewhere(member: Member, spare: Sequence[Clip]) -> list[Member]:
    """The same person in up to three of the clips."""
    best = sorted(spare, key=lambda clip: (clip.kind != member.clip.kind, -clip.frames))[:3]
    return [replace(member, name=member.name.replace(member.clip.name, clip.name), clip=clip) for clip in best]
