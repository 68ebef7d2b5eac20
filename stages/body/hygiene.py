"""First self-collision hygiene: opens arms and legs, just enough and smoothly in time, so that cloth fits in between.

Body collisions make the repelling forces on cloth inconsistent (CLOTH3D, "Self-collision"). Arms that touch the trunk
are turned about the shoulder; legs that touch are set farther apart, with the feet still planted. What can't be freed
is reported with its depth, for the caller to reject.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d, maximum_filter1d
from scipy.spatial.transform import Rotation

from stages.body.figure import ANKLES, HIPS, KNEES, Figure
from stages.body.legs import solve_leg
from stages.body.motion import Motion
from stages.body.overlap import FAR, Approach, Nearness, Posed
from stages.body.parts import Parts
from stages.body.turns import rotate, unit

Array = NDArray[np.float64]

ROUNDS = 6
"""Most rounds of measuring and opening."""

PROGRESS = 0.95
"""A round that leaves more than this of what was missing is the last: what remains is not for opening to solve."""

ENOUGH = 1e-4
"""Limbs that lack less than this are free: the last tenth of a millimetre would take as many rounds as all else [m]."""

GLIDE = 3.0
"""Standard deviation in time of an opening's coming and going [frames]."""

SHORTEST_LEVER = 0.10
"""An arm is not turned about its shoulder for contacts nearer to it than this [m]."""

SHOULDERS = (16, 17)


@dataclass(frozen=True, kw_only=True, eq=False)
class Opening:
    """What was found and what was done."""

    arm_distance_before: Array
    """Smallest signed distance of an arm to the trunk, negative inside [m], shape [T]."""
    arm_distance: Array
    """The same after opening [m], shape [T]."""
    leg_distance_before: Array
    """Smallest signed distance between the legs [m], shape [T]."""
    leg_distance: Array
    """The same after opening [m], shape [T]."""
    arm_turn: Array
    """Angle by which the left and the right arm were turned [rad], shape [T, 2]."""
    foot_shift: Array
    """Distance by which the left and the right foot were moved [m], shape [T, 2]."""


def open_limbs(
    figure: Figure,
    parts: Parts,
    motion: Motion,
    gaps: tuple[float, float],
    tell: Callable[[str], object] = lambda label: None,
    most: tuple[float, float] = (np.inf, np.inf),
) -> tuple[Motion, Opening]:
    """Opens arms and legs where they touch.

    Args:
        figure: The person.
        parts: The person's parts.
        motion: The motion.
        gaps: Free space wanted between an arm and the trunk, and between the legs [m].
        tell: Told after every round what is being done.
        most: An arm that was turned farther [rad], or a foot that was moved farther [m], is opened no more; after such
            a foot, arms aren't looked at.

    Returns:
        The motion with free limbs, and what was done.
    """
    pose, leg_before, leg_after, shift = _open_legs(figure, parts, motion, gaps[1], most[1], tell)
    arm_before = arm_after = np.full(len(motion), FAR)
    turned = np.zeros((len(motion), 2))
    if shift.max() <= most[1]:
        pose, arm_before, arm_after, turned = _open_arms(parts, pose, gaps[0], most[0], tell)
    opening = Opening(
        arm_distance_before=arm_before,
        arm_distance=arm_after,
        leg_distance_before=leg_before,
        leg_distance=leg_after,
        arm_turn=turned,
        foot_shift=shift,
    )
    return Motion(pose=pose, trans=motion.trans, planted=motion.planted), opening


