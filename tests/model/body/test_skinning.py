"""Forward kinematics and skinning against hand-computed chains and a plain reference."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from model.body import PARENTS, joint_positions, joint_transforms, load_free_body, skin

TWO_JOINTS = np.array([[0.0, 1.0, 0.0], [2.0, 1.0, 0.0]])
TWO_PARENTS = np.array([-1, 0])


def test_two_joint_chain_by_hand() -> None:
    """An arm along x: the root turns +90 deg about z, the elbow +90 deg about z again."""
    pose = np.array([[[0.0, 0.0, np.pi / 2], [0.0, 0.0, np.pi / 2]]])
    # The elbow, 2 m along x from the root, goes 2 m up from it.
    np.testing.assert_allclose(
        joint_positions(TWO_JOINTS, TWO_PARENTS, pose)[0], [[0.0, 1.0, 0.0], [0.0, 3.0, 0.0]], atol=1e-12
    )
    points = np.array([[1.0, 1.0, 0.0], [3.0, 1.0, 0.0], [3.0, 1.0, 0.5]])
    weights = np.array([[1.0, 0.0], [0.0, 1.0], [0.5, 0.5]])
    posed = skin(points, weights, joint_transforms(TWO_JOINTS, TWO_PARENTS, pose))[0]
    # Upper arm: 1 m up from the root. Forearm: turned by 180 deg, 1 m along -x from the elbow. The last point is the
    # mean of what the root makes of it, (0, 4, 0.5), and what the elbow makes of it, (-1, 3, 0.5).
    np.testing.assert_allclose(posed, [[0.0, 2.0, 0.0], [-1.0, 3.0, 0.0], [-0.5, 3.5, 0.5]], atol=1e-12)


def test_trans_is_the_world_position_of_the_root_joint() -> None:
    """Whatever the pose, the root joint stands at `trans`."""
    rng = np.random.default_rng(3)
    pose, trans = rng.normal(0.0, 1.0, (5, 2, 3)), rng.normal(0.0, 2.0, (5, 3))
    np.testing.assert_allclose(joint_positions(TWO_JOINTS, TWO_PARENTS, pose, trans)[:, 0], trans, atol=1e-12)


def _skin_plainly(points: np.ndarray, weights: np.ndarray, transforms: np.ndarray) -> np.ndarray:
    """x'_n = sum_k w_nk (R_k x_n + t_k), one frame, vertex and joint at a time."""
    out = np.zeros((len(transforms), len(points), 3))
    for t, frame in enumerate(transforms):
        for n, point in enumerate(points):
            for k, transform in enumerate(frame):
                out[t, n] += weights[n, k] * (transform[:, :3] @ point + transform[:, 3])
    return out


@pytest.mark.parametrize("frames", [1, 33])
def test_skin_agrees_with_the_plain_reference(frames: int) -> None:
    """Both paths of `skin`, over more than one chunk of frames, against the loops."""
    rng = np.random.default_rng(5)
    joints = rng.normal(0.0, 0.3, (24, 3))
    points, weights = rng.normal(0.0, 1.0, (7, 3)), rng.dirichlet(np.ones(24), 7)
    transforms = joint_transforms(joints, PARENTS, rng.normal(0.0, 0.8, (frames, 24, 3)))
    expected = _skin_plainly(points, weights, transforms)
    np.testing.assert_allclose(skin(points, weights, transforms), expected, atol=1e-12)
    moving = np.broadcast_to(points, (frames, 7, 3))
    np.testing.assert_allclose(skin(moving, weights, transforms), expected, atol=1e-12)


def test_frames_are_independent() -> None:
    """A frame's result is the same alone and inside a sequence."""
    body = load_free_body("female")
    pose = np.random.default_rng(7).normal(0.0, 0.3, (40, 24, 3))
    together = body.pose([0.5, -1.0], pose)
    np.testing.assert_allclose(together[37], body.pose([0.5, -1.0], pose[37:38])[0], atol=2e-6)


@settings(max_examples=15, deadline=None)
@given(turn=st.tuples(*[st.floats(-3.0, 3.0)] * 3), seed=st.integers(0, 2**16))
def test_turning_the_root_turns_the_body(turn: tuple[float, float, float], seed: int) -> None:
    """A rotation put before the root's own rotates every vertex about the root joint."""
    rng = np.random.default_rng(seed)
    rotation = Rotation.from_rotvec(turn)
    points, weights = rng.normal(0.0, 1.0, (9, 3)), rng.dirichlet(np.ones(24), 9)
    joints, pose = rng.normal(0.0, 0.3, (24, 3)), rng.normal(0.0, 0.5, (1, 24, 3))
    turned = pose.copy()
    turned[0, 0] = (rotation * Rotation.from_rotvec(pose[0, 0])).as_rotvec()
    before = skin(points, weights, joint_transforms(joints, PARENTS, pose))[0]
    after = skin(points, weights, joint_transforms(joints, PARENTS, turned))[0]
    np.testing.assert_allclose(after, rotation.apply(before - joints[0]) + joints[0], atol=1e-10)


def test_a_pose_of_the_wrong_shape_is_refused() -> None:
    """The message says what was expected and what came."""
    with pytest.raises(ValueError, match=r"pose must have shape \[T, 2, 3\], got \(2, 3\)"):
        joint_transforms(TWO_JOINTS, TWO_PARENTS, np.zeros((2, 3)))
