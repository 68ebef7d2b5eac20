"""The way into the sequence: continuous, no faster than asked, ending with the sequence's own motion."""

import numpy as np

from model.body import REST_POSE, load_free_body
from stages.simulate.transition import Transition, blend_poses, make_transition

FPS = 30.0


def _walk_in(
    frames: int = 4, speed: float = 1.2, parted: np.ndarray | None = None
) -> tuple[Transition, np.ndarray, np.ndarray]:
    model = load_free_body("female")
    pose = np.repeat(np.array(REST_POSE, float)[None], frames, axis=0)
    pose[:, 16, 2], pose[:, 17, 2] = -1.1, 1.1  # arms down
    pose[:, 1, 0] = 0.3 + 0.05 * np.arange(frames)
    trans = np.array([2.0, -1.0, 0.9]) + np.arange(frames)[:, None] * np.array([0.0, -speed / FPS, 0.0])
    betas, tight = np.zeros(10), np.zeros(10)
    tight[:2] = 0.5
    way = make_transition(
        model.pose, REST_POSE, tight, betas, pose, trans, parted,
        fps=FPS, shape_speed=0.3, pose_speed=1.5, run_up=0.25, settle_frames=5,
    )  # fmt: skip
    return way, model.pose(betas, pose, trans), model.pose(tight, REST_POSE[None], np.zeros((1, 3)))[0]


def test_starts_on_the_body_of_the_outfit() -> None:
    way, _, rest = _walk_in()
    np.testing.assert_allclose(way.vertices[0], rest @ way.turn.T + way.shift, atol=1e-5)
    assert len(way.vertices) == way.shape_frames + way.settle_frames + way.pose_frames


def test_enters_the_sequence_at_its_velocity() -> None:
    way, sequence, _ = _walk_in()
    x = np.concatenate([way.vertices, sequence])
    v = np.diff(x, axis=0) * FPS
    k = len(way.vertices)
    assert np.abs(v[k]).max() > 1.0, "the sequence must move"
    assert np.linalg.norm(v[k] - v[k - 1], axis=1).max() < 0.25
    # Relative to the root, which goes at the sequence's velocity from the start, nothing is much faster than asked.
    v = v[:k] - way.velocity
    np.testing.assert_allclose(way.velocity, [0, -1.2, 0], atol=1e-9)
    assert np.linalg.norm(v[: k - way.pose_frames], axis=2).max() < 0.35
    assert np.linalg.norm(v, axis=2).max() < 1.5 + 0.5


def test_skin_that_is_parted_in_the_sequence_parts_on_the_way_to_it() -> None:
    plain, sequence, _ = _walk_in()
    parted = np.zeros_like(sequence[0], dtype=float)
    parted[:500, 0] = 0.03
    way, _, _ = _walk_in(parted=parted)
    moved = np.linalg.norm(way.vertices - plain.vertices, axis=2)
    before = len(way.vertices) - way.pose_frames
    assert moved[:before].max() == 0.0 and moved[:, 500:].max() == 0.0
    assert (np.diff(moved[before:, 0]) > 0).all(), "it must part more and more"
    last = way.vertices[-1] + way.velocity / FPS
    assert np.linalg.norm(last[:500] - sequence[0][:500] - parted[:500], axis=1).max() < 0.03


def test_poses_are_blended_the_short_way() -> None:
    a, b = np.zeros((1, 3)), np.array([[[0.0, 0.0, np.pi * 1.5]]])
    half = blend_poses(a, b, np.array([0.5]))
    np.testing.assert_allclose(half[0, 0], [0, 0, -np.pi / 4], atol=1e-12)
