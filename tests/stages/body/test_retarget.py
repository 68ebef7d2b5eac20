"""A recorded motion on the body: the same directions of limbs, feet on the ground and at rest."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model.body import PARENTS, BodyModel
from stages.body.clips import perform
from stages.body.fidelity import sole_points
from stages.body.figure import Figure
from stages.body.grounding import ground
from stages.body.joint_map import BONES, match
from stages.body.motion import Motion
from stages.body.readers.bvh import read_bvh
from stages.body.repair import drop_fake_start, mend_flips
from stages.body.resample import resample
from stages.body.retarget import joint_positions, local_rotations, retarget
from stages.body.sequence import prepared, put_on
from stages.body.turns import WORLD_FROM_MODEL, axis_angle, turn, unit
from stages.spec import DataError
from tests.stages.body.skeletons import person
from tests.stages.body.test_clips import feet_of

Person = tuple[BodyModel, np.ndarray, Figure]


def directions(positions: np.ndarray, joint_of: dict[int, int]) -> np.ndarray:
    """Unit vectors of the limbs and of the trunk, shape [T, 9, 3]."""
    pairs = [*BONES.items(), (0, 12)]
    return np.stack([unit(positions[:, joint_of[b]] - positions[:, joint_of[a]]) for a, b in pairs], axis=1)


def test_limbs_point_where_the_recorded_ones_do(tmp_path: Path, someone: Person) -> None:
    """Whatever the pose and the rest pose, limbs agree to rounding before the feet are put on the ground."""
    _, _, figure = someone
    rng = np.random.default_rng(5)
    angles = rng.uniform(-80, 80, (20, 24, 3))
    angles[:, 10:15] *= 0.25
    made = person(angles, rng.normal(size=(20, 3)), 1 / 30, "YXZ")
    path = tmp_path / "made.bvh"
    path.write_text(made.text())
    recording = read_bvh(path)
    ours = joint_positions(figure, *retarget(recording, figure, "made"))
    theirs = directions(recording.forward()[1], match(recording.names))
    aligned = directions(ours, {j: j for j in range(24)})
    angles = np.degrees(np.arccos(np.clip((theirs * aligned).sum(-1), -1, 1)))
    assert angles[:, :8].max() < 0.01
    # The trunk bends in three places there as here, but its bones are not the same ones.
    assert angles[:, 8].mean() < 8


def test_axes_and_units_do_not_matter(tmp_path: Path, woman: Person) -> None:
    """A z-up skeleton in centimetres, facing -y, moves the body as the same skeleton y-up does."""
    _, _, figure = woman
    angles = np.zeros((1, 24, 3))
    angles[0, 2, 2], angles[0, 16, 0] = 30, -60
    path = tmp_path / "made.bvh"
    made = person(angles, np.zeros((1, 3)), 1 / 30)
    path.write_text(made.text())
    upright = retarget(read_bvh(path), figure, "made")[0]
    turned = person(angles, np.zeros((1, 3)), 1 / 30)
    object.__setattr__(turned, "offsets", 100 * made.offsets @ WORLD_FROM_MODEL.T)
    # The same turns about the axes that z, y and x become: -y, z and x.
    swapped = angles * [-1, 1, 1]
    object.__setattr__(turned, "angles", swapped)
    object.__setattr__(turned, "orders", ["YZX"] * 24)
    path.write_text(turned.text())
    np.testing.assert_allclose(retarget(read_bvh(path), figure, "made")[0], upright, atol=1e-6)


def test_a_missing_joint_is_named(tmp_path: Path, woman: Person) -> None:
    path = tmp_path / "made.bvh"
    path.write_text(person(np.zeros((1, 24, 3)), np.zeros((1, 3)), 1 / 30).text().replace("LeftForeArm", "Elbow"))
    with pytest.raises(DataError, match=r"made\.bvh: no joint is known to move left_elbow;.* has LHipJoint, Elbow"):
        retarget(read_bvh(path), woman[2], "made.bvh")


def test_a_skeleton_without_offsets_is_refused(tmp_path: Path, woman: Person) -> None:
    made = person(np.zeros((1, 24, 3)), np.zeros((1, 3)), 1 / 30)
    made.offsets[:] = 0
    path = tmp_path / "made.bvh"
    path.write_text(made.text())
    with pytest.raises(DataError, match="left_hip and left_knee are in one place"):
        retarget(read_bvh(path), woman[2], "made.bvh")


def test_grounding_finds_the_floor_and_stops_slides(woman: Person) -> None:
    """A clip lifted by 0.4 m, drifting by 0.15 m/s, stands on the ground again and does not slide."""
    model, betas, figure = woman
    motion = perform(figure, "walk")
    local = Rotation.from_rotvec(motion.pose[:120].reshape(-1, 3)).as_matrix().reshape(120, 24, 3, 3)
    world = local.copy()
    world[:, 0] = WORLD_FROM_MODEL.T @ local[:, 0]
    for joint in range(1, 24):
        world[:, joint] = world[:, PARENTS[joint]] @ local[:, joint]
    root = motion.trans[:120] @ WORLD_FROM_MODEL + [0.0, 0.4, 0.0]
    root[:, 0] += 0.005 * np.arange(120)
    out, path, planted = ground(figure, world, root)
    turned = local_rotations(out)
    turned[:, 0] = WORLD_FROM_MODEL @ turned[:, 0]
    grounded = Motion(pose=axis_angle(turned), trans=path @ WORLD_FROM_MODEL.T, planted=planted)
    assert (planted == motion.planted[:120]).mean() > 0.8
    assert_feet_hold(model, betas, grounded, mean=5e-4, most=2e-3)


def test_a_foot_that_trembles_stands_still_and_one_that_turns_turns(woman: Person) -> None:
    """Feet that are turned by up to 5 degrees to and fro don't slide; by 60 degrees, they follow, 6 degrees behind."""
    figure = woman[2]
    for heading, slide in ((np.radians(5) * np.sin(np.arange(40) / 2), 2e-5), (np.radians(1.5) * np.arange(40), 6e-3)):
        world = np.broadcast_to(np.eye(3), (40, 24, 3, 3)).copy()
        for joint in (7, 8, 10, 11):
            world[:, joint] = turn("y", heading)
        out, root, planted = ground(figure, world, np.zeros((40, 3)))
        turned = local_rotations(out)
        turned[:, 0] = WORLD_FROM_MODEL @ turned[:, 0]
        motion = Motion(pose=axis_angle(turned), trans=root @ WORLD_FROM_MODEL.T, planted=planted)
        assert planted.all()
        assert np.linalg.norm(np.diff(sole_points(figure, motion, 0), axis=0), axis=-1).max() < slide
        found = np.arctan2(out[:, 7, 0, 2], out[:, 7, 2, 2])
        assert np.abs(found - heading).max() < np.radians(11.0) and abs(found[-1] - heading[-1]) < np.radians(6.1)


