"""The way from the rest body that the outfit was made on to the first frame of the sequence.

CLOTH3D, supplement, "Body transition": frames in which the shape goes from betas + tightness to betas, then frames in
which every joint turns from the rest pose to the first pose through quaternions. They are simulated, not stored. Here
body, cloth and air go along at the sequence's first velocity from the start, which by Galilean invariance is being at
rest: nobody is pushed off, and the cloth enters the first frame as that of a person who has walked for a while.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

PoseBody = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""(betas (B,), pose (T, K, 3), trans (T, 3)) -> vertices [m] (T, V, 3): `BodyModel.pose`."""


@dataclass(frozen=True, kw_only=True)
class Transition:
    """Frames before the sequence.

    Attributes:
        vertices: Body vertices [m], shape [P, V, 3]; the sequence's first frame comes next.
        turn: Rotation about z (3, 3), and shift: translation (3,) [m], that put the rest frame where the transition
            starts, facing as the sequence does.
        velocity: Of the root [m/s], shape (3,), throughout: that of the sequence's first frame.
        shape_frames, settle_frames, pose_frames: Length of each part.
    """

    vertices: np.ndarray
    turn: np.ndarray
    shift: np.ndarray
    velocity: np.ndarray
    shape_frames: int
    settle_frames: int
    pose_frames: int


def ease(s: np.ndarray) -> np.ndarray:
    """3 s^2 - 2 s^3: from 0 to 1, starting and ending at rest; its steepest slope is 1.5."""
    return s * s * (3 - 2 * s)


def heading(first: np.ndarray, rest: np.ndarray) -> float:
    """Angle about z [rad] from the rest root rotation to the first one, both axis-angle (3,): the twist about z."""
    q = (Rotation.from_rotvec(first) * Rotation.from_rotvec(rest).inv()).as_quat()
    return float(2 * np.arctan2(q[2], q[3]))


def blend_poses(a: np.ndarray, b: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Slerp of every joint: poses a (K, 3) or (T, K, 3) to b (T, K, 3) at s (T,), axis-angle [rad], the short way."""
    a = np.array(np.broadcast_to(a, b.shape)).reshape(-1, 3)
    start = Rotation.from_rotvec(a)
    turn = (start.inv() * Rotation.from_rotvec(b.reshape(-1, 3))).as_rotvec()
    weight = np.repeat(s, b.shape[1])[:, None]
    return (start * Rotation.from_rotvec(weight * turn)).as_rotvec().reshape(b.shape)


def make_transition(
    body: PoseBody,
    rest_pose: np.ndarray,
    tight_betas: np.ndarray,
    betas: np.ndarray,
    pose: np.ndarray,
    trans: np.ndarray,
    parted: np.ndarray | None = None,
    *,
    fps: float,
    shape_speed: float,
    pose_speed: float,
    run_up: float,
    settle_frames: int,
) -> Transition:
    """Frames from `tight_betas` at `rest_pose` to the start of `pose` (T, K, 3), `trans` (T, 3).

    Each part is as long as it must be for no vertex to move faster than the speeds given [m/s] relative to the root.
    What the sequence's first frame was moved by to part skin from skin, `parted` (V, 3) [m], comes with its pose.
    """
    rest_pose, pose, trans = (np.array(a, np.float64) for a in (rest_pose, pose, trans))
    yaw = heading(pose[0, 0], rest_pose[0])
    turn = Rotation.from_rotvec([0.0, 0.0, yaw])
    start_pose = rest_pose.copy()
    start_pose[0] = (turn * Rotation.from_rotvec(rest_pose[0])).as_rotvec()

    def rest_body(b: np.ndarray) -> np.ndarray:
        return body(b, start_pose[None], np.zeros((1, 3)))[0]

    grow = np.linalg.norm(rest_body(betas) - rest_body(tight_betas), axis=1).max()
    shape_frames = max(4, int(np.ceil(1.5 * grow / shape_speed * fps)))
    sweep = np.linalg.norm(body(betas, pose[:1], np.zeros((1, 3)))[0] - rest_body(betas), axis=1).max()
    # A limb goes round an arc, up to pi/2 longer than its chord; 1.3 is that of an arm from the T-pose to the hip.
    pose_frames = max(8, int(np.ceil(1.3 * 1.5 * sweep / pose_speed * fps)))

    # Before its first frame the sequence turns at its first angular velocity, which fades in over run_up.
    second = min(1, len(pose) - 1)
    spin = (Rotation.from_rotvec(pose[0]).inv() * Rotation.from_rotvec(pose[second])).as_rotvec() * fps
    velocity = (trans[second] - trans[0]) * fps
    t = (np.arange(pose_frames) - pose_frames) / fps
    lag = run_up * (np.exp(t / run_up) - 1) if run_up > 0 else np.zeros(pose_frames)
    before = np.stack([(Rotation.from_rotvec(pose[0]) * Rotation.from_rotvec(u * spin)).as_rotvec() for u in lag])
    share = ease(np.arange(pose_frames) / pose_frames)
    poses = blend_poses(start_pose, before, share)
    frames = shape_frames + settle_frames + pose_frames
    places = trans[0] + ((np.arange(frames) - frames) / fps)[:, None] * velocity

    parts = [
        body(tight_betas + s * (betas - tight_betas), start_pose[None], place[None])
        for s, place in zip(ease(np.arange(shape_frames) / shape_frames), places)
    ]
    if settle_frames:
        still = np.repeat(start_pose[None], settle_frames, axis=0)
        parts.append(body(betas, still, places[shape_frames : shape_frames + settle_frames]))
    posed = body(betas, poses, places[-pose_frames:])
    if parted is not None:
        along = Rotation.from_rotvec(poses[:, 0]) * Rotation.from_rotvec(pose[0, 0]).inv()
        posed = posed + share[:, None, None] * (parted @ along.as_matrix().swapaxes(1, 2))
    parts.append(posed)
    return Transition(
        vertices=np.concatenate(parts).astype(np.float32),
        turn=turn.as_matrix(),
        shift=places[0],
        velocity=velocity,
        shape_frames=shape_frames,
        settle_frames=settle_frames,
        pose_frames=pose_frames,
    )
