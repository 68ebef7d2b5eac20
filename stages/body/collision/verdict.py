"""Whether a body's collisions are solved, and if not, why, where, and whose they are."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.collision.segments import ARMS, NAMES, Segments, pair_name
from stages.body.collision.solve import Solution
from stages.body.hygiene import Opening

MM = 1e3

THIN = ("hand", "foot")
"""Segments too thin to be dented as deep as others."""

THIN_MOVE = 0.02
"""The farthest that skin of a pair with a thin segment may be moved [m]: hands are 25 to 30 mm thick."""


@dataclass(frozen=True)
class Fault:
    """One reason why a body can't be dressed."""

    cause: str
    """What, where, the value and the limit, on one line."""
    frame: int
    """Where it is worst."""
    segments: tuple[int, ...]
    """The segments at fault, rows of `NAMES`."""
    frames: tuple[int, ...]
    """All frames in which it is so."""


def opening_faults(opening: Opening, largest_turn: float, largest_shift: float) -> list[Fault]:
    """Arms that had to be turned, or feet that had to be moved, farther than allowed [rad, m]."""
    found = []
    legs = tuple(NAMES.index(f"{side}_thigh") for side in ("left", "right"))
    for side, word in enumerate(("left", "right")):
        for what, values, limit, unit, key, segments in (
            ("arm", opening.arm_turn, largest_turn, "rad", "largest_turn", ARMS[side]),
            ("foot", opening.foot_shift, largest_shift, "m", "largest_shift", legs),
        ):
            frame = int(values[:, side].argmax())
            if values[frame, side] > limit:
                done = "turning" if what == "arm" else "moving"
                cause = (
                    f"the limbs are free only after {done} the {word} {what} by {values[frame, side]:.2f} {unit} in "
                    f"frame {frame}, more than {key} = {limit:g} {unit}"
                )
                found.append(Fault(cause, frame, segments, _where(values[:, side] > limit)))
    return found


def limits(segments: Segments, largest_move: float) -> dict[tuple[int, int], float]:
    """The farthest that skin may be moved to part each pair of segments [m]."""
    return {
        pair: min(largest_move, THIN_MOVE) if any(NAMES[row].endswith(THIN) for row in pair) else largest_move
        for pair in segments.pairs
    }


def parting_faults(solution: Solution, limit: Mapping[tuple[int, int], float]) -> list[Fault]:
    """Pairs of segments that still cross, or whose skin had to be moved farther than allowed [m]; the worst first."""
    found = []
    for pair, parting in solution.partings.items():
        frame = int(parting.moved.argmax())
        if parting.moved[frame] > limit[pair]:
            word = "largest_move" if limit[pair] == max(limit.values()) else "the limit of hands and feet"
            cause = (
                f"{pair_name(pair)} are parted only by moving skin {parting.moved[frame] * MM:.0f} mm in frame "
                f"{frame}, more than {word} = {limit[pair] * MM:g} mm"
            )
            found.append((parting.moved[frame], Fault(cause, frame, pair, _where(parting.moved > limit[pair]))))
    for pair, left in solution.left.items():
        frame = int(left.argmax())
        cause = (
            f"{pair_name(pair)} still cross in {np.count_nonzero(left)} frames, at {left[frame]} edges in frame {frame}"
        )
        found.append((0.0, Fault(cause, frame, pair, _where(left > 0))))
    return [fault for _, fault in sorted(found, key=lambda item: -item[0])]


def _where(mask: NDArray[np.bool_]) -> tuple[int, ...]:
    return tuple(np.flatnonzero(mask).tolist())