def test_real_captures_keep_their_directions(captures: Path, woman: Person) -> None:
    model, betas, figure = woman
    for name in ("walking_1.bvh", "jumping_1.bvh"):
        source = resample(mend_flips(drop_fake_start(read_bvh(captures / name)))[0])
        world, root, planted = ground(figure, *retarget(source, figure, name))
        theirs = directions(source.forward()[1], match(source.names))
        ours = directions(joint_positions(figure, world, root), {j: j for j in range(24)})
        angles = np.degrees(np.arccos(np.clip((theirs * ours).sum(-1), -1, 1)))
        assert angles.mean() < 3 and angles.mean(axis=0).max() < 5
        motion = put_on(figure, prepared(read_bvh(captures / name), name)[0], name)
        assert planted.mean() > 0.4
        assert_feet_hold(model, betas, motion, mean=1e-3, most=3e-3)


def assert_feet_hold(model: BodyModel, betas: np.ndarray, motion: Motion, mean: float, most: float) -> None:
    """No foot sinks; the skin that touches the ground slides little while the foot bears weight [m a frame]."""
    for side in (0, 1):
        foot = feet_of(model, betas, motion, side)
        assert foot[..., 2].min() > -2e-3
        contact = (foot[1:, :, 2] < 3e-3) & (foot[:-1, :, 2] < 3e-3)
        both = motion.planted[1:, side] & motion.planted[:-1, side]
        slide = np.linalg.norm(np.diff(foot[..., :2], axis=0), axis=-1)
        frames = np.flatnonzero(both & contact.any(axis=1))
        assert len(frames) > 0.5 * both.sum() > 5
        slides = [np.median(slide[t][contact[t]]) for t in frames]
        assert np.mean(slides) < mean and np.percentile(slides, 95) < most
