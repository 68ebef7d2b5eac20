"""Squats and reaches: down with the arms in front, up to the ceiling, and low to either side."""

import numpy as np
from numpy.typing import NDArray

from stages.body.clips.choreography import ArmKeys, Choreography, standing_height
from stages.body.clips.footfalls import Plant
from stages.body.clips.keys import ease
from stages.body.figure import Figure
from stages.body.posture import Posture

SECONDS = 11.0
"""Length of the clip [s]."""


DEPTHS = (
    *((0.5, 0.0), (1.7, 0.42), (2.0, 0.42), (3.1, 0.0)),
    *((5.9, 0.0), (6.7, 0.30), (7.0, 0.30), (7.7, 0.04), (8.3, 0.30), (8.6, 0.30), (9.6, 0.0)),
)
"""(time [s], how much lower the pelvis is [leg lengths])."""

NODS = (
    *((0.5, 4.0), (3.1, 2.0), (4.3, -26.0), (4.9, -26.0), (5.8, 4.0)),
    *((6.75, 34.0), (7.0, 34.0), (7.65, 6.0), (8.35, 34.0), (8.6, 34.0), (9.6, 4.0)),
)
"""(time [s], forward tilt of the head [degrees])."""

Angles = tuple[float, float, float]

HANGING, LOW, HIGH = (15.0, 0.0, 15.0), (24.0, 52.0, 10.0), (40.0, -8.0, 25.0)
ARMS: tuple[tuple[float, Angles, Angles], ...] = (
    (0.5, HANGING, HANGING),
    (1.6, (8.0, 100.0, 12.0), (8.0, 100.0, 12.0)),
    (2.1, (8.0, 100.0, 12.0), (8.0, 100.0, 12.0)),
    (2.7, (11.0, 50.0, 32.0), (11.0, 50.0, 32.0)),
    (3.1, (15.0, 0.0, 18.0), (15.0, 0.0, 18.0)),
    (3.6, (18.0, 40.0, 45.0), (18.0, 38.0, 45.0)),
    (4.3, (22.0, 158.0, 10.0), (22.0, 156.0, 12.0)),
    (4.9, (22.0, 158.0, 10.0), (22.0, 161.0, 10.0)),
    (5.4, (20.0, 90.0, 42.0), (20.0, 92.0, 42.0)),
    (5.8, (18.0, 4.0, 20.0), (18.0, 4.0, 20.0)),
    (6.7, LOW, HIGH),
    (7.0, LOW, HIGH),
    (7.6, (20.0, 10.0, 35.0), (20.0, 10.0, 35.0)),
    (8.3, HIGH, LOW),
    (8.6, HIGH, LOW),
    (9.7, HANGING, HANGING),
)
"""(time [s], left arm, right arm), each arm as (out, forward, elbow) [degrees]."""


def squat(figure: Figure, times: NDArray[np.float64]) -> tuple[Posture, tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """The posture of squats and reaches, and when each foot is on the ground; `times` [s], shape [T]."""
    leg, wide = figure.leg_length, max(1.45 * figure.stance, 0.20 * figure.leg_length)
    last = float(times[-1]) + 1.0
    plants = [[Plant(start=-1.0, end=last, place=(sign * wide, 0.0), yaw=sign * 0.38)] for sign in (1.0, -1.0)]

    depth = ease(times, DEPTHS)
    across = ease(times, [(5.9, 0), (6.7, 0.06), (7.0, 0.06), (7.6, 0), (8.3, -0.06), (8.6, -0.06), (9.6, 0)])
    root = np.stack([across * leg, standing_height(figure) - depth * leg, -0.30 * depth * leg], axis=-1)
    low_left, low_right = (6.75, 7.0), (8.35, 8.6)
    left, right = _arm(0), _arm(1)
    turned = ((5.9, 0), (low_left[0], 1), (low_left[1], 1), (7.65, 0), (low_right[0], -1), (low_right[1], -1), (9.6, 0))
    towards = ease(times, turned)
    down = ease(times, [(0.5, 0), (1.7, 1), (2.0, 1), (3.1, 0)])
    reach_up = ease(times, [(3.2, 0), (4.35, 1), (4.9, 1), (5.8, 0)])
    nod = ease(times, NODS)
    breath = np.deg2rad(0.8) * np.sin(2 * np.pi * times / 3.7)
    return Choreography(
        times=times,
        plants=(plants[0], plants[1]),
        swings=([], []),
        root=root,
        yaw=0.16 * towards,
        tilt=np.deg2rad(4 + 22 * down + 20 * np.abs(towards) - 5 * reach_up),
        lean=np.zeros_like(times),
        bend=np.deg2rad(8 * down + 20 * np.abs(towards) - 9 * reach_up) + breath,
        twist=0.42 * towards,
        side=-0.16 * towards,
        look=0.5 * towards,
        nod=np.deg2rad(nod),
        arms=(left.at(times), right.at(times)),
        knees_out=0.34,
    ).stage(figure)


def _arm(side: int) -> ArmKeys:
    """Keys of one arm."""
    out, forward, elbow = ([(row[0], (row[1], row[2])[side][i]) for row in ARMS] for i in range(3))
    return ArmKeys(out=out, forward=forward, elbow=elbow)
