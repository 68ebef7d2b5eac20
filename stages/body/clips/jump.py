"""Three jumps: one up, one far forward, one with half a turn; each crouches, flies freely and is absorbed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.clips.choreography import ArmKeys, Choreography, standing_height
from stages.body.clips.footfalls import Plant, Swing
from stages.body.clips.gait import GRAVITY
from stages.body.clips.keys import ease, flow
from stages.body.figure import Figure
from stages.body.posture import Posture
from stages.body.turns import rotate, turn

SECONDS = 10.0
"""Length of the clip [s]."""

LEAVE = np.deg2rad(46)
"""Pitch of the feet as they leave the ground [rad]."""


@dataclass(frozen=True)
class Leap:
    """One jump."""

    start: float
    """When the crouch begins [s]."""
    crouch: float
    """Depth of the crouch before [leg lengths]."""
    height: float
    """Rise of the root joint in the air [leg lengths]."""
    distance: float
    """How far forward it goes [leg lengths]."""
    turning: float
    """Change of heading in the air [rad]."""
    strike: float
    """Pitch of the feet as they land [rad]: positive on the balls, negative on the heels."""
    reach: float
    """How far the feet land in front of the root joint [leg lengths]."""
    tiptoe: float
    """Height of the root joint at take-off over that of standing [leg lengths]."""
    lower: float
    """How much lower the root joint lands than it took off, with bent legs or legs in front [leg lengths]."""

    def off(self) -> float:
        """When the feet leave the ground [s]."""
        return self.start + 0.95

    def air(self, leg: float) -> float:
        """Time in the air [s]."""
        speed = np.sqrt(2 * GRAVITY * self.height * leg)
        return float((speed + np.sqrt(speed**2 + 2 * GRAVITY * self.lower * leg)) / GRAVITY)


LEAPS = (
    Leap(
        start=0.45,
        crouch=0.34,
        height=0.36,
        distance=0.0,
        turning=0.0,
        strike=0.55,
        reach=0.0,
        tiptoe=0.055,
        lower=0.045,
    ),
    Leap(
        start=3.55,
        crouch=0.36,
        height=0.26,
        distance=1.0,
        turning=0.0,
        strike=-0.14,
        reach=0.19,
        tiptoe=0.035,
        lower=0.14,
    ),
    Leap(
        start=6.75,
        crouch=0.34,
        height=0.33,
        distance=0.0,
        turning=np.pi / 2,
        strike=0.55,
        reach=0.0,
        tiptoe=0.055,
        lower=0.045,
    ),
)


def jump(figure: Figure, times: NDArray[np.float64]) -> tuple[Posture, tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """The posture of the jumps, and when each foot is on the ground; `times` [s], shape [T]."""
    leg, stand, wide = figure.leg_length, standing_height(figure), figure.stance * 1.12
    up = [(times[0], stand, 0.0, 0.0)]
    along: list[tuple[float, float, float, float]] = [(times[0], 0.0, 0.0, 0.0)]
    heading, bent, tilted = [(0.0, 0.0)], [(0.0, 0.0)], [(0.0, 4.0)]
    out, forward, elbow, nod = [(0.0, 14.0)], [(0.0, 0.0)], [(0.0, 16.0)], [(0.0, 4.0)]
    plants: tuple[list[Plant], list[Plant]] = ([], [])
    place, yaw, last, strike = np.zeros(3), 0.0, -1.0, 0.0
    for leap in LEAPS:
        off, air = leap.off(), leap.air(leg)
        land = off + air
        speed, fly = np.sqrt(2 * GRAVITY * leap.height * leg), leap.distance * leg / air
        top = stand + leap.tiptoe * leg
        deep, back = leap.start + 0.58, -0.10 * leg
        gone = float(place[2])
        up += [
            (leap.start, stand, 0.0, 0.0),
            (deep, stand - leap.crouch * leg, 0.0, 6.0),
            (off, top, speed, -GRAVITY),
            (land, top - leap.lower * leg, speed - GRAVITY * air, -GRAVITY),
            (land + 0.30, stand - 0.30 * leg, 0.0, 4.0),
            (land + 1.05, stand, 0.0, 0.0),
        ]
        ahead = 0.16 * leg * np.sign(leap.distance)
        end = gone + leap.distance * leg
        next_place = end + ahead + leap.reach * leg
        along += [
            (leap.start, gone, 0.0, 0.0),
            (deep, gone + back, 0.0, 1.0 * np.sign(leap.distance)),
            (off, gone + ahead, fly, 0.0),
            (land, end + ahead, fly, 0.0),
            (land + 0.30, next_place + back, 0.0, 0.0),
            (land + 1.05, next_place, 0.0, 0.0),
        ]
        heading += [(off - 0.12, yaw), (land + 0.06, yaw + leap.turning)]
        bent += [
            (leap.start, 0),
            (deep, 30),
            (off, -4),
            (off + air / 2, 4 + 90 * leap.reach),
            (land + 0.28, 27),
            (land + 1.1, 0),
        ]
        tilted += [
            (leap.start, 4),
            (deep, 38),
            (off, 4),
            (off + air / 2, 8 + 20 * leap.reach),
            (land + 0.28, 33),
            (land + 1.1, 4),
        ]
        out += [(leap.start, 14), (deep, 15), (off, 20), (land, 30), (land + 0.3, 24), (land + 1.2, 14)]
        forward += [
            (leap.start, 0),
            (deep - 0.03, -48),
            (off + 0.02, 128),
            (off + air / 2, 138),
            (land + 0.22, 34),
            (land + 0.6, -14),
            (land + 1.2, 0),
        ]
        elbow += [(leap.start, 16), (deep, 22), (off - 0.15, 46), (off, 28), (land + 0.1, 40), (land + 1.2, 16)]
        nod += [(leap.start, 4), (deep, -4), (off, -16), (land, 16), (land + 0.4, 6), (land + 1.1, 4)]
        _plant(plants, place, yaw, wide, (last, off), strike, LEAVE)
        place, yaw, last = np.array([0.0, 0.0, next_place]), yaw + leap.turning, land
        strike = leap.strike
    _plant(plants, place, yaw, wide, (last, float(times[-1]) + 1.0), strike, 0.0)
    up.append((float(times[-1]) + 1.0, stand, 0.0, 0.0))
    along.append((float(times[-1]) + 1.0, float(place[2]), 0.0, 0.0))
    root = np.stack([np.zeros_like(times), flow(times, up), flow(times, along)], axis=-1)
    facing = ease(times, heading)
    arms = ArmKeys(out=out, forward=forward, elbow=elbow)
    zero = np.zeros_like(times)
    tuck = Swing(pitch=((0.4, np.deg2rad(34)),), toe=((0.35, np.deg2rad(-4)),))
    return Choreography(
        times=times,
        plants=plants,
        swings=([tuck] * len(LEAPS), [tuck] * len(LEAPS)),
        root=root,
        yaw=facing,
        tilt=np.deg2rad(ease(times, tilted)),
        lean=zero,
        bend=np.deg2rad(ease(times, bent)),
        twist=zero,
        side=zero,
        look=facing,
        nod=np.deg2rad(ease(times, nod)),
        arms=(arms.at(times), arms.at(times)),
        knees_out=0.16,
    ).stage(figure)


def _plant(
    plants: tuple[list[Plant], list[Plant]],
    place: NDArray[np.float64],
    yaw: float,
    wide: float,
    contact: tuple[float, float],
    strike: float,
    leave: float,
) -> None:
    """Both feet side by side, from a landing to the next take-off."""
    for side, sign in ((0, 1.0), (1, -1.0)):
        spot = place + rotate(turn("y", yaw), np.array([sign * wide, 0.0, 0.0]))
        plants[side].append(
            Plant(
                start=contact[0],
                end=contact[1],
                place=(float(spot[0]), float(spot[2])),
                yaw=yaw + sign * 0.12,
                strike=strike,
                settle=0.13 if strike else 0.0,
                leave=leave,
                peel=0.20 if leave else 0.0,
            )
        )
