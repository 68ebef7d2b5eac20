"""Parted skin, judged by an independent library's exact intersections."""

from dataclasses import replace
from typing import Any

import igl.copyleft.cgal as cgal
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from model.body import REST_POSE, BodyModel, joint_transforms, load_free_body
from stages.body.collision.contacts import Normals
from stages.body.collision.field import envelope
from stages.body.collision.intersect import Intersector
from stages.body.collision.planes import heights
from stages.body.collision.segments import ARMS, NAMES, Segments, pair_name, segment
from stages.body.collision.solve import Solution, as_stored, part_segments
from stages.body.collision.thinner import thinner
from stages.body.config import Config
from stages.body.freeing import Freed, UnsolvableError, free_body
from stages.body.motion import Motion

HEAVY = np.array([1.0, 2.0, 0, 0, 0, 0, 0, 0, 0, 0], np.float32)


def crossing_faces(segments: Segments, x: np.ndarray) -> set[tuple[int, int]]:
    """Pairs of faces of treated segments that intersect, by CGAL."""
    found = cgal.remesh_self_intersections(x.astype(np.float64), segments.faces.astype(np.int64), True)[2]
    label = np.sort(segments.face_label[found], axis=1)
    treated = np.array([tuple(pair) in segments.pairs for pair in label.tolist()], dtype=bool)
    return set(map(tuple, np.sort(found[treated.reshape(-1)], axis=1).tolist()))


def bend(**joints: tuple[float, float, float]) -> np.ndarray:
    """One second in which some joints (`j18`, ...) turn from rest to an angle [rad] and back, shape [30, 24, 3]."""
    pose = np.repeat(REST_POSE[None], 30, axis=0)
    share = np.sin(np.linspace(0, np.pi, 30)) ** 2
    for name, angle in joints.items():
        pose[:, int(name[1:])] += share[:, None] * angle
    return pose


def parted(model: BodyModel, betas: np.ndarray, pose: np.ndarray) -> tuple[Segments, np.ndarray, Solution]:
    """Segments, skin before, and the solution."""
    segments = segment(model, betas)
    before = model.pose(betas, pose, np.zeros((len(pose), 3)))
    axes = joint_transforms(model.shape(betas)[1], model.parents, pose)[..., :3]
    return segments, before, part_segments(segments, before, axes, 0.008)


def test_the_tester_finds_what_cgal_finds() -> None:
    model = load_free_body("female")
    segments = segment(model, HEAVY)
    tester = Intersector(segments)
    pose = bend(j18=(0, -2.5, 0), j4=(2.3, 0, 0), j1=(-1.9, 0, 0), j15=(0.7, 0, 0))
    for x in model.pose(HEAVY, pose[[11, 15]], np.zeros((2, 3))):
        wanted = crossing_faces(segments, x)
        assert (
            set(map(tuple, np.sort(tester.crossings(x[None])[0].faces, axis=1).tolist())) == wanted and len(wanted) > 20
        )


@pytest.mark.parametrize(
    ("pair", "pose"),
    [
        ("left_upper_arm / left_forearm", bend(j18=(0, -2.4, 0))),
        ("left_thigh / left_shank", bend(j4=(2.2, 0, 0))),
        ("torso / left_upper_arm", bend(j16=(0, 0, -1.3))),
        ("torso / right_thigh", bend(j2=(-1.4, 0, 0))),
    ],
)
def test_a_fold_is_parted(pair: str, pose: np.ndarray) -> None:
    """No edge is left in a face, in what the shard stores; skin moves little, smoothly, and only about the fold."""
    model = load_free_body("male")
    segments, before, solution = parted(model, HEAVY, pose)
    assert crossing_faces(segments, before[15])
    assert not solution.left and pair in map(pair_name, solution.partings)
    for t in range(0, 30, 3):
        assert not crossing_faces(segments, as_stored(solution.vertices[t]))
    shift = solution.vertices - before
    far = np.linalg.norm(shift, axis=2)
    assert far.max() < 0.05
    record = solution.partings[next(p for p in solution.partings if pair_name(p) == pair)]
    assert record.moved.max() > 0.003 and record.depth.max() > 0.001
    assert not far[:, ~np.any([p.skin for p in solution.partings.values()], axis=0)].any()
    # Nothing pops: a movement takes three frames to come at the least, and its second difference is small.
    assert np.linalg.norm(np.diff(shift, axis=0), axis=2).max() < 0.012
    assert np.linalg.norm(np.diff(shift, 2, axis=0), axis=2).max() < 0.006
    # No spikes: each vertex moves like its neighbours.
    mean = np.stack([segments.mean @ s for s in shift])
    assert np.linalg.norm(shift - mean, axis=2).max() < 0.02


