"""How true a motion on a body is to its recording: where the limbs point, and whether standing feet stay."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from model.body import PARENTS
from model.body.skinning import joint_positions
from stages.body.figure import ANKLES, BALLS, Figure
from stages.body.joint_map import BONES, match
from stages.body.motion import Motion
from stages.body.recording import Recording
from stages.body.retarget import axes_of
from stages.body.turns import WORLD_FROM_MODEL, rotate, unit

Array = NDArray[np.float64]

PAIRS = (*BONES.items(), (0, 12))
"""Bones that are compared: upper and lower limbs, and the trunk from the pelvis to the neck."""

TOUCH = 3e-3
"""Skin lower than this over the ground touches it [m]."""


@dataclass(frozen=True, kw_only=True)
class Fidelity:
    """Figures of one motion on one body."""

    direction: float
    """Mean angle between a bone of the body and the recorded one [degrees]."""
    direction_95: float
    """95 % of these angles are smaller [degrees]."""
    worst_bone: float
    """Mean angle of the bone with the largest one [degrees]."""
    slide: float
    """Mean path of the skin that touches the ground while the foot bears weight [mm/frame]."""
    slide_95: float
    """95 % of these paths are shorter [mm/frame]."""
    planted: float
    """Share of the frames in which a foot bears weight [1]."""
    sunk: float
    """Deepest that a sole is under the ground [mm]."""


def compare(figure: Figure, motion: Motion, recording: Recording, name: str) -> Fidelity:
    """Compares a whole motion with what it was made from.

    Args:
        figure: The person.
        motion: The motion on the person.
        recording: The recording that it was made from, at 30 fps.
        name: Name of the motion, for errors.

    Returns:
        The figures.
    """
    ours = joint_positions(figure.joints, PARENTS, motion.pose) @ WORLD_FROM_MODEL
    source = match(recording.names)
    theirs = recording.forward()[1] @ axes_of(recording, name).T
    angles = _angles(_bones(ours, {j: j for j in range(24)}), _bones(theirs, source))
    slides, deepest = [], 0.0
    for side in (0, 1):
        soles = sole_points(figure, motion, side)
        deepest = min(deepest, float(soles[..., 2].min()))
        slides.append(_slides(soles, motion.planted[:, side]))
    slide = np.concatenate(slides)
    return Fidelity(
        direction=float(angles.mean()),
        direction_95=float(np.percentile(angles, 95)),
        worst_bone=float(angles.mean(axis=0).max()),
        slide=1e3 * float(slide.mean()) if len(slide) else 0.0,
        slide_95=1e3 * float(np.percentile(slide, 95)) if len(slide) else 0.0,
        planted=float(motion.planted.any(axis=1).mean()),
        sunk=-1e3 * deepest,
    )


def sole_points(figure: Figure, motion: Motion, side: int) -> Array:
    """Points of one sole in the world [m], shape [T, S, 3]."""
    local = Rotation.from_rotvec(motion.pose.reshape(-1, 3)).as_matrix().reshape(-1, 24, 3, 3)
    chain, joint = [BALLS[side]], BALLS[side]
    while (joint := int(PARENTS[joint])) >= 0:
        chain.append(joint)
    turned = {-1: np.broadcast_to(np.eye(3), (len(motion), 3, 3))}
    for joint in reversed(chain):
        turned[joint] = turned[int(PARENTS[joint])] @ local[:, joint]
    at = joint_positions(figure.joints, PARENTS, motion.pose)
    ankle = motion.trans + (at[:, ANKLES[side]] - at[:, 0])
    points, ball, w = figure.soles[side], figure.ball(side), figure.toe_weights[side][:, None]
    foot = rotate(turned[ANKLES[side]][:, None], points)
    toe = rotate(turned[BALLS[side]][:, None], points - ball) + rotate(turned[ANKLES[side]], ball)[:, None]
    return np.asarray(ankle[:, None] + w * toe + (1 - w) * foot)


def _bones(positions: Array, at: dict[int, int]) -> Array:
    """Directions of the compared bones, shape [T, 9, 3]."""
    return np.stack([unit(positions[:, at[b]] - positions[:, at[a]]) for a, b in PAIRS], axis=1)


def _angles(ours: Array, theirs: Array) -> Array:
    """Angles between unit vectors [degrees]."""
    return np.asarray(np.degrees(np.arccos(np.clip((ours * theirs).sum(-1), -1.0, 1.0))))


def _slides(soles: Array, planted: NDArray[np.bool_]) -> Array:
    """Path of the touching skin, its median, in each frame in which the foot bears weight as in the one before [m]."""
    contact = (soles[1:, :, 2] < TOUCH) & (soles[:-1, :, 2] < TOUCH)
    paths = np.linalg.norm(np.diff(soles[..., :2], axis=0), axis=-1)
    frames = np.flatnonzero(planted[1:] & planted[:-1] & contact.any(axis=1))
    return np.array([np.median(paths[t][contact[t]]) for t in frames])
