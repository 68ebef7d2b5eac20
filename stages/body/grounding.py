"""Puts the feet of a recorded motion on the ground, found from the feet themselves, and holds them while they stand."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import binary_closing, binary_opening, gaussian_filter1d
from scipy.spatial.transform import Rotation

from stages.body.clips.footing import give_way
from stages.body.figure import ANKLES, BALLS, HIPS, KNEES, Figure
from stages.body.legs import STRAIGHTEST, reach, solve_leg
from stages.body.motion import FPS
from stages.body.retarget import joint_positions
from stages.body.sole import Sole, measure_sole
from stages.body.turns import rotate, turn

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SLOW = 0.55
"""A foot bears weight only where its heel or its ball moves slower than this [m/s]."""

NEAR = 0.05
"""... and is lower than this over the ground [m]."""

SHORTEST_CONTACT = 3
"""Contacts of fewer frames are noise."""

FLAT_PITCH = np.deg2rad(7.0)
"""A standing foot pitched less than this is meant to be flat [rad]."""

STEADY_HEADING = np.deg2rad(6.0)
"""A standing foot doesn't turn about the vertical until the recorded one is turned farther than this from it [rad]."""

LARGEST_BIAS = np.deg2rad(15.0)
"""Greatest constant pitch of the recorded feet that is taken out [rad]."""

TOE_LIMIT = np.deg2rad(55.0)
"""Greatest bend of the toes [rad]."""

TOE_CURL = np.deg2rad(10.0)
"""Greatest bend of the toes down [rad]."""

TOUCH = 3e-3
"""Skin lower than this over the lowest point of a standing foot touches the ground [m]."""

BLEND = 1.2
"""Standard deviation in time with which the correction of a foot's attitude comes and goes [frames]."""


@dataclass(frozen=True, eq=False)
class _Foot:
    """One foot through the motion, on its way to the ground."""

    sole: Sole
    ankle: Array
    angles: Array
    """Heading, pitch and roll [rad], shape [T, 3]."""

    def rotation(self) -> Array:
        """World rotation, shape [T, 3, 3]."""
        return np.asarray(Rotation.from_euler("YXZ", self.angles).as_matrix())


def ground(figure: Figure, world: Array, root: Array) -> tuple[Array, Array, Mask]:
    """Stands a motion on the ground.

    Args:
        figure: The person.
        world: World rotations of the joints, y up, shape [T, 24, 3, 3].
        root: Path of the root joint [m], shape [T, 3].

    Returns:
        World rotations and path of the root joint with the ground at height 0, and when the left and the right foot
        bear weight, shape [T, 2].
    """
    world, root = world.copy(), root.copy()
    joints = joint_positions(figure, world, root)
    feet = []
    for side in (0, 1):
        angles = np.unwrap(Rotation.from_matrix(world[:, ANKLES[side]]).as_euler("YXZ"), axis=0)
        feet.append(_Foot(measure_sole(figure, side), joints[:, ANKLES[side]], angles))
    level = _level(feet)
    root[:, 1] -= level
    planted = np.stack([_contacts(foot, level) for foot in feet], axis=-1)
    bias = _pitch_bias(feet, planted)
    targets = []
    for side in (0, 1):
        ankle = feet[side].ankle - [0.0, level, 0.0]
        bent = _toe_bend(world, side, planted[:, side])
        angles, toes = _settle(feet[side].angles, bent, planted[:, side], bias)
        foot = _Foot(feet[side].sole, ankle, angles)
        world[:, ANKLES[side]] = foot.rotation()
        world[:, BALLS[side]] = foot.rotation() @ turn("x", toes)
        targets.append(_hold(foot, toes, planted[:, side]))
    root[:, 1] += _rise(targets, feet, level)
    root[:, 1] = give_way(root[:, 1], _limit(figure, world, root, targets), 1 / FPS)
    for side in (0, 1):
        hip = root + rotate(world[:, 0], figure.joints[HIPS[side]] - figure.joints[0])
        leg = solve_leg(figure.leg(side), hip, targets[side], rotate(world[:, HIPS[side]], [0.0, 0.0, 1.0]))
        world[:, HIPS[side]], world[:, KNEES[side]] = leg.thigh, leg.shank
    return world, root, planted


