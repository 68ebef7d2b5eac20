"""The order of tasks, and what becomes of those that wait for one that failed."""

import pytest

from pipeline.catalog import Catalog
from pipeline.execute.estimate import Estimate, clock
from pipeline.execute.schedule import Schedule
from pipeline.plan import PlannedTask


def _task(stage: str, item: str, *inputs: str, kind: str = "sequence") -> PlannedTask:
    names = tuple((name.split("/")[0], name.split("/")[1]) for name in inputs)
    return PlannedTask(stage, item, kind, "", 0, {}, names)


TASKS = [
    _task("yarn", "a"),
    _task("yarn", "b"),
    _task("yarn", "s", kind="static"),
    _task("weave", "a", "yarn/a"),
    _task("weave", "b", "yarn/b"),
    _task("bolt", "all", "weave/a", "weave/b", "yarn/s", kind="dataset"),
]


def _names(schedule: Schedule) -> list[str]:
    handed = []
    while (task := schedule.next()) is not None:
        handed.append(str(task))
    return handed


def test_sequences_go_first_and_deep_and_inputs_before_readers(catalog: Catalog) -> None:
    schedule = Schedule(catalog, TASKS)
    order = []
    while (task := schedule.next()) is not None:
        order.append(str(task))
        schedule.publish(task)
    assert order == ["yarn/a", "weave/a", "yarn/b", "weave/b", "yarn/s", "bolt/all"]
    assert not schedule.left and not schedule.stages_left


def test_what_reads_a_rejected_task_is_skipped(catalog: Catalog) -> None:
    schedule = Schedule(catalog, TASKS)
    first = schedule.next()
    assert first is not None
    schedule.reject(first, "bad yarn")
    assert _names(schedule) == ["yarn/b", "yarn/s"]
    assert schedule.skipped == {("weave", "a"): ("yarn", "a"), ("bolt", "all"): ("yarn", "a")}
    assert schedule.stages_left == {"yarn", "weave"}


def test_what_reads_a_lost_input_is_skipped(catalog: Catalog) -> None:
    schedule = Schedule(catalog, TASKS[3:], lost=[("yarn", "b")])
    assert _names(schedule) == ["weave/a"]
    assert set(schedule.skipped) == {("weave", "b"), ("bolt", "all")}


@pytest.mark.parametrize(("transient", "final", "tries"), [(False, False, 3), (True, False, 6), (False, True, 1)])
def test_failures_are_tried_again_a_few_times(catalog: Catalog, transient: bool, final: bool, tries: int) -> None:
    schedule = Schedule(catalog, TASKS[:1])
    count = 0
    while (task := schedule.next()) is not None:
        count += 1
        assert schedule.fail(task, "broke", transient=transient, final=final) == (count < tries)
    assert count == tries and schedule.failed == {("yarn", "a"): "broke"}


def test_time_left_counts_what_runs_and_says_when_it_cannot_know() -> None:
    estimate = Estimate()
    estimate.add("yarn", "sequence", 10.0)
    estimate.add("yarn", "sequence", 30.0)
    tasks = [_task("yarn", "a"), _task("yarn", "b"), _task("yarn", "c")]
    assert estimate.left(tasks, {"yarn/a": (10.0, 0.0)}, jobs=2) == "about 25 s left"
    assert estimate.left(tasks[:1], {"yarn/a": (30.0, 0.25)}, jobs=2) == "about 1 min 30 s left"
    assert estimate.left([*tasks, _task("weave", "a")], {}, jobs=2) == "at least 30 s left"
    assert estimate.left([_task("weave", "a")], {"weave/a": (30.0, 0.5)}, jobs=2) == "about 30 s left"
    assert estimate.left(tasks[:1], {}, jobs=2) == "about 20 s left"


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.04, "0.0 s"), (59.4, "59 s"), (65, "1 min 05 s"), (3599.7, "1 h 00 min"), (7800, "2 h 10 min")],
)
def test_spans_are_for_people(seconds: float, text: str) -> None:
    assert clock(seconds) == text
