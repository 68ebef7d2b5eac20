"""The embedded clips, judged on the skin of bodies of every size: feet, ground, joints, smoothness."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from model.body import PARENTS, BodyModel
from model.body.skinning import joint_positions
from stages.body.clips import CLIPS, perform
from stages.body.figure import ANKLES, BALLS, HIPS, KNEES, Figure
from stages.body.motion import FPS, Motion

Person = tuple[BodyModel, np.ndarray, Figure]


def feet_of(model: BodyModel, betas: np.ndarray, motion: Motion, side: int) -> np.ndarray:
    """Skin of one foot in the world [m], shape [T, N, 3]."""
    rows = np.flatnonzero(model.weights[:, [ANKLES[side], BALLS[side]]].sum(axis=1) > 0.9)
    pick = sp.csr_matrix((np.ones(len(rows)), (np.arange(len(rows)), rows)), shape=(len(rows), model.vertex_count))
    return model.resample(pick, np.zeros((0, 3), np.int32)).pose(betas, motion.pose, motion.trans)


@pytest.mark.parametrize("name", CLIPS)
def test_feet_stand_still_and_on_the_ground(name: str, someone: Person) -> None:
    model, betas, figure = someone
    motion = perform(figure, name)
    touched = 0
    for side in (0, 1):
        foot = feet_of(model, betas, motion, side)
        assert foot[..., 2].min() > -1e-3, "a foot sinks into the ground"
        both = motion.planted[1:, side] & motion.planted[:-1, side]
        lowest = foot[..., 2].min(axis=1)
        assert np.abs(lowest[motion.planted[:, side]]).max() < 3e-3, "a foot that bears weight hovers"
        contact = (foot[1:, :, 2] < 2e-3) & (foot[:-1, :, 2] < 2e-3)
        slide = np.linalg.norm(np.diff(foot[..., :2], axis=0), axis=-1)
        for frame in np.flatnonzero(both & contact.any(axis=1)):
            assert np.median(slide[frame][contact[frame]]) < 2e-3
            touched += 1
    assert touched > FPS


@pytest.mark.parametrize("name", CLIPS)
def test_joints_stay_within_human_limits(name: str, someone: Person) -> None:
    _, _, figure = someone
    motion = perform(figure, name)
    for side in (0, 1):
        leg = figure.leg(side)
        shank = Rotation.from_rotvec(motion.pose[:, KNEES[side]]).apply(leg[1])
        bend = np.degrees(np.arctan2(np.cross(leg[0], shank)[:, 0], shank @ leg[0]))
        assert bend.min() > 2, "a knee is hyperextended"
        assert bend.max() < 140
        ankle = np.degrees(motion.pose[:, ANKLES[side], 0])
        assert ankle.min() > -45 and ankle.max() < 75
        hip = np.degrees(motion.pose[:, HIPS[side], 0])
        assert hip.min() > -125 and hip.max() < 40
    elbows = np.degrees(motion.pose[:, [18, 19], 1]) * [-1, 1]
    assert elbows.min() > 0 and elbows.max() < 140
    assert np.abs(np.degrees(motion.pose[:, [20, 21]])).max() < 30


@pytest.mark.parametrize("name", CLIPS)
def test_motion_is_smooth(name: str, woman: Person) -> None:
    """Halving the time step halves the change of velocity: position and velocity have no jump."""
    _, _, figure = woman
    motion = perform(figure, name)
    assert len(motion) >= 10 * FPS
    joints = joint_positions(figure.joints, PARENTS, motion.pose) + (motion.trans - figure.joints[0])[:, None]
    speed = np.linalg.norm(np.diff(joints, axis=0), axis=-1) * FPS
    change = np.linalg.norm(np.diff(joints, 2, axis=0), axis=-1) * FPS**2
    assert speed.max() < 9.0, "no limb is that fast"
    # Torso and head: a few g in a landing; a pop of 2 cm in one frame would be 18 m/s^2 alone.
    assert change[:, [0, 3, 6, 9, 12, 15]].max() < 40
    assert np.linalg.norm(np.diff(motion.trans, 2, axis=0), axis=-1).max() * FPS**2 < 35
    turned = np.linalg.norm(
        [
            (Rotation.from_rotvec(motion.pose[:-1, j]).inv() * Rotation.from_rotvec(motion.pose[1:, j])).as_rotvec()
            for j in range(24)
        ],
        axis=-1,
    )
    assert np.degrees(turned.max()) < 40, "a joint pops"


@pytest.mark.parametrize("name", ["jump", "run"])
def test_bodies_in_the_air_fall_freely(name: str, someone: Person) -> None:
    _, _, figure = someone
    motion = perform(figure, name)
    air = ~motion.planted.any(axis=1)
    inside = air[:-2] & air[1:-1] & air[2:]
    assert inside.sum() >= 12
    fall = np.diff(motion.trans[:, 2], 2) * FPS**2
    np.testing.assert_allclose(fall[inside], -9.81, atol=0.02)


def test_clips_are_the_same_every_time(woman: Person) -> None:
    _, _, figure = woman
    for name in CLIPS:
        first, second = perform(figure, name), perform(figure, name)
        assert first.pose.tobytes() == second.pose.tobytes()
        assert first.trans.tobytes() == second.trans.tobytes()