def _points(foot: _Foot) -> Array:
    """Heel and ball of a foot [m], shape [T, 2, 3]."""
    low = foot.sole.points[:, 1].min()
    heel = np.array([0.0, low, foot.sole.points[:, 2].min() * 0.6])
    ball = np.array([foot.sole.ball[0], low, foot.sole.ball[2]])
    return foot.ankle[:, None] + np.einsum("tij,pj->tpi", foot.rotation(), np.stack([heel, ball]))


def _speeds(points: Array) -> Array:
    """Speeds of points [T, P, 3] in time [m/s], shape [T, P]."""
    if len(points) < 2:
        return np.zeros(points.shape[:2])
    return np.asarray(np.linalg.norm(np.gradient(points, 1 / FPS, axis=0), axis=-1))


def _level(feet: list[_Foot]) -> float:
    """Height of the ground [m]: where the feet are when they hardly move."""
    heights, slow = [], []
    for foot in feet:
        points = _points(foot)
        heights.append(points[..., 1].ravel())
        slow.append((_speeds(points) < SLOW).ravel())
    height, still = np.concatenate(heights), np.concatenate(slow)
    if still.sum() < SHORTEST_CONTACT:
        return float(np.percentile(height, 5))
    low = height[still]
    # Still feet may also rest on something or hang in the air for a moment: the lower half decides.
    return float(np.median(low[low <= np.median(low)]))


def _contacts(foot: _Foot, level: float) -> Mask:
    """Frames in which a foot bears weight, shape [T]."""
    points = _points(foot)
    near = points[..., 1] - level < NEAR
    touching = (near & (_speeds(points) < SLOW)).any(axis=1)
    padded = np.pad(touching, SHORTEST_CONTACT, mode="edge")
    padded = binary_opening(binary_closing(padded, np.ones(SHORTEST_CONTACT)), np.ones(SHORTEST_CONTACT))
    return np.asarray(padded[SHORTEST_CONTACT:-SHORTEST_CONTACT], dtype=bool)


def _pitch_bias(feet: list[_Foot], planted: Mask) -> float:
    """Pitch of the recorded feet when they stand flat [rad]: both skeletons then mean the same, level soles."""
    standing = np.concatenate([foot.angles[planted[:, side], 1] for side, foot in enumerate(feet)])
    level = standing[np.abs(standing) < LARGEST_BIAS]
    return float(np.median(level)) if len(level) >= SHORTEST_CONTACT else 0.0


def _toe_bend(world: Array, side: int, planted: Mask) -> Array:
    """Rotation of a toe joint as recorded, less what it is when the foot stands flat [rad], shape [T]."""
    local = np.swapaxes(world[:, ANKLES[side]], -1, -2) @ world[:, BALLS[side]]
    bend = np.arctan2(local[:, 2, 1], local[:, 1, 1])
    rest = float(np.median(bend[planted])) if planted.any() else 0.0
    return np.asarray(np.clip(bend - rest, -TOE_LIMIT, TOE_CURL))


def _settle(angles: Array, bent: Array, planted: Mask, bias: float) -> tuple[Array, Array]:
    """Levels and steadies the foot while it stands: no roll, no small pitch, no small turns; toes stay flat.

    Args:
        angles: Heading, pitch and roll [rad], shape [T, 3].
        bent: Rotation of the toe joint as recorded [rad], shape [T].
        planted: Frames in which the foot bears weight, shape [T].
        bias: Constant pitch to take out [rad].

    Returns:
        The angles, shape [T, 3], and the rotation of the toe joint [rad], shape [T].
    """
    weight = gaussian_filter1d(planted.astype(np.float64), BLEND, mode="nearest")
    pitch = angles[:, 1] - bias
    level = np.sign(pitch) * np.clip(np.abs(pitch) - FLAT_PITCH, 0.0, None)
    out = angles.copy()
    out[:, 0] += _steadied(angles[:, 0], planted)
    out[:, 1] = pitch + weight * (level - pitch)
    out[:, 2] *= 1 - weight
    return out, (1 - weight) * bent - weight * np.clip(out[:, 1], 0.0, TOE_LIMIT)