def _open_arms(
    parts: Parts, pose: Array, gap: float, most: float, tell: Callable[[str], object]
) -> tuple[Array, Array, Array, Array]:
    """Pose with free arms, smallest distances before and after [m], shape [T], and angles turned [rad], [T, 2]."""
    frames = len(pose)
    pose = pose.copy()
    turns = np.zeros((frames, 2, 3))
    before = np.empty(frames)
    distance = np.full((frames, 2), FAR)
    short = np.inf
    stale = np.ones((frames, 2), dtype=bool)
    trunk = Posed.of(parts.trunk, parts.transforms(pose))
    approaches = [Approach(frames, arm, parts.trunk, gap) for arm in parts.arms]
    original = Rotation.from_rotvec(pose[:, SHOULDERS].reshape(-1, 3))
    for attempt in range(ROUNDS + 1):
        for side in (0, 1):
            need = _arm_need(parts, side, pose, trunk, approaches[side], gap, distance[:, side], stale[:, side])
            if attempt < ROUNDS:
                more = _envelope(need)
                turns[:, side] += more
                stale[:, side] = more.any(axis=1)
        if attempt == 0:
            before = distance.min(axis=1)
        tell("arms")
        last, short = short, _lacking(distance, gap)
        far = np.linalg.norm(turns, axis=-1).max() > most
        if not short or attempt == ROUNDS or short > PROGRESS * last or far:
            break
        opened = Rotation.from_rotvec(turns.reshape(-1, 3)) * original
        pose[:, SHOULDERS] = opened.as_rotvec().reshape(frames, 2, 3)
    return pose, before, distance.min(axis=1), np.linalg.norm(turns, axis=-1)


def _arm_need(
    parts: Parts,
    side: int,
    pose: Array,
    trunk: Posed,
    approach: Approach,
    gap: float,
    distance: Array,
    stale: NDArray[np.bool_],
) -> Array:
    """The turn that frees one arm, in the collar's axes, shape [T, 3]; fills in `distance` to the trunk [m], shape [T].

    Only frames that are `stale` [T] are looked at: the others have been, and are free.
    """
    need = np.zeros((len(pose), 3))
    frames = np.flatnonzero(stale)
    if not len(parts.arms[side].points) or not len(frames):
        return need
    transforms = parts.transforms(pose[frames])
    arm = Posed.of(parts.arms[side], transforms)
    shoulder = SHOULDERS[side]
    collar = int(parts.parents[shoulder])
    pivots = rotate(transforms[:, collar, :, :3], parts.joints[shoulder]) + transforms[:, collar, :, 3]
    for k, near, _ in approach.look(frames, arm, trunk.only(frames)):
        t = frames[k]
        distance[t] = near.least()
        if distance[t] >= gap - ENOUGH:
            continue
        short = gap - near.distance
        lever = np.cross(near.points - pivots[k], near.normals)
        length = np.linalg.norm(lever, axis=1)
        angle = np.where(short > 0, short / np.maximum(length, SHORTEST_LEVER), 0.0)
        worst = int(angle.argmax())
        if angle[worst] > 0:
            axis = lever[worst] / max(float(length[worst]), 1e-9)
            need[t] = transforms[k, collar, :, :3].T @ axis * angle[worst]
    return need


def _open_legs(
    figure: Figure, parts: Parts, motion: Motion, gap: float, most: float, tell: Callable[[str], object]
) -> tuple[Array, Array, Array, Array]:
    """Pose with free legs, smallest distances before and after [m], shape [T], and shifts of the feet [m], [T, 2]."""
    frames = len(motion)
    pose = motion.pose
    shift = np.zeros((frames, 2, 3))
    before = np.empty(frames)
    distance = np.empty((frames, 2))
    short = np.inf
    stale = np.ones(frames, dtype=bool)
    approach = Approach(frames, *parts.legs, gap)
    for attempt in range(ROUNDS + 1):
        looked = np.flatnonzero(stale)
        transforms = parts.transforms(pose[looked])
        legs = [Posed.of(leg, transforms) for leg in parts.legs]
        looks = list(approach.look(looked, *legs))
        rows = [k for k, *_ in looks]
        before_round = shift.copy()
        for side in (0, 1):
            need = np.zeros((frames, 3))
            near = [pair[side] for _, *pair in looks]
            distance[looked[rows], side], need[looked[rows]] = _leg_need(parts, side, transforms[rows], near, gap)
            if attempt < ROUNDS:
                shift[:, side] += _held(need, motion.planted[:, side])
        stale = (shift != before_round).any(axis=(1, 2))
        if attempt == 0:
            before = distance.min(axis=1)
        tell("legs")
        last, short = short, _lacking(distance, gap)
        far = np.linalg.norm(shift, axis=-1).max() > most
        if not short or attempt == ROUNDS or short > PROGRESS * last or far:
            break
        pose = _moved_feet(figure, parts, motion.pose, shift)
    return pose, before, distance.min(axis=1), np.linalg.norm(shift, axis=-1)


