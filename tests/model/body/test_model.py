"""The body model: zero pose, pose correctives, resampling, refusals."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from model.body import REST_POSE, BodyModel, joint_positions, load_body, load_free_body, rotation_matrices, save_body

BETAS = [0.7, -1.2, 0.4, 0.0, 1.0]


@pytest.fixture(params=["female", "male"])
def body(request: pytest.FixtureRequest) -> BodyModel:
    """The embedded body of each gender."""
    return load_free_body(request.param)


def test_zero_pose_is_the_shape(body: BodyModel) -> None:
    """Without rotation, skinning is the identity."""
    vertices, _ = body.shape(BETAS)
    np.testing.assert_allclose(body.pose(BETAS, np.zeros((2, 24, 3)))[1], vertices, atol=1e-6)


def test_missing_betas_are_zero(body: BodyModel) -> None:
    """A short vector of betas means zeros behind it."""
    np.testing.assert_array_equal(body.shape([1.5])[0], body.shape([1.5] + [0.0] * 9)[0])
    with pytest.raises(ValueError, match="at most 10 entries, got 11"):
        body.shape(np.zeros(11))


def test_rest_pose_stands_in_the_world(body: BodyModel) -> None:
    """z up, facing -y, the left arm along +x, the root joint at `trans`."""
    trans = np.array([[0.3, -2.0, 0.9]])
    vertices = body.pose(BETAS, REST_POSE[None], trans)[0]
    joints = joint_positions(body.shape(BETAS)[1], body.parents, REST_POSE[None], trans)[0]
    np.testing.assert_allclose(joints[0], trans[0], atol=1e-12)
    assert joints[15, 2] > joints[0, 2] + 0.4, "the head is above the pelvis"
    assert joints[20, 0] > joints[0, 0] + 0.4, "the left wrist is on the +x side"
    assert joints[10, 1] < joints[7, 1] - 0.05, "the toes point to -y"
    np.testing.assert_allclose(np.ptp(vertices[:, 0]), np.ptp(body.shape(BETAS)[0][:, 0]), atol=0.02)


def test_trans_moves_the_body_without_turning_it(body: BodyModel) -> None:
    """The difference between two placements is the same for every vertex."""
    pose = np.random.default_rng(1).normal(0.0, 0.2, (1, 24, 3))
    there, here = body.pose(BETAS, pose, [[1.0, 2.0, 3.0]]), body.pose(BETAS, pose, [[0.0, 0.0, 0.0]])
    np.testing.assert_allclose(there - here, np.broadcast_to([1.0, 2.0, 3.0], here.shape), atol=2e-6)


def _tiny_with_correctives() -> BodyModel:
    """Two joints, three vertices, random pose correctives."""
    rng = np.random.default_rng(0)
    return BodyModel(
        gender="neutral",
        v_template=rng.normal(0.0, 1.0, (3, 3)).astype(np.float32),
        shapedirs=rng.normal(0.0, 0.1, (3, 3, 2)).astype(np.float32),
        joint_template=np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]]),
        joint_shapedirs=np.zeros((2, 3, 2)),
        weights=np.array([[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]], np.float32),
        parents=np.array([-1, 0], np.int32),
        faces=np.array([[0, 1, 2]], np.int32),
        posedirs=rng.normal(0.0, 0.1, (3, 3, 9)).astype(np.float32),
    )


def test_pose_correctives_follow_the_formula() -> None:
    """Vertices move by posedirs (R - I) before skinning; the root's rotation does not count (SMPL, equation 9)."""
    body = _tiny_with_correctives()
    pose = np.random.default_rng(2).normal(0.0, 0.7, (1, 2, 3))
    assert body.posedirs is not None
    feature = (rotation_matrices(pose[0, 1]) - np.eye(3)).reshape(-1)
    moved = replace(body, v_template=(body.v_template + body.posedirs @ feature).astype(np.float32), posedirs=None)
    np.testing.assert_allclose(body.pose([0.3], pose), moved.pose([0.3], pose), atol=1e-6)
    assert np.abs(moved.v_template - body.v_template).max() > 0.01, "the correctives do something here"


def test_resample_commutes_with_shape_and_pose(body: BodyModel) -> None:
    """Selected vertices move as before, and the middle of an edge is in the middle after shaping."""
    picked = sp.csr_array((np.ones(3), ([0, 1, 2], body.faces[100])), shape=(3, body.vertex_count))
    middle = sp.csr_array(([0.5, 0.5], ([0, 0], body.faces[100, :2])), shape=(1, body.vertex_count))
    small = body.resample(sp.vstack([picked, middle]), np.array([[0, 3, 2], [3, 1, 2]]))
    pose = np.random.default_rng(4).normal(0.0, 0.3, (2, 24, 3))
    np.testing.assert_allclose(small.pose(BETAS, pose)[:, :3], body.pose(BETAS, pose)[:, body.faces[100]], atol=2e-6)
    np.testing.assert_allclose(
        small.shape(BETAS)[0][3], body.shape(BETAS)[0][body.faces[100, :2]].mean(axis=0), atol=1e-6
    )
    np.testing.assert_allclose(small.weights.sum(axis=1), 1.0, atol=1e-6)
    np.testing.assert_array_equal(small.joint_shapedirs, body.joint_shapedirs)


def test_resample_refuses_rows_that_do_not_sum_to_one(body: BodyModel) -> None:
    """Such rows would scale the body."""
    rows = sp.csr_array(([0.5], ([0], [0])), shape=(1, body.vertex_count))
    with pytest.raises(ValueError, match="sum to 1, row 0"):
        body.resample(rows, np.zeros((0, 3), np.int32))


def test_arrays_that_do_not_fit_are_refused() -> None:
    """The message names the field and both shapes."""
    body = _tiny_with_correctives()
    with pytest.raises(ValueError, match=r"BodyModel.weights must have shape \(3, 2\), got \(2, 2\)"):
        replace(body, weights=body.weights[:2])


def test_save_and_load_round_trip(tmp_path: Path) -> None:
    """What is read back is what was written, within the steps of the file."""
    body = replace(_tiny_with_correctives(), posedirs=None)
    save_body(tmp_path / "body.npz", body)
    read = load_body(tmp_path / "body.npz")
    assert read.gender == "neutral"
    np.testing.assert_array_equal(read.v_template, body.v_template)
    np.testing.assert_array_equal(read.faces, body.faces)
    np.testing.assert_array_equal(read.parents, body.parents)
    np.testing.assert_allclose(read.shapedirs, body.shapedirs, atol=0.51e-5)
    np.testing.assert_allclose(read.weights, body.weights, atol=1e-3)
    with pytest.raises(ValueError, match="posedirs cannot be stored"):
        save_body(tmp_path / "other.npz", _tiny_with_correctives())