def _steadied(heading: Array, planted: Mask) -> Array:
    """What to add to a foot's heading so that it stands still through each contact [rad], shape [T].

    Recorded feet turn a little all the time; about a held point the rest of the sole then slides. Who does turn on the
    spot drags the foot along, `STEADY_HEADING` behind.
    """
    change = np.zeros_like(heading)
    for start, stop in _runs(planted):
        recorded = heading[start:stop]
        held = (recorded.min() + recorded.max()) / 2
        for t, now in enumerate(recorded, start=start):
            held = np.clip(held, now - STEADY_HEADING, now + STEADY_HEADING)
            change[t] = held - now
    return _between(change, planted)


def _between(change: Array, planted: Mask) -> Array:
    """A correction [T, ...] of planted frames that goes over from each contact to the next; 0 without contacts."""
    known = np.flatnonzero(planted)
    if not len(known):
        return np.zeros_like(change)
    if len(known) == 1:
        return np.broadcast_to(change[known], change.shape)
    frames = np.clip(np.arange(len(planted)), known[0], known[-1])
    return np.asarray(PchipInterpolator(known, change[known])(frames))


def _hold(foot: _Foot, toes: Array, planted: Mask) -> Array:
    """Ankle path of a foot that doesn't slide while planted and never sinks [m], shape [T, 3].

    From frame to frame the skin that touches the ground in both stays where it is. The path that this gives is laid
    through the recorded one by its mean; between two contacts the correction goes over from the one to the other.
    """
    rotation = foot.rotation()
    points = _bent(foot.sole, toes)
    turned = np.einsum("tij,tpj->tpi", rotation, points)
    lowest = turned[..., 1].min(axis=1)
    correction = np.zeros_like(foot.ankle)
    for start, stop in _runs(planted):
        path = np.zeros((stop - start, 3))
        for t in range(start + 1, stop):
            height = (turned[t - 1 : t + 1, :, 1] - lowest[t - 1 : t + 1, None]).max(axis=0)
            touching = height < max(TOUCH, height.min() + 1e-9)
            path[t - start] = path[t - start - 1] - np.median(turned[t, touching] - turned[t - 1, touching], axis=0)
        path += (foot.ankle[start:stop] - path).mean(axis=0)
        path[:, 1] = -lowest[start:stop]
        correction[start:stop] = path - foot.ankle[start:stop]
    wanted = foot.ankle + _between(correction, planted)
    sunk = np.clip(-(wanted[:, 1] + lowest), 0.0, None)
    wanted[:, 1] += np.maximum(sunk, np.where(planted, 0.0, gaussian_filter1d(sunk, BLEND, mode="nearest")))
    return wanted


def _bent(sole: Sole, toes: Array) -> Array:
    """Points of the sole relative to the ankle with bent toes [m], shape [T, S, 3]."""
    bent = rotate(turn("x", toes)[:, None], sole.points - sole.ball) + sole.ball
    w = sole.toe_weights[:, None]
    return np.asarray(w * bent + (1 - w) * sole.points)


def _runs(mask: Mask) -> list[tuple[int, int]]:
    """First and one past the last frame of each run of a mask."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _rise(targets: list[Array], feet: list[_Foot], level: float) -> Array:
    """Slow change of the root's height that goes with the feet's correction [m], shape [T]."""
    lift = np.mean([t[:, 1] - (f.ankle[:, 1] - level) for t, f in zip(targets, feet, strict=True)], axis=0)
    return np.asarray(gaussian_filter1d(lift, FPS / 4, mode="nearest"))


def _limit(figure: Figure, world: Array, root: Array, targets: list[Array]) -> Array:
    """Greatest height of the root joint at which both legs reach their ankles [m], shape [T]."""
    limits = []
    for side in (0, 1):
        hip = rotate(world[:, 0], figure.joints[HIPS[side]] - figure.joints[0])
        away = targets[side] - root - hip
        flat = np.hypot(away[:, 0], away[:, 2])
        longest = reach(figure.leg(side), STRAIGHTEST)
        limits.append(targets[side][:, 1] - hip[:, 1] + np.sqrt(np.clip(longest**2 - flat**2, 0.0, None)))
    return np.asarray(np.minimum(*limits))
