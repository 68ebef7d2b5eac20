"""Opened limbs, judged by an independent library's exact signed distance."""

import igl
import numpy as np
from scipy.spatial.transform import Rotation

from model.body import REST_POSE, BodyModel
from stages.body.clips import perform
from stages.body.collision.segments import ARMS as ARM_SEGMENTS
from stages.body.collision.verdict import opening_faults
from stages.body.figure import Figure, measure
from stages.body.hygiene import open_limbs
from stages.body.motion import Motion
from stages.body.parts import ARM_START, ARMS, LEG_START, LEGS, TRUNK, divide
from stages.body.sequence import cut

Person = tuple[BodyModel, np.ndarray, Figure]
GAPS = 0.010, 0.008
"""Free space at arms and between legs [m]."""


def exact_distance(model: BodyModel, frame: np.ndarray, moving: np.ndarray, still: np.ndarray) -> float:
    """Smallest signed distance [m] of the vertices `moving` to the skin of `still`, in one posed body."""
    faces = model.faces[still[model.faces].all(axis=1)]
    kind = igl.SignedDistanceType.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER
    distance = igl.signed_distance(
        frame[moving].astype(np.float64), frame.astype(np.float64), faces.astype(np.int64), kind
    )[0]
    return float(distance.min())


def regions(model: BodyModel, betas: np.ndarray) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]:
    """Masks of the trunk, of both arms and both legs without the creases next to their joints."""
    vertices, joints = model.shape(betas)
    owner = model.weights.argmax(axis=1)
    arms, legs = [], []
    for side in (0, 1):
        upper, fore = ARMS[side][:2]
        along = np.abs(vertices[:, 0] - joints[upper, 0]) / abs(joints[fore, 0] - joints[upper, 0])
        arms.append(np.isin(owner, ARMS[side]) & ((owner != upper) | (along > ARM_START)))
        hip, knee = LEGS[side][:2]
        along = (joints[hip, 1] - vertices[:, 1]) / (joints[hip, 1] - joints[knee, 1])
        legs.append(np.isin(owner, LEGS[side]) & ((owner != hip) | (along > LEG_START)))
    return np.isin(owner, TRUNK), arms, legs


def test_arms_of_a_fat_walker_are_freed(someone: Person) -> None:
    model, betas, figure = someone
    motion = cut(perform(figure, "walk"), 0, 34, "walk", whole=True)
    freed, opening = open_limbs(figure, divide(model, betas), motion, GAPS)
    trunk, arms, legs = regions(model, betas)
    posed = model.pose(betas, freed.pose[::8], freed.trans[::8])
    for frame in posed:
        for side in (0, 1):
            assert exact_distance(model, frame, arms[side], trunk) > 0.007
            assert exact_distance(model, frame, legs[side], legs[1 - side]) > 0.005
    assert opening.arm_distance.min() >= 0.0095
    # Only arms that touched were turned, and they were turned smoothly.
    assert (opening.arm_turn.max() > 0) == (opening.arm_distance_before.min() < 0.010)
    assert np.abs(np.diff(opening.arm_turn, 2, axis=0)).max() < 0.01
    np.testing.assert_array_equal(freed.trans, motion.trans)


def test_crossed_arms_and_legs_are_freed(woman: Person) -> None:
    """Forearms pressed into the hips and legs pressed together come apart; the feet stay at their height."""
    model, betas, figure = woman
    pose = np.repeat(REST_POSE[None], 20, axis=0)
    pose[:, 16, 2], pose[:, 17, 2] = -1.50, 1.50
    pose[:, 1, 2], pose[:, 2, 2] = -0.10, 0.10
    motion = Motion(pose=pose, trans=np.zeros((20, 3)), planted=np.ones((20, 2), dtype=bool))
    freed, opening = open_limbs(figure, divide(model, betas), motion, GAPS)
    assert opening.arm_distance_before.max() < 0 and opening.leg_distance_before.max() < 0.004
    assert opening.arm_distance.min() > 0.0095 and opening.leg_distance.min() > 0.006
    trunk, arms, legs = regions(model, betas)
    frame = model.pose(betas, freed.pose[:1], freed.trans[:1])[0]
    assert exact_distance(model, frame, arms[0], trunk) > 0.007
    assert exact_distance(model, frame, legs[0], legs[1]) > 0.005
    before = model.pose(betas, motion.pose[:1], motion.trans[:1])[0]
    assert abs(frame[:, 2].min() - before[:, 2].min()) < 2e-3
    turned = Rotation.from_rotvec(freed.pose[:, 16]) * Rotation.from_rotvec(motion.pose[:, 16]).inv()
    np.testing.assert_allclose(turned.magnitude(), opening.arm_turn[:, 0], atol=1e-6)


def test_free_limbs_are_left_alone(woman: Person) -> None:
    model, betas, figure = woman
    pose = np.repeat(REST_POSE[None], 5, axis=0)
    motion = Motion(pose=pose, trans=np.zeros((5, 3)), planted=np.ones((5, 2), dtype=bool))
    freed, opening = open_limbs(figure, divide(model, betas), motion, GAPS)
    np.testing.assert_array_equal(freed.pose, motion.pose)
    assert opening.arm_turn.max() == 0 and opening.foot_shift.max() == 0


def test_what_takes_too_much_is_a_fault(woman: Person) -> None:
    model, betas, figure = woman
    motion = cut(perform(figure, "walk"), 0, 5, "walk", whole=True)
    _, opening = open_limbs(figure, divide(model, betas), motion, GAPS)
    assert opening_faults(opening, 0.8, 0.15) == []
    faults = opening_faults(opening, -1.0, 0.15)
    assert [fault.segments for fault in faults] == [ARM_SEGMENTS[0], ARM_SEGMENTS[1]]
    assert "only after turning the left arm by" in faults[0].cause and "largest_turn = -1 rad" in faults[0].cause


def test_an_arm_that_is_left_out_is_in_nobodys_way(woman: Person) -> None:
    """Without hands, forearms pressed into the hips still are; without arms nothing is turned."""
    model, betas, figure = woman
    pose = np.repeat(REST_POSE[None], 5, axis=0)
    pose[:, 16, 2], pose[:, 17, 2] = -1.50, 1.50
    motion = Motion(pose=pose, trans=np.zeros((5, 3)), planted=np.ones((5, 2), dtype=bool))
    hands, arms = {20, 21, 22, 23}, {16, 17, 18, 19, 20, 21, 22, 23}
    assert open_limbs(figure, divide(model, betas, hands), motion, GAPS)[1].arm_turn.min() > 0
    assert open_limbs(figure, divide(model, betas, arms), motion, GAPS)[1].arm_turn.max() == 0


def test_a_wide_stance_parts_the_thighs(someone: Person) -> None:
    model, betas, figure = someone
    assert 0.5 * abs(figure.joints[1, 0]) < figure.stance < 0.3
    fatter = measure(model, betas + np.array([0, 0.5, 0, 0, 0, 0, 0, 0, 0, 0]))
    assert fatter.stance > figure.stance
