"""Conditions: what a person and a pose say, whichever way the person faces."""

import numpy as np
from scipy.spatial.transform import Rotation

from model.body import REST_POSE, load_free_body
from stages.train.records import facing_front, headings, person_conditions, pose_conditions


def turned(pose: np.ndarray, angle: float) -> np.ndarray:
    """The pose with the person turned about z."""
    root = Rotation.from_rotvec([0, 0, angle]) * Rotation.from_rotvec(pose[0])
    return np.concatenate([root.as_rotvec()[None], pose[1:]])


def test_a_person_at_rest_faces_front() -> None:
    assert np.allclose(headings(REST_POSE[None])[0], np.eye(3), atol=1e-6)


def test_heading_is_taken_out_and_lean_is_kept() -> None:
    pose = np.array(REST_POSE)
    pose[0] = (Rotation.from_rotvec([0.4, 0, 0]) * Rotation.from_rotvec(pose[0])).as_rotvec()
    many = np.stack([turned(pose, angle) for angle in (-2.5, 0.0, 1.0, 3.0)])
    assert np.allclose(facing_front(many), pose, atol=1e-6)
    assert not np.allclose(many[0, 0], pose[0], atol=0.1)


def test_turning_the_posed_body_back_equals_posing_it_without_heading() -> None:
    body = load_free_body("female")
    pose = turned(np.array(REST_POSE), 1.2)[None]
    expected = body.pose(np.zeros(10), facing_front(pose))
    assert np.allclose(body.pose(np.zeros(10), pose) @ headings(pose), expected, atol=1e-5)


def test_earlier_poses_follow_and_the_first_stands_in_before_the_start() -> None:
    pose = np.tile(REST_POSE, (20, 1, 1))
    pose[:, 5, 0] = np.arange(20) / 20
    theta = pose_conditions(pose, np.array([4, 19]), 4, 3).reshape(2, 4, 24, 3)
    assert np.allclose(theta[:, :, 5, 0] * 20, [[4, 1, 0, 0], [19, 16, 13, 10]], atol=1e-5)


def test_sizes_are_those_of_the_paper() -> None:
    static = person_conditions(np.zeros(10), "male", np.zeros(2))
    assert len(static) == 13
    theta = pose_conditions(np.tile(REST_POSE, (9, 1, 1)), np.array([8]), 4, 3)
    assert len(static) + theta.shape[1] + 128 == 429
