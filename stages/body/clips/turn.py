"""Turning on the spot: eyes first, then hips, then the feet step round; a quarter, a half, a quarter back."""

import numpy as np
from numpy.typing import NDArray

from stages.body.clips.choreography import ArmKeys, Choreography, standing_height
from stages.body.clips.keys import ease
from stages.body.clips.steps import Step, footfalls, support
from stages.body.figure import Figure
from stages.body.posture import Arm, Posture
from stages.body.turns import rotate
from stages.body.turns import turn as about

SECONDS = 10.0
"""Length of the clip [s]."""

TURNS = ((0.8, 0.0, np.pi / 2), (3.6, np.pi / 2, -np.pi / 2), (7.2, -np.pi / 2, 0.0))
"""Start [s], heading before and after [rad] of each turn."""

STEP_TIME = 0.42
"""From one foot's lift to the other's [s]."""

TOE_OUT = 0.12
"""Heading of a foot away from the body's, outward [rad]."""


def turn(figure: Figure, times: NDArray[np.float64]) -> tuple[Posture, tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """The posture of turning about, and when each foot is on the ground; `times` [s], shape [T]."""
    leg, wide = figure.leg_length, 1.08 * figure.stance

    def place(side: int, yaw: float) -> tuple[float, float]:
        spot = rotate(about("y", yaw), [(wide, -wide)[side], 0.0, 0.0])
        return float(spot[0]), float(spot[2])

    steps: list[Step] = []
    heading, gaze, moving = [(0.0, 0.0)], [(0.0, 0.0)], [(0.0, 0.0)]
    for start, before, after in TURNS:
        first = 0 if after > before else 1
        count = 2 * int(np.ceil(abs(after - before) / 1.1))
        for k in range(count):
            side = (first + k) % 2
            # The foot on the inside opens the turn ahead of the body; the other one closes behind it.
            done = min(1.0, (k + (1.6 if side == first else 1.0)) / (count - 0.4)) if k < count - 1 else 1.0
            yaw = before + (after - before) * done
            lift = start + 0.3 + k * STEP_TIME
            sign = (1.0, -1.0)[side]
            steps.append(
                Step(
                    side=side,
                    lift=lift,
                    land=lift + 0.8 * STEP_TIME,
                    place=place(side, yaw),
                    yaw=yaw + sign * TOE_OUT,
                    height=0.085,
                    strike=0.12,
                )
            )
        end = start + 0.3 + count * STEP_TIME
        heading += [(start + 0.15, before), (end, after)]
        gaze += [(start - 0.1, before), (start + 0.55 * (end - start), after)]
        moving += [(start, 0.0), (start + 0.4, 1.0), (end - 0.3, 1.0), (end + 0.3, 0.0)]
    beginnings = ((*place(0, 0.0), TOE_OUT), (*place(1, 0.0), -TOE_OUT))
    plants, swings = footfalls(beginnings, steps, float(times[-1]))
    weight = 0.55 * support(times, plants)
    facing, busy, look = ease(times, heading), ease(times, moving), ease(times, gaze)
    speed = np.gradient(facing, times)
    beat = np.sin(2 * np.pi * times / (2 * STEP_TIME))
    bob = -0.012 * leg * busy * (1 - np.cos(2 * np.pi * times / STEP_TIME)) / 2
    idle = np.sin(2 * np.pi * times / 4.3)
    drift = 0.008 * leg * rotate(about("y", facing), [1.0, 0.0, 0.0]) * idle[:, None]
    root = drift + np.stack([weight[:, 0], standing_height(figure, 0.012) + bob, weight[:, 1]], axis=-1)
    lag = np.deg2rad(np.clip(7.0 * speed, -18, 18))
    held = ArmKeys(out=((0.0, 15.0),), forward=((0.0, 0.0),), elbow=((0.0, 17.0),)).at(times)
    arms = []
    for sign in (1.0, -1.0):
        # Arms trail the turn: they are flung outward and lag behind it.
        arms.append(
            Arm(
                out=held.out + np.deg2rad(5) * busy + np.abs(lag) * 0.5,
                forward=sign * lag + np.deg2rad(5) * busy * sign * beat,
                twist=held.twist,
                elbow=held.elbow + np.deg2rad(8) * busy,
                wrist=held.wrist,
            )
        )
    return Choreography(
        times=times,
        plants=plants,
        swings=swings,
        root=root,
        yaw=facing,
        tilt=np.full_like(times, np.deg2rad(4)),
        lean=np.deg2rad(1.0) * idle * (1 - busy),
        bend=np.deg2rad(0.8) * idle,
        twist=np.clip(look - facing, -0.7, 0.7) * 0.35,
        side=-np.deg2rad(1.0) * idle * (1 - busy),
        look=facing + np.clip(look - facing, -0.9, 0.9),
        nod=np.deg2rad(4 + 5 * busy),
        arms=(arms[0], arms[1]),
        knees_out=0.1,
    ).stage(figure)
