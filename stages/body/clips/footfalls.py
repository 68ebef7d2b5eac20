"""Footfalls: where and when each foot stands, and the paths of the ankles that follow from it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from stages.body.figure import HIPS, Figure
from stages.body.legs import reach
from stages.body.sole import Sole, measure_sole
from stages.body.turns import rotate, turn

Array = NDArray[np.float64]

INSTANT = 1e-4
"""Step of the differences that give the speed of a foot as it lands and leaves [s]."""

CLEARING_TIME = 0.02
"""How gradually a swinging foot is lifted over the ground [s]."""

SOFT_REACH = np.deg2rad(18.0)
"""Bend of the knee below which a swinging leg straightens ever more slowly [rad]."""


@dataclass(frozen=True)
class Plant:
    """One foot bears weight on one place: it lands, rolls flat, stays, peels off."""

    start: float
    """Time of the first contact [s]."""
    end: float
    """Time of the last contact [s]."""
    place: tuple[float, float]
    """Ground position (x, z) below the ankle when flat [m]."""
    yaw: float = 0.0
    """Heading of the foot [rad], positive to the left."""
    strike: float = 0.0
    """Pitch at first contact [rad]: negative lands on the heel, positive on the ball."""
    settle: float = 0.0
    """Time from the first contact until flat [s]; 0 with a flat landing."""
    leave: float = 0.0
    """Pitch at the last contact [rad]."""
    peel: float = 0.0
    """Time of the heel's rise before the last contact [s]; 0 with a flat lift."""
    held: float = 0.0
    """Pitch in between [rad]: positive stands on the ball of the foot."""


@dataclass(frozen=True)
class Swing:
    """How a foot travels between two plants; u runs from 0 at lift to 1 at landing."""

    height: Sequence[tuple[float, float]] = ()
    """(u, height of the ankle above its height when flat [leg lengths])."""
    forward: Sequence[tuple[float, float]] = ()
    """(u, position of the ankle in front of the root joint [leg lengths])."""
    side: Sequence[tuple[float, float]] = ()
    """(u, position of the ankle outward from the root joint [leg lengths])."""
    pitch: Sequence[tuple[float, float]] = ()
    """(u, pitch of the foot [rad])."""
    toe: Sequence[tuple[float, float]] = field(default=((0.35, 0.0),))
    """(u, rotation of the toes [rad])."""


@dataclass(frozen=True, eq=False)
class FootTrack:
    """The path of one foot, sampled in time."""

    ankle: Array
    """Ankle position [m], y up, shape [T, 3]."""
    yaw: Array
    """Heading of the foot [rad], shape [T]."""
    pitch: Array
    """Pitch of the foot [rad], shape [T]."""
    toe: Array
    """Rotation of the toe joint [rad], shape [T]."""
    planted: NDArray[np.bool_]
    """Whether the foot bears weight, shape [T]."""

    @property
    def rotation(self) -> Array:
        """World rotation of the foot, shape [T, 3, 3]."""
        rotation: Array = turn("y", self.yaw) @ turn("x", self.pitch)
        return rotation


def stand(sole: Sole, plant: Plant, times: Array) -> tuple[Array, Array]:
    """A foot while it bears weight.

    Args:
        sole: The ground contact of the foot.
        plant: Where and how it stands.
        times: Times within the plant [s], shape [T].

    Returns:
        Ankle positions [m], shape [T, 3], and pitch [rad], shape [T].
    """
    landing = _remaining(times - plant.start, plant.settle)
    leaving = _remaining(plant.end - times, plant.peel)
    pitch = plant.held + (plant.strike - plant.held) * landing**2 + (plant.leave - plant.held) * leaving**2
    ankle = rotate(turn("y", np.full(len(times), plant.yaw)), sole.standing(pitch))
    ankle[:, [0, 2]] += plant.place
    return ankle, pitch


def _remaining(elapsed: Array, duration: float) -> Array:
    """1 at no elapsed time, down to 0 after `duration`."""
    if duration <= 0:
        return np.zeros_like(elapsed)
    return np.clip(1 - elapsed / duration, 0.0, None)