def test_free_skin_is_left_alone() -> None:
    model = load_free_body("female")
    _, before, solution = parted(model, np.zeros(10), np.repeat(REST_POSE[None], 4, axis=0))
    np.testing.assert_array_equal(solution.vertices, before)
    assert not solution.partings and not solution.left


def test_segments_left_out_are_not_parted() -> None:
    model = load_free_body("female")
    segments = segment(model, np.zeros(10), ARMS[0])
    assert not any(set(pair) & set(ARMS[0]) for pair in segments.pairs)
    assert any(NAMES.index("right_forearm") in pair for pair in segments.pairs)


def test_normals_and_heights() -> None:
    """Normals of a ball point away from its centre; a surface bends with the midpoints that it goes through."""
    model = load_free_body("female")
    x = model.v_template
    away = x / np.linalg.norm(x, axis=1, keepdims=True)
    ball = away.astype(np.float32)
    normals = Normals(model.faces, len(x)).at(ball, np.arange(len(x)))
    out = np.einsum("ni,ni->n", normals, away)
    assert np.quantile(np.abs(out), 0.1) > 0.9
    middle = np.column_stack([np.linspace(-0.1, 0.1, 41), np.zeros(41), np.linspace(-0.1, 0.1, 41) * 0.3])
    points = middle[10:31] + np.array([0.0, 0.0, 0.004])
    np.testing.assert_allclose(heights(points, middle, np.array([0.0, 0.0, 1.0])), 0.004, atol=3e-4)


def test_an_envelope_undercuts_nothing() -> None:
    need = np.zeros((60, 2), np.float32)
    need[30, 0], need[10:20, 1] = 0.02, np.random.default_rng(1).uniform(0, 0.02, 10)
    smooth = envelope(need)
    assert (smooth >= need - 1e-6).all()
    assert np.abs(np.diff(smooth, axis=0)).max() < 0.005 < np.abs(np.diff(gaussian_filter1d(need, 0.5, axis=0))).max()


def test_a_thinner_body_has_less_volume() -> None:
    for gender in ("female", "male"):
        model = load_free_body(gender)
        slim = thinner(model, np.zeros(10, np.float32), 1.0)
        np.testing.assert_array_equal(slim, [0, -1, 0, 0, 0, 0, 0, 0, 0, 0])
    lean = np.array([2, -3, 0, 0, 0, 0, 0, 0, 0, 1], np.float32)
    np.testing.assert_array_equal(thinner(model, lean, 1.0), lean)


def test_a_thinner_body_where_betas_mean_something_else() -> None:
    """A foreign body whose first beta is fatness, the other way round, and whose third is size."""
    free = load_free_body("female")
    axes = free.shapedirs[:, :, [1, 2, 0, *range(3, free.beta_count)]] * ([-1.0] + [1.0] * (free.beta_count - 1))
    model = replace(free, shapedirs=axes.astype(free.shapedirs.dtype))
    np.testing.assert_array_equal(thinner(model, np.zeros(10, np.float32), 1.0), [1, 0, 0, 0, 0, 0, 0, 0, 0, 0])