def _leg_need(parts: Parts, side: int, transforms: Array, looks: list[Nearness], gap: float) -> tuple[Array, Array]:
    """Smallest distance of one leg to the other [m], shape [T], and the level shift of its ankle that frees it [m]."""
    hip, ankle = HIPS[side], ANKLES[side]
    at = [rotate(transforms[:, j, :, :3], parts.joints[j]) + transforms[:, j, :, 3] for j in (hip, ankle)]
    distance, need = np.array([near.least() for near in looks]), np.zeros((len(looks), 3))
    for t in map(int, np.flatnonzero(distance < gap - ENOUGH)):
        near = looks[t]
        worst = int(near.distance.argmin())
        along = at[1][t] - at[0][t]
        share = float((near.points[worst] - at[0][t]) @ along / (along @ along))
        level = near.normals[worst] * [1.0, 1.0, 0.0]
        if np.linalg.norm(level) < 0.2:
            continue
        # Both legs give way, each by half; the ankle moves farther than a point nearer to the hip.
        need[t] = unit(level) * (gap - distance[t]) / 2 / np.clip(share, 0.25, 1.0)
    return distance, need


def _moved_feet(figure: Figure, parts: Parts, pose: Array, shift: Array) -> Array:
    """The pose with the ankles moved by `shift` (world axes, [T, 2, 3]) and the feet turned as before."""
    transforms = parts.transforms(pose)
    world = transforms[..., :3]
    local = Rotation.from_rotvec(pose.reshape(-1, 3)).as_matrix().reshape(*pose.shape, 3)
    for side in (0, 1):
        hip, ankle = (rotate(world[:, j], parts.joints[j]) + transforms[:, j, :, 3] for j in (HIPS[side], ANKLES[side]))
        forward = rotate(world[:, HIPS[side]], [0.0, 0.0, 1.0])
        leg = solve_leg(figure.leg(side), hip, ankle + shift[:, side], forward)
        pelvis = np.swapaxes(world[:, 0], -1, -2)
        local[:, HIPS[side]] = pelvis @ leg.thigh
        local[:, KNEES[side]] = np.swapaxes(leg.thigh, -1, -2) @ leg.shank
        local[:, ANKLES[side]] = np.swapaxes(leg.shank, -1, -2) @ world[:, ANKLES[side]]
    return Rotation.from_matrix(local.reshape(-1, 3, 3)).as_rotvec().reshape(pose.shape)


def _lacking(distance: Array, gap: float) -> float:
    """What is missing to `gap` where it is more than `ENOUGH`, over all distances together [m]."""
    missing = gap - distance
    return float(missing[missing > ENOUGH].sum())


def _envelope(need: Array) -> Array:
    """A smooth curve that is nowhere less than what is needed, axis by axis and sign by sign, shape [T, 3]."""
    reach = int(np.ceil(2.5 * GLIDE))
    out = np.zeros_like(need)
    for sign in (1.0, -1.0):
        wide = maximum_filter1d(np.clip(sign * need, 0.0, None), size=2 * reach + 1, axis=0, mode="nearest")
        out += sign * gaussian_filter1d(wide, GLIDE, axis=0, mode="nearest", truncate=2.5)
    return out


def _held(need: Array, planted: NDArray[np.bool_]) -> Array:
    """Shifts of a foot [m], shape [T, 3]: the largest need of each contact throughout it, gliding in between."""
    smooth = _envelope(need)
    if not planted.any():
        return smooth
    edges = np.flatnonzero(np.diff(np.concatenate([[0], planted.astype(np.int8), [0]])))
    out = smooth.copy()
    for start, stop in edges.reshape(-1, 2):
        stretch = smooth[start:stop]
        out[start:stop] = stretch[np.linalg.norm(stretch, axis=1).argmax()]
    known = np.flatnonzero(planted)
    if len(known) == 1:
        return np.broadcast_to(out[known], out.shape)
    between = PchipInterpolator(known, out[known])(np.clip(np.arange(len(out)), known[0], known[-1]))
    # In the air the foot follows its own need, as far as it is away from the ends of the swing.
    away = gaussian_filter1d((~planted).astype(np.float64), GLIDE / 2, mode="nearest") * ~planted
    extra = smooth - between
    return np.where(planted[:, None], out, between + away[:, None] * extra)