def track(
    figure: Figure,
    side: int,
    plants: Sequence[Plant],
    swings: Sequence[Swing],
    times: Array,
    root: Array,
    pelvis: Array,
    facing: Array,
) -> FootTrack:
    """The whole path of one foot: plants joined by swings, continuous in position and velocity.

    Args:
        figure: The person.
        side: 0 for the left foot, 1 for the right.
        plants: Plants in order of time; the first covers the first time and the last the last.
        swings: The swing after each plant but the last.
        times: Times [s], evenly spaced, shape [T].
        root: Path of the root joint [m], shape [T, 3].
        pelvis: World rotation of the pelvis, shape [T, 3, 3].
        facing: Heading of the pelvis [rad], shape [T].

    Returns:
        The track. A swing is interpolated relative to the root joint, by cubic splines that start and end with the
        velocity of the planted foot, and kept within reach of the hip.
    """
    sole, leg = measure_sole(figure, side), figure.leg_length
    hip = root + rotate(pelvis, figure.joints[HIPS[side]] - figure.joints[0])
    count = len(times)
    ankle, yaw, pitch, toe = np.zeros((count, 3)), np.zeros(count), np.zeros(count), np.zeros(count)
    planted = np.zeros(count, dtype=bool)
    path, heading = CubicSpline(times, root), CubicSpline(times, facing)
    outward = np.sign(sole.side)
    for plant in plants:
        now = (times >= plant.start) & (times <= plant.end)
        ankle[now], pitch[now] = stand(sole, plant, times[now])
        yaw[now], toe[now], planted[now] = plant.yaw, -np.maximum(pitch[now], 0.0), True
    for before, after, swing in zip(plants[:-1], plants[1:], swings, strict=True):
        now = (times > before.end) & (times < after.start)
        span = after.start - before.end
        u = (times[now] - before.end) / span
        ends = np.array([before.end - INSTANT, before.end, after.start, after.start + INSTANT])
        (a0, p0), (a1, p1) = stand(sole, before, ends[:2]), stand(sole, after, ends[2:])
        local = np.concatenate([a0, a1]) - path(ends)
        local = rotate(turn("y", -heading(ends)), local)
        pitches = np.concatenate([p0, p1])
        moments = before.end + span * np.array([k[0] for k in swing.height])
        drop = -sole.points[:, 1].min() - path(moments)[:, 1] if len(moments) else np.zeros(0)
        keys = (
            [(k[0], outward * k[1] * leg) for k in swing.side],
            [(k[0], k[1] * leg + d) for k, d in zip(swing.height, drop, strict=True)],
            [(k[0], k[1] * leg) for k in swing.forward],
        )
        path_local = np.stack([_through(local[:, i], keys[i], span, u) for i in range(3)], axis=-1)
        free = rotate(turn("y", heading(times[now])), path_local) + path(times[now])
        ankle[now] = _within_reach(free, hip[now], figure.leg(side))
        pitch[now] = _through(pitches, swing.pitch, span, u)
        toe[now] = _through(-np.maximum(pitches, 0.0), swing.toe, span, u)
        ankle[now, 1] += _clearing(-sole.lowest(pitch[now], toe[now]) - ankle[now, 1], times[1] - times[0])
        yaw[now] = before.yaw + (after.yaw - before.yaw) * u * u * (3 - 2 * u)
    return FootTrack(ankle=ankle, yaw=yaw, pitch=pitch, toe=toe, planted=planted)


def _within_reach(ankle: Array, hip: Array, leg: Array) -> Array:
    """Ankle positions of one swing [m], shape [T, 3], drawn in smoothly where the leg would not reach them."""
    away = ankle - hip
    distance = np.linalg.norm(away, axis=-1)
    if not len(distance):
        return ankle
    longest = reach(leg)
    soft = min(max(reach(leg, SOFT_REACH), distance[0], distance[-1]), longest - 1e-4)
    over, room = np.clip(distance - soft, 0.0, None), longest - soft
    drawn = np.minimum(distance, soft) + room * -np.expm1(-over / room)
    return hip + away * (drawn / distance)[:, None]


def _clearing(depth: Array, dt: float) -> Array:
    """Lift of a swinging foot [m], shape [T], that keeps it out of the ground; 0 at both ends.

    Args:
        depth: How deep the lowest point of the foot would be [m], shape [T].
        dt: Time between two samples [s].

    Returns:
        At least the positive part of `depth`, widened and smoothed, except where the swing has just begun or ends.
    """
    if not (depth > 0).any():
        return np.zeros_like(depth)
    sigma = CLEARING_TIME / dt
    wide = maximum_filter1d(np.clip(depth, 0.0, None), size=2 * int(np.ceil(2 * sigma)) + 1)
    smooth = gaussian_filter1d(wide, sigma, truncate=2.0)
    edge = np.arange(len(depth)) * dt
    fade = np.clip(np.minimum(edge, edge[::-1]) / CLEARING_TIME, 0.0, 1.0)
    return np.maximum(depth, smooth * fade * fade * (3 - 2 * fade)).clip(min=0.0)


def _through(ends: Array, keys: Sequence[tuple[float, float]], span: float, u: Array) -> Array:
    """Cubic spline through keys, with the values and speeds given by two samples at either end.

    Args:
        ends: Values `INSTANT` before lift, at lift, at landing, `INSTANT` after it, shape [4].
        keys: (u, value) in between.
        span: Duration of the swing [s].
        u: Where to evaluate, 0 to 1, shape [T].

    Returns:
        Values, shape [T].
    """
    speeds = (ends[1] - ends[0]) / INSTANT * span, (ends[3] - ends[2]) / INSTANT * span
    at = np.array([0.0, *(k[0] for k in keys), 1.0])
    values = np.array([ends[1], *(k[1] for k in keys), ends[2]])
    return np.asarray(CubicSpline(at, values, bc_type=((1, speeds[0]), (1, speeds[1])))(u), dtype=np.float64)
