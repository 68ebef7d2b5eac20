"""The plan of a scene: what it leaves out changes nothing, and what it is wrong about is seen in time."""

import json
from dataclasses import replace
from typing import Any

import igl
import numpy as np
import pytest
from small_scenes import ball, garment, scene, sheet

from stages.simulate.config import SimulateConfig
from stages.simulate.make_stepper import STIFF_STEPS, careful, make_springs, make_stepper
from stages.simulate.plan import ITEMS, Plan, longer, make_plan
from stages.simulate.runtime import start_taichi
from stages.simulate.scene import Scene
from stages.simulate.snapshot import restore, take
from stages.simulate.solve import Solution, advance_frame, presentable, solve

CONFIG = SimulateConfig(threads=1)


@pytest.fixture(autouse=True)
def _started() -> None:
    start_taichi(1)


def two_balls(way: Any, frames: int) -> Scene:
    """A sheet that lies down on a ball, beside another ball that is at way(k) (3,) [m] in frame k."""
    v, f = sheet(16, 16, 0.015)
    still, faces = ball(0.1, 3)
    other, _ = ball(0.05, 3)
    one = scene(
        garment(v, f),
        start=v + np.array([-0.11, -0.11, 0.104]),
        body=(np.concatenate([still, other]), np.concatenate([faces, faces + len(still)]).astype(np.int32)),
        frames=frames,
    )
    return replace(one, body=lambda k: np.concatenate([still, other + way(k)]), body_frames=frames + 1)


def planned(one: Scene, decide: tuple[str, ...]) -> tuple[Plan, Solution]:
    plan = make_plan(one, CONFIG, decide)
    return plan, solve(one, CONFIG, plan=plan)


def test_skin_out_of_reach_is_left_out_and_changes_no_bit() -> None:
    one = two_balls(lambda k: np.array([1.0, 0.02 * k, 0.0]), frames=3)
    cloth = one.garments[0]
    one = replace(one, garments=[replace(cloth, tied=np.linalg.norm(cloth.vertices - 0.11, axis=1) < 0.15)])
    plan, fewer = planned(one, ("body",))
    _, all_of_it = planned(one, ())
    about = fewer.plan["body_faces"]
    assert about["all"] == len(one.body_faces)
    assert 0.45 * about["all"] <= about["left_out"] < 0.75 * about["all"], "the other ball, and the lower half of this"
    assert about["least_distance_m"] > about["guard_m"]
    assert not fewer.plan["events"]
    np.testing.assert_array_equal(fewer.x, all_of_it.x)
    assert plan.left_out.any() and not all_of_it.plan["body_faces"]["left_out"]


def test_skin_that_comes_after_all_is_turned_on_in_time() -> None:
    """A plan made for a ball that stays away, on the same scene with one that falls on the cloth at 4 m/s."""
    from_afar = np.array([0.0, 0.0, 1.0])
    harmless = two_balls(lambda k: from_afar, frames=10)
    one = two_balls(lambda k: np.array([0.0, 0.0, max(0.155, 1.0 - 0.133 * k)]), frames=10)
    wrong = make_plan(harmless, CONFIG)
    assert wrong.left_out.sum() > make_plan(one, CONFIG).left_out.sum(), "it must be wrong"
    solution = solve(one, CONFIG, plan=wrong)
    events = solution.plan["events"]
    assert events and 3 <= events[0]["frame"] <= 7
    assert "turned on" in events[0]["what"] and "mm" in events[0]["why"]
    for k, x in enumerate(solution.x):
        body = np.ascontiguousarray(one.body(k))
        # Shell by shell: the balls come so close to each other that cloth is shut in between them.
        for part in (slice(0, 642), slice(642, 1284)):
            faces = np.ascontiguousarray(ball(0.1, 3)[1], np.int64)
            assert igl.signed_distance(x, body[part], faces)[0].min() > -1e-5, f"frame {k}"
    right = solve(one, CONFIG, plan=replace(wrong, left_out=np.zeros_like(wrong.left_out)))
    assert np.abs(solution.x - right.x).max() < 1e-9, "it was turned on before it could be felt"


def test_everything_turned_on_at_once_when_nothing_is_followed() -> None:
    one = two_balls(lambda k: np.array([1.0, 0.0, 0.0]), frames=3)
    plan = make_plan(one, CONFIG, ())
    nothing = replace(plan, left_out=np.ones_like(plan.left_out))
    solution = solve(one, CONFIG, plan=nothing)
    assert solution.plan["events"][0]["frame"] == 1
    assert np.abs(solution.x - solve(one, CONFIG, plan=plan).x).max() < 1e-9


def test_pairs_kept_for_several_steps_change_little() -> None:
    v, f = sheet(14, 14, 0.015)
    start = np.concatenate([v, v + np.array([0.02, 0.03, 0.006])]) + np.array([-0.1, -0.1, 0.105])
    one = scene(garment(v, f, name="inner"), garment(v, f, name="outer"), start=start, body=ball(0.1, 3), frames=5)
    kept, anew = planned(one, ("pairs",))[1], planned(one, ())[1]
    assert kept.report.pairs > 0
    apart = np.sqrt(((kept.x - anew.x) ** 2).sum(2).mean(1))
    assert apart[1] < 1e-4 and apart[2] < 3e-3, "then they part: both slide off"
    assert kept.plan["garments"] == [{"pair": ["inner", "outer"], "meet": True, "least_distance_m": 0.0}]


