"""Walking and running along a path: one parametric gait, from a handful of numbers to a whole posture."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.clips.footfalls import Plant, Swing, track
from stages.body.clips.footing import ceiling
from stages.body.figure import SIDES, Figure
from stages.body.posture import Arm, Posture
from stages.body.sole import Sole, measure_sole
from stages.body.turns import rotate, turn

Array = NDArray[np.float64]

GRAVITY = 9.81
"""Acceleration of free fall [m/s^2]."""


@dataclass(frozen=True, kw_only=True)
class Gait:
    """A way of going. Phase 0 is the left foot's first contact; lengths scale with the leg, times with its root."""

    speed: float
    """Speed [leg lengths per natural second]; a natural second is sqrt(leg length / 1 m) seconds."""
    cycle: float
    """Time of two steps [natural seconds]."""
    duty: float
    """Share of the cycle in which a foot is on the ground; below 0.5 the gait flies."""
    strike: float
    """Pitch of the foot at first contact [rad]."""
    settle: float
    """Share of the contact until the foot is flat."""
    leave: float
    """Pitch of the foot at last contact [rad]."""
    peel: float
    """Share of the contact in which the heel rises."""
    ahead: float
    """How far in front of the root joint the middle of the contact lies [leg lengths]."""
    narrowing: float
    """Distance of the foot from the midline, as a share of the stance that just parts the thighs."""
    bounce: float
    """Half the vertical travel of the pelvis [leg lengths]; only for gaits that don't fly."""
    crouch: float
    """How much lower than its highest the pelvis stays [leg lengths]."""
    swing: Swing
    """Path of a foot in the air."""
    sway: float
    """Half the sideways travel of the pelvis [leg lengths]."""
    pelvis: tuple[float, float, float]
    """Constant tilt, amplitudes of the pelvis' turn and list [rad]."""
    chest: tuple[float, float, float]
    """Constant bend, amplitudes of turn and lean relative to the pelvis [rad]."""
    toe_out: float
    """Heading of the feet away from the path [rad]."""
    arm_out: float
    """Arms away from the body [rad]."""
    arm_swing: tuple[float, float]
    """Mean and amplitude of the arms' swing [rad]."""
    elbow: tuple[float, float]
    """Mean and amplitude of the elbows' bend [rad]."""
    arm_twist: float
    """Turn of the bent forearms inward [rad]."""


