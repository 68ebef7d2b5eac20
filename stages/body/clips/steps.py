"""Steps on the spot and about: footfalls from a list of steps, and the weight of the body that follows them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from stages.body.clips.footfalls import Plant, Swing

Array = NDArray[np.float64]

WEIGHT_SHIFT = 0.16
"""Standard deviation in time of the shift of weight between the feet [s]."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """One foot goes to a new place."""

    side: int
    """0 is the left foot, 1 the right."""
    lift: float
    """When it leaves the ground [s]."""
    land: float
    """When it touches it again [s]."""
    place: tuple[float, float]
    """Where, ground position (x, z) [m]."""
    yaw: float
    """New heading of the foot [rad], positive to the left."""
    height: float = 0.10
    """How high the ankle rises [leg lengths]."""
    strike: float = 0.26
    """Pitch on landing [rad], positive on the ball."""
    held: float = 0.0
    """Pitch afterwards [rad]: a foot that only taps with its ball keeps the heel up."""


def footfalls(
    start: tuple[tuple[float, float, float], tuple[float, float, float]], steps: Sequence[Step], last: float
) -> tuple[tuple[list[Plant], list[Plant]], tuple[list[Swing], list[Swing]]]:
    """Plants and swings of both feet.

    Args:
        start: First place (x, z) [m] and heading [rad] of the left and the right foot.
        steps: Steps in order of time.
        last: When the clip ends [s].

    Returns:
        Plants of each foot, and the swings between them.
    """
    plants: tuple[list[Plant], list[Plant]] = ([], [])
    swings: tuple[list[Swing], list[Swing]] = ([], [])
    for side in (0, 1):
        here, since, strike, held = start[side], -1.0, 0.0, 0.0
        for step in [s for s in steps if s.side == side]:
            contact = step.lift - since
            leave = max(held, 0.45)
            plants[side].append(
                Plant(
                    start=since,
                    end=step.lift,
                    place=here[:2],
                    yaw=here[2],
                    strike=strike,
                    settle=min(0.14, 0.4 * contact),
                    leave=leave,
                    peel=min(0.22, 0.5 * contact),
                    held=held,
                )
            )
            swings[side].append(Swing(height=((0.45, step.height),), pitch=((0.4, 0.35),)))
            here, since, strike, held = (*step.place, step.yaw), step.land, step.strike, step.held
        plants[side].append(
            Plant(
                start=since,
                end=last + 1.0,
                place=here[:2],
                yaw=here[2],
                strike=strike,
                settle=0.14,
                leave=held,
                held=held,
            )
        )
    return plants, swings


def support(times: Array, plants: tuple[list[Plant], list[Plant]], favour: float = 1.0) -> Array:
    """Where the weight is: over the feet that stand, gliding from one to the other.

    Args:
        times: Times [s], shape [T].
        plants: Plants of both feet.
        favour: Weight of a foot that only taps, relative to a flat one.

    Returns:
        Ground positions (x, z) [m], shape [T, 2].
    """
    total, weight = np.zeros((len(times), 2)), np.full(len(times), 1e-9)
    for side in (0, 1):
        for plant in plants[side]:
            share = np.where((times >= plant.start) & (times <= plant.end), favour if plant.held > 0 else 1.0, 0.0)
            total += share[:, None] * np.array(plant.place)
            weight += share
    sigma = WEIGHT_SHIFT / (times[1] - times[0])
    return gaussian_filter1d(total / weight[:, None], sigma, axis=0, mode="nearest")