def test_garments_far_apart_cannot_meet() -> None:
    v, f = sheet(6, 6, 0.02)
    pins = np.array([0, 5, 36, 41])
    one = scene(garment(v, f), garment(v, f), start=np.concatenate([v, v + np.array([2.0, 0, 0])]), frames=2, pins=pins)
    (pair,) = make_plan(one, CONFIG).record["garments"]
    assert not pair["meet"]
    assert 1.4 < pair["least_distance_m"] < 1.9


def test_steps_are_longer_where_little_moves_and_shorter_where_much_does() -> None:
    # The ball rises slowly below a sheet held at its corners, then by 5 cm a frame into it.
    height = np.concatenate([0.001 * np.arange(6), 0.005 + 0.05 * np.arange(1, 5)])
    v, f = sheet(14, 14, 0.015)
    one = scene(
        garment(v, f),
        start=v + np.array([-0.1, -0.1, 0.15]),
        body=ball(0.1, 3),
        pins=np.array([0, 13, 182, 195]),
        motion=lambda k: np.array([0.0, 0.0, height[k]]),
        frames=9,
    )
    plan, chosen = planned(one, ("steps",))
    usual = round(1 / 30 / CONFIG.dt)
    assert (plan.steps[1:4] < usual).all() and (plan.steps[7:9] > usual).all()
    steps = chosen.plan["steps"]
    assert steps["planned"] == plan.steps[1:].tolist() and len(steps["taken"]) == 9
    assert sum(steps["taken"]) == chosen.report.steps
    assert min(steps["taken"]) < usual < max(steps["taken"])
    shortest, of_all = planned(one, ())
    assert (shortest.steps == plan.steps.max()).all() and min(of_all.plan["steps"]["taken"]) == plan.steps.max()
    apart = np.sqrt(((chosen.x - of_all.x) ** 2).sum(2).mean(1))
    assert 0 < apart.max() < 5e-3, "everything is 4 mm from its limit itself, where the ball hits the sheet"


def test_cloth_that_moves_by_itself_forbids_the_longer_step() -> None:
    v, f = sheet(8, 8, 0.03)
    one = scene(garment(v, f), start=v, frames=8, pins=np.array([0, 1, 2]))
    plan, solution = planned(one, ITEMS)
    taken = solution.plan["steps"]["taken"]
    assert (plan.steps[1:] == 2).all(), "nothing moves but the cloth"
    assert taken[0] == 4, "the first step is of first order"
    assert min(taken) < 4 and taken[-1] == 4


def test_longest_step_follows_the_speed() -> None:
    assert longer(np.array([0.0, 0.25, 0.5, 1.0, 9.0]), 2.0).tolist() == pytest.approx([2, 2, 2**0.5, 1, 1])
    assert longer(0.0, 1.0) == 1.0


def test_record_says_what_matters() -> None:
    one = two_balls(lambda k: np.array([1.0, 0.0, 0.0]), frames=2)
    record = solve(one, CONFIG).plan
    assert json.loads(json.dumps(record)) == record
    assert record["decided"] == list(ITEMS) and solve(one, replace(CONFIG, plan="everything")).plan["decided"] == []
    forces = record["forces"]
    assert not forces["air"]["matters"] and not forces["elastics"]["matters"]
    windy = replace(one, wind=(5.0, 0.0, 0.0))
    fabric = replace(one.garments[0].fabric, drag=0.2)
    windy = replace(windy, garments=[replace(one.garments[0], fabric=fabric)])
    # 0.2 kg/(m^2 s) 5 m/s over 0.2 kg/m^2 9.81 m/s^2
    assert make_plan(windy, CONFIG).record["forces"]["air"]["over_weight"] == pytest.approx(1 / (0.2 * 9.81), rel=1e-3)


def test_a_run_goes_on_from_a_snapshot_taken_after_skin_was_turned_on() -> None:
    # Faces are numbered by the skin that is followed: a stepper that starts with less of it must take it over.
    one = two_balls(lambda k: np.array([0.0, 0.0, max(0.155, 1.0 - 0.133 * k)]), frames=10)
    wrong = make_plan(two_balls(lambda k: np.array([0.0, 0.0, 1.0]), frames=10), CONFIG)
    states = {}
    solution = solve(one, CONFIG, plan=wrong, observe=lambda k, s: states.update({k: take(s)}) if k == 8 else None)
    stepper = make_stepper(one, CONFIG, wrong)
    assert len(stepper.contact.body.followed) < len(states[8].followed)
    restore(stepper, states[8])
    np.testing.assert_array_equal(stepper.contact.body.followed, states[8].followed)
    assert stepper.contact.face.max() < len(stepper.contact.body.faces)
    for frame in (9, 10):
        advance_frame(stepper, frame)
        np.testing.assert_array_equal(presentable(stepper), solution.x[frame])


def test_cloth_far_stiffer_than_fabrics_keeps_its_shorter_steps_whatever_is_planned() -> None:
    # Frames that aren't recorded get the longest steps.
    one = replace(two_balls(lambda k: np.array([1.0, 0.0, 0.0]), frames=16), record=16)
    (cloth,) = one.garments
    hard = replace(cloth.fabric, stretch_stiffness=1e6, shear_stiffness=3.75e5)
    soft, stiff = make_springs(one), make_springs(replace(one, garments=[replace(cloth, fabric=hard)]))
    assert careful(CONFIG, soft) is CONFIG
    assert careful(CONFIG, stiff).precision == "f64" and careful(CONFIG, stiff).dt == CONFIG.dt / STIFF_STEPS
    taken = [
        planned(replace(one, garments=[replace(cloth, fabric=fabric)]), ("steps",))[1].report.steps
        for fabric in (cloth.fabric, hard)
    ]
    assert taken[1] > 0.9 * STIFF_STEPS * taken[0]
