"""Roots that were turned by the right angles in the wrong order are mended; sound ones are left alone."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model.body import JOINT_NAMES, PARENTS, BodyModel
from stages.body.clips import CLIPS, perform
from stages.body.figure import Figure
from stages.body.readers import read_motion
from stages.body.recording import Recording
from stages.body.repair import drop_fake_start, mend_flips
from stages.body.root_order import mend_root_order
from stages.body.turns import WORLD_FROM_MODEL

Person = tuple[BodyModel, np.ndarray, Figure]


def as_recording(figure: Figure, clip: str, heading: float = 0.0) -> Recording:
    """An embedded clip as a recording, y up, turned to a heading [rad]."""
    motion = perform(figure, clip)
    turn = Rotation.from_euler("y", heading).as_matrix() @ WORLD_FROM_MODEL.T
    rotations = Rotation.from_rotvec(motion.pose.reshape(-1, 3)).as_matrix().reshape(-1, 24, 3, 3)
    rotations[:, 0] = turn @ rotations[:, 0]
    offsets = np.zeros((24, 3))
    offsets[1:] = figure.joints[1:] - figure.joints[PARENTS[1:]]
    translations = np.broadcast_to(offsets, (len(motion), 24, 3)).copy()
    translations[:, 0] = motion.trans @ turn.T
    return Recording(
        names=JOINT_NAMES,
        parents=np.array(PARENTS, dtype=np.int64),
        offsets=offsets,
        tips={},
        rotations=rotations,
        translations=translations,
        frame_time=1 / 30,
    )


def steady_angles(rotations: np.ndarray) -> np.ndarray:
    """Angles of Rz Ry Rx [rad], shape [F, 3], without jumps, as motion capture has them."""
    out = [Rotation.from_matrix(rotations[0]).as_euler("xyz")]
    for matrix in rotations[1:]:
        x, y, z = Rotation.from_matrix(matrix).as_euler("xyz")
        ways = np.array([[x, y, z], [x + np.pi, np.pi - y, z + np.pi]])
        steps = (ways - out[-1] + np.pi) % (2 * np.pi) - np.pi
        out.append(out[-1] + steps[np.abs(steps).sum(axis=1).argmin()])
    return np.array(out)


@pytest.mark.parametrize("heading", [0.0, 2.5])
@pytest.mark.parametrize("clip", CLIPS)
def test_a_sound_recording_is_left_alone(clip: str, heading: float, woman: Person) -> None:
    recording = as_recording(woman[2], clip, heading)
    mended, did = mend_root_order(recording, clip)
    assert not did and mended is recording


@pytest.mark.parametrize("heading", [0.8, 2.5])
@pytest.mark.parametrize("clip", ["turn", "dance"])
def test_the_angles_are_put_in_order(clip: str, heading: float, woman: Person) -> None:
    recording = as_recording(woman[2], clip, heading)
    angles = steady_angles(recording.rotations[:, 0])
    rotations = recording.rotations.copy()
    rotations[:, 0] = Rotation.from_euler("yxz", angles[:, [1, 0, 2]]).as_matrix()
    faulty = replace(recording, rotations=rotations)
    mended, did = mend_root_order(faulty, clip)
    assert did
    np.testing.assert_allclose(mended.rotations, recording.rotations, atol=1e-6)


def test_real_captures_stand_again(captures: Path) -> None:
    """Who directed traffic whirled and tipped over; mended, the lower foot stays on the ground and nothing flips."""
    for name in ("directing_traffic_1", "walking_22", "walking_24"):
        recording = drop_fake_start(read_motion(captures / f"{name}.bvh"))
        mended, did = mend_root_order(recording, name)
        feet = [recording.names.index(joint) for joint in ("LeftToeBase", "RightToeBase")]
        low = [r.forward()[1][:, feet, 1].min(axis=1).std() * 0.0564 for r in (recording, mended)]
        assert did and mend_flips(recording)[1] > 0 and mend_flips(mended)[1] == 0
        assert low[1] < 0.012 < 0.03 < low[0]