def test_what_was_known_of_still_skin_is_kept() -> None:
    """Looking only at skin that moved finds what looking at all of it does."""
    model = load_free_body("female")
    tester = Intersector(segment(model, HEAVY))
    pose = bend(j18=(0, -2.5, 0), j4=(2.3, 0, 0), j1=(-1.9, 0, 0))[15]
    x = model.pose(HEAVY, pose[None], np.zeros((1, 3)))[0]
    known = tester.crossings(x[None])[0]
    moved = np.zeros(len(x), bool)
    moved[np.unique(tester.faces[known.faces[: len(known) // 2]])] = True
    shifted = x + 0.01 * moved[:, None].astype(np.float32)
    wanted, found = tester.crossings(shifted[None])[0], tester.crossings(shifted[None], [known], moved)[0]
    assert set(map(tuple, found.faces.tolist())) == set(map(tuple, wanted.faces.tolist()))
    assert len(found) == len(wanted) > 20 and set(map(tuple, known.faces.tolist())) != set(map(tuple, wanted.faces))


def still(pose: np.ndarray) -> Motion:
    """A pose that is held for a moment."""
    held = np.repeat(pose[None], 6, axis=0)
    return Motion(pose=held, trans=np.zeros((6, 3)), planted=np.ones((6, 2), dtype=bool))


def test_the_cases() -> None:
    """Solved, thinner, special, rejected: the same fold under tighter and tighter limits."""
    model = load_free_body("male")
    pose = bend(j2=(-1.4, 0, 0))[15]

    def solve(betas: np.ndarray, **limits: Any) -> Freed:
        return free_body(model, betas, lambda figure: still(pose), Config(**limits), "someone", still=True)

    solved = solve(HEAVY)
    assert solved.record["case"] == "solved" and solved.face_kept.all() and not solved.record["why"]
    most, less = (float(free.moved["moved"].max()) for free in (solved, solve(thinner(model, HEAVY, 1.0))))
    assert less < 0.95 * most
    slim = solve(HEAVY, largest_move=(most + less) / 2, leave_out="nothing")
    assert slim.record["case"] == "thinner" and slim.record["thinner"] == 1 and "largest_move" in slim.record["why"][0]
    assert slim.betas[1] == HEAVY[1] - 1
    np.testing.assert_array_equal(slim.record["betas_drawn"], HEAVY)
    with pytest.raises(
        UnsolvableError, match=r"someone: .* are parted only by moving skin \d+ mm in frame \d"
    ) as caught:
        solve(HEAVY, largest_move=0.002, thinner_tries=1)
    assert caught.value.marked.any() and caught.value.vertices.shape == (model.vertex_count, 3)


@pytest.mark.parametrize(("most", "left_out"), [(0.25, ["left_hand"]), (0.15, ["left_forearm", "left_hand"])])
def test_arms_are_left_out_where_nothing_else_helps(most: float, left_out: list[str]) -> None:
    """A forearm in the hip, and little leave to turn the arm: without the hand less is needed."""
    model, betas = load_free_body("female"), np.zeros(10, np.float32)
    pose = REST_POSE.copy()
    pose[16] += (0, 0, -1.4)
    pose[18] = (0, 0, -0.6)

    def solve(**limits: Any) -> Freed:
        config = Config(thinner_tries=0, largest_turn=most, arm_gap=0.010, separation=0.008, **limits)
        return free_body(model, betas, lambda figure: still(pose), config, "someone")

    special = solve()
    assert special.record["case"] == "special" and special.record["left_out"] == left_out
    rows = [NAMES.index(name) for name in left_out]
    np.testing.assert_array_equal(special.face_kept, ~np.isin(segment(model, betas).face_label, rows))
    with pytest.raises(
        UnsolvableError, match=r"turning the left arm by 0\.\d+ rad .*; 0 thinner bodies and .* nothing"
    ):
        solve(leave_out="nothing")
