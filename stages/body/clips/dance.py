"""A dance of twenty beats: side steps with a bounce, hips and waving arms, a full turn, and side steps again."""

import numpy as np
from numpy.typing import NDArray

from stages.body.clips.choreography import ArmKeys, Choreography, standing_height
from stages.body.clips.keys import ease
from stages.body.clips.steps import Step, footfalls, support
from stages.body.figure import Figure
from stages.body.posture import Posture
from stages.body.turns import rotate, turn

BEAT = 0.54
"""Time of a beat [s]: 111 a minute."""

SECONDS = 20 * BEAT
"""Length of the clip [s]."""

TOE_OUT = 0.22
"""Heading of a foot away from the body's, outward [rad]."""


def dance(figure: Figure, times: NDArray[np.float64]) -> tuple[Posture, tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """The posture of the dance, and when each foot is on the ground; `times` [s], shape [T]."""
    leg, wide = figure.leg_length, 1.2 * figure.stance
    stride = 0.50 * leg
    beats = times / BEAT
    steps = _side_steps(1, 8, wide, stride) + _turn_steps(12, wide) + _side_steps(16, 4, wide, stride, 2 * np.pi)
    beginnings = ((wide, 0.0, TOE_OUT), (-wide, 0.0, -TOE_OUT))
    plants, swings = footfalls(beginnings, steps, float(times[-1]))
    weight = support(times, plants, favour=0.25)

    grounded = ease(beats, [(8.2, 0), (8.8, 1), (11.3, 1), (11.9, 0)])
    stepping = ease(beats, [(0.4, 0), (1.0, 1), (8.0, 1), (8.6, 0), (15.7, 0), (16.2, 1), (18.8, 1), (19.4, 0)])
    pulse = 0.5 - 0.5 * np.cos(2 * np.pi * (beats - 0.1))
    spinning = ease(beats, [(11.9, 0), (15.7, 1)])
    facing = 2 * np.pi * spinning
    circle = np.pi * (beats - 8.5)
    hips = grounded[:, None] * 0.07 * leg * np.stack([np.sin(circle), 0 * beats, 0.6 * np.cos(circle)], axis=-1)
    depth = 0.012 + (0.028 + 0.045 * grounded) * pulse * ease(beats, [(0.2, 0), (1.0, 1)])
    root = hips + np.stack([weight[:, 0], standing_height(figure) - depth * leg, weight[:, 1]], axis=-1)

    sway = np.sin(np.pi * (beats - 0.5)) * stepping
    roll = np.sin(circle) * grounded
    lean = np.deg2rad(6) * sway + np.deg2rad(8) * roll
    left, right = _arms(1.0), _arms(-1.0)
    return Choreography(
        times=times,
        plants=plants,
        swings=swings,
        root=root,
        yaw=facing + np.deg2rad(9) * sway,
        tilt=np.deg2rad(4 + 3 * pulse),
        lean=lean,
        bend=np.deg2rad(2 + 4 * pulse * stepping),
        twist=-np.deg2rad(14) * sway + np.deg2rad(10) * np.cos(circle) * grounded,
        side=-1.5 * lean,
        look=facing + ease(beats, [(11.6, 0), (12.4, 0.35), (15.0, 0.35), (15.9, 0)]) + 0.15 * sway,
        nod=np.deg2rad(2 + 5 * pulse * (stepping + grounded)),
        arms=(left.at(beats), right.at(beats)),
        knees_out=0.2,
    ).stage(figure)


def _side_steps(first: int, count: int, wide: float, stride: float, facing: float = 0.0) -> list[Step]:
    """Step to the side, tap with the other foot, and back: four beats."""
    steps = []
    for k in range(count):
        beat = first + k
        going, tapping = k % 4 in (0, 2), k % 2 == 1
        side = 1 if k % 4 in (0, 3) else 0
        sign = (1.0, -1.0)[side]
        away = k % 4 in (0, 1)
        centre = -stride if away else 0.0
        x = centre + sign * wide * (1.0 if going else 0.95)
        steps.append(
            Step(
                side=side,
                lift=(beat - 0.62) * BEAT,
                land=(beat + 0.02) * BEAT,
                place=(x, 0.0 if going else 0.03),
                yaw=facing + sign * TOE_OUT,
                height=0.10,
                strike=0.42 if tapping else 0.2,
                held=0.42 if tapping else 0.0,
            )
        )
    return steps


def _turn_steps(first: int, wide: float) -> list[Step]:
    """Once round to the left in eight quick steps; the last tap of the side steps comes down first."""
    steps = []
    for k in range(8):
        side = k % 2
        sign = (1.0, -1.0)[side]
        yaw = 2 * np.pi * min(1.0, (k + 1.4) / 8) if k < 7 else 2 * np.pi
        spot = rotate(turn("y", yaw), np.array([sign * wide, 0.0, 0.0]))
        lift = (first - 0.25 + 0.47 * k) * BEAT
        steps.append(
            Step(
                side=side,
                lift=lift,
                land=lift + 0.42 * BEAT,
                place=(float(spot[0]), float(spot[2])),
                yaw=yaw + sign * TOE_OUT,
                height=0.075,
                strike=0.2,
            )
        )
    return steps


def _arms(sign: float) -> ArmKeys:
    """Keys of one arm in beats: the arms pump with the side steps, wave overhead, open in the turn, and rise again."""
    out, forward, elbow, twist = [(0.0, 15.0)], [(0.0, 0.0)], [(0.0, 20.0)], [(0.0, 8.0)]
    for beat in range(1, 8):
        front = (beat % 2 == 0) == (sign > 0)
        out.append((beat, 26.0 if front else 30.0))
        forward.append((beat, 34.0 if front else -24.0))
        elbow.append((beat, 88.0 if front else 70.0))
        twist.append((beat, 6.0 if front else -4.0))
    for beat in range(9, 12):
        high = (beat % 2 == 0) == (sign > 0)
        out.append((beat, 128.0 if high else 102.0))
        forward.append((beat, 18.0))
        elbow.append((beat, 38.0 if high else 66.0))
        twist.append((beat, -58.0))
    out += [(12.6, 74.0), (15.2, 70.0)]
    forward += [(12.6, 12.0), (15.2, 8.0)]
    elbow += [(12.6, 18.0), (15.2, 22.0)]
    twist += [(12.6, -10.0), (15.2, -6.0)]
    for beat in range(16, 19):
        front = (beat % 2 == 0) == (sign > 0)
        out.append((beat, 30.0))
        forward.append((beat, 56.0 if front else 6.0))
        elbow.append((beat, 60.0 if front else 84.0))
        twist.append((beat, 2.0))
    out.append((19.4, 112.0 if sign > 0 else 24.0))
    forward.append((19.4, 22.0 if sign > 0 else 4.0))
    elbow.append((19.4, 24.0 if sign > 0 else 40.0))
    twist.append((19.4, -30.0 if sign > 0 else 0.0))
    return ArmKeys(out=out, forward=forward, elbow=elbow, twist=twist)
