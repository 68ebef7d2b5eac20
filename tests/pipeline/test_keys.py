"""Keys: they change if, and only if, something that the result depends on does; and the reason is named."""

import copy
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeline.reason import first_difference
from stages.key import key_document, key_of
from stages.spec import StageSpec

SPEC = StageSpec(name="weave", needs=("yarn",), config=dict, code_version=1, schema="body")
SETTINGS = st.dictionaries(
    st.sampled_from("abc"),
    st.one_of(st.integers(), st.floats(allow_nan=False, allow_infinity=False), st.text(), st.none()),
)
KEYS = st.text("0123456789abcdef", min_size=4, max_size=4)
TASKS = st.fixed_dictionaries(
    {
        "config": SETTINGS,
        "params": SETTINGS,
        "inputs": st.dictionaries(st.sampled_from(["yarn", "dye"]), st.dictionaries(st.text("xy", min_size=1), KEYS)),
        "item": st.text("xy", min_size=1, max_size=3),
        "seed": st.integers(0, 2**64 - 1),
    }
)


def _document(task: dict[str, Any], spec: StageSpec = SPEC) -> dict[str, Any]:
    return key_document(spec, **copy.deepcopy(task))


# A busy machine may be slow to draw.
@settings(suppress_health_check=[HealthCheck.too_slow])
@given(TASKS, TASKS)
def test_a_key_changes_if_and_only_if_the_task_does(one: dict[str, Any], other: dict[str, Any]) -> None:
    same = _canonical(one) == _canonical(other)
    assert (key_of(_document(one)) == key_of(_document(other))) == same
    assert bool(first_difference(_document(one), _document(other))) == (not same)


def _canonical(task: dict[str, Any]) -> str:
    """Text that tells 1 from 1.0 and 0.0 from -0.0, as JSON does."""
    return repr({name: _sorted(value) for name, value in sorted(task.items())})


def _sorted(value: Any) -> Any:
    return sorted((name, _sorted(v)) for name, v in value.items()) if isinstance(value, dict) else value


@given(TASKS)
def test_order_does_not_count(task: dict[str, Any]) -> None:
    turned = {name: dict(reversed(v.items())) if isinstance(v, dict) else v for name, v in reversed(task.items())}
    assert key_of(_document(task)) == key_of(_document(turned))


@pytest.mark.parametrize("change", [{"code_version": 2}, {"schema": "outfit"}, {"name": "knit"}])
@given(task=TASKS)
def test_code_and_schema_count(change: dict[str, Any], task: dict[str, Any]) -> None:
    assert key_of(_document(task)) != key_of(_document(task, replace(SPEC, **change)))


def test_a_file_counts_by_name_and_content_and_not_by_folder() -> None:
    task = {"config": {}, "inputs": {}, "item": "x", "seed": 0}
    here = _document({**task, "params": {"motion": "/here/walk.bvh", "motion_sha256": "aa"}})
    assert key_of(here) == key_of(_document({**task, "params": {"motion": "there/walk.bvh", "motion_sha256": "aa"}}))
    assert key_of(here) != key_of(_document({**task, "params": {"motion": "/here/walk.bvh", "motion_sha256": "bb"}}))
    assert here["params"]["motion"] == "walk.bvh"


OLD = {
    "stage": "simulate",
    "code_version": 1,
    "schema": "simulate v1",
    "config": {"dt": 0.01667, "solver": {"steps": 5}},
    "params": {"motion": "walk"},
    "item": "walk_03",
    "seed": 5,
    "inputs": {"body": {"walk_03": "aa"}},
}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({}, ""),
        ({"config": {"dt": 0.01, "solver": {"steps": 5}}}, "config.dt 0.01667 -> 0.01"),
        ({"config": {"dt": 0.01667, "solver": {"steps": 6}}}, "config.solver.steps 5 -> 6"),
        ({"config": {"dt": 0.01667}}, 'config.solver {"steps": 5} -> none'),
        ({"code_version": 2, "config": {}}, "code_version 1 -> 2"),
        ({"schema": "simulate v2"}, 'schema "simulate v1" -> "simulate v2"'),
        ({"params": {"motion": "run"}, "seed": 6}, 'params.motion "walk" -> "run"'),
        ({"inputs": {"body": {"walk_03": "bb"}}}, "input body/walk_03 was made anew"),
        ({"inputs": {"body": {"walk_03": "aa", "run": "cc"}}}, "input body/run is new"),
        ({"inputs": {"body": {}}}, "input body/walk_03 is gone"),
        ({"inputs": {}}, "input body is gone"),
    ],
)
def test_the_reason_names_the_first_field_that_differs(change: dict[str, Any], reason: str) -> None:
    assert first_difference(OLD, {**OLD, **change}) == reason