def go(
    figure: Figure, gait: Gait, times: Array, heading: Callable[[Array], Array]
) -> tuple[Posture, tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """A person who goes along a path.

    Args:
        figure: The person.
        gait: How the person goes.
        times: Times [s], evenly spaced, shape [T].
        heading: Heading of the path at any time [rad], positive to the left.

    Returns:
        The posture, and which frames have the left and the right foot on the ground, shape [T] each.
    """
    leg = figure.leg_length
    cycle, speed = gait.cycle * np.sqrt(leg), gait.speed * np.sqrt(leg)
    dt = times[1] - times[0]
    long = np.arange(times[0] - 2 * cycle, times[-1] + 2 * cycle, dt)
    velocity = speed * np.stack([np.sin(heading(long)), np.zeros(len(long)), np.cos(heading(long))], axis=-1)
    path = np.cumsum(velocity, axis=0) * dt
    path -= [np.interp(times[0], long, path[:, i]) for i in range(3)]
    phase, facing = 2 * np.pi * long / cycle, heading(long)
    soles = measure_sole(figure, 0), measure_sole(figure, 1)
    plants = [_plants(figure, gait, cycle, long, path, facing, side) for side in (0, 1)]

    root = path + gait.sway * leg * np.sin(phase - 0.4)[:, None] * rotate(turn("y", facing), [1.0, 0.0, 0.0])
    tilt, turning, listing = gait.pelvis
    yaw, drop = -turning * np.cos(phase), listing * np.sin(phase + 0.15)
    pelvis = turn("y", facing + yaw) @ turn("z", drop) @ turn("x", np.full(len(long), tilt))
    root[:, 1] = _height(figure, gait, cycle, long, root, pelvis, plants, soles)

    feet = [
        track(figure, i, plants[i], [gait.swing] * (len(plants[i]) - 1), long, root, pelvis, facing) for i in (0, 1)
    ]
    keep = slice(int(np.argmin(np.abs(long - times[0]))), None)
    keep = slice(keep.start, keep.start + len(times))
    bend, twist, lean = gait.chest
    trunk = np.stack([np.full(len(long), bend), twist * np.cos(phase), -lean * np.sin(phase + 0.15)], axis=-1)
    posture = Posture(
        root=root[keep],
        pelvis=pelvis[keep],
        ankles=(feet[0].ankle[keep], feet[1].ankle[keep]),
        feet=(feet[0].rotation[keep], feet[1].rotation[keep]),
        toes=(feet[0].toe[keep], feet[1].toe[keep]),
        knees_out=np.full(len(times), gait.toe_out),
        trunk=trunk[keep],
        gaze=(turn("y", heading(long + 0.25)) @ turn("x", np.full(len(long), 0.04)))[keep],
        arms=(_arm(gait, phase[keep], 0), _arm(gait, phase[keep], 1)),
    )
    return posture, (feet[0].planted[keep], feet[1].planted[keep])


def _plants(
    figure: Figure, gait: Gait, cycle: float, long: Array, path: Array, facing: Array, side: int
) -> list[Plant]:
    """All contacts of one foot, from before the first time to after the last."""
    leg, contact = figure.leg_length, gait.duty * cycle
    first = int(np.ceil(long[0] / cycle - 0.5 * side))
    last = int(np.floor((long[-1] - contact) / cycle - 0.5 * side))
    plants = []
    for k in range(first, last + 1):
        start = (k + 0.5 * side) * cycle
        middle = start + contact / 2
        yaw = float(np.interp(middle, long, facing))
        centre = np.array([np.interp(middle, long, path[:, i]) for i in range(3)])
        reachable = [SIDES[side] * figure.stance * gait.narrowing, 0.0, gait.ahead * leg]
        spot = centre + rotate(turn("y", yaw), reachable)
        plants.append(
            Plant(
                start=start,
                end=start + contact,
                place=(float(spot[0]), float(spot[2])),
                yaw=yaw + SIDES[side] * gait.toe_out,
                strike=gait.strike,
                settle=gait.settle * contact,
                leave=gait.leave,
                peel=gait.peel * contact,
            )
        )
    return plants


def _height(
    figure: Figure,
    gait: Gait,
    cycle: float,
    long: Array,
    root: Array,
    pelvis: Array,
    plants: list[list[Plant]],
    soles: tuple[Sole, Sole],
) -> Array:
    """Height of the root joint [m], shape [T]: the gait's rhythm, as high as the standing legs reach."""
    rhythm = (
        _flight(gait, cycle, long) if gait.duty < 0.5 else gait.bounce * figure.leg_length * _vault(long, cycle, gait)
    )
    limit = ceiling(figure, soles, plants, long, root, pelvis)
    height: Array = rhythm + (limit - rhythm).min() - gait.crouch * figure.leg_length
    return height


def _vault(long: Array, cycle: float, gait: Gait) -> Array:
    """Walking: highest over the standing leg, lowest between the two, from -1 to 1."""
    return -np.cos(4 * np.pi * (long / cycle - (gait.duty - 0.5) / 2))


def _flight(gait: Gait, cycle: float, long: Array) -> Array:
    """Running: free fall in the air, a half-sine of force on the ground; height about its mean [m], shape [T]."""
    step, contact = cycle / 2, gait.duty * cycle
    t = np.linspace(0.0, step, 2001)
    push = np.where(t < contact, np.sin(np.pi * np.clip(t / contact, 0, 1)), 0.0)
    force = GRAVITY * push / push[:-1].mean()
    speed = np.cumsum(force - GRAVITY) * (t[1] - t[0])
    speed -= speed[:-1].mean()
    height = np.concatenate([[0.0], np.cumsum(speed[:-1]) * (t[1] - t[0])])
    return np.interp(np.mod(long, step), t, height - height.mean())


def _arm(gait: Gait, phase: Array, side: int) -> Arm:
    """One arm of a gait, against the leg of its side."""
    beat = -SIDES[side] * np.cos(phase - 0.15)
    mean, swing = gait.arm_swing
    follow = -SIDES[side] * np.cos(phase - 0.45)
    return Arm(
        out=np.full(len(phase), gait.arm_out),
        forward=mean + swing * beat,
        twist=gait.arm_twist * (1 + 0.3 * beat),
        elbow=gait.elbow[0] + gait.elbow[1] * follow,
        wrist=np.full(len(phase), 0.08) + 0.04 * follow,
    )
