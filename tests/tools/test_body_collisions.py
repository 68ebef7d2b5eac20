"""The report on self-collision: what it claims, and that it still comes out so on a small run."""

import json
from pathlib import Path
from typing import Any

import pytest

from tools.body.collision_album import Album
from tools.body.collision_cast import cast
from tools.body.collision_text import text
from tools.body.collision_trial import summary, trial

REPORT = Path(__file__).parents[2] / "docs" / "body" / "collisions.json"


@pytest.fixture(scope="module")
def report() -> dict[str, Any]:
    return json.loads(REPORT.read_text())


def test_the_report_claims_what_was_asked(report: dict[str, Any]) -> None:
    said, trials = report["summary"], report["trials"]
    assert said["sequences"] == len(trials) >= 40 and said["tested_frames"] >= 600
    assert sum(abs(b) == 3 for t in trials for b in t["betas"]) >= 200, "shapes at the corners"
    assert said["crossings_before"] > 10_000 and said["crossings_after"] == 0
    for t in trials:
        assert not any(t.get("crossings_after", {}).values()), t["name"]
    assert said["cases"].get("rejected", 0) <= 4 and said["cases"]["solved"] >= 30
    assert said["opening_ms_per_frame"] + said["parting_ms_per_frame"] < 20
    assert said["jerk_growth_median"] < 1.05 and said["jerk_growth_worst"] < 1.5 and said["jerk_largest_growth"] < 2.5
    assert max(max(t.get("pair_moved_mm", {"": 0}).values()) for t in trials) <= 50.05


def test_the_page_says_what_the_figures_say(report: dict[str, Any]) -> None:
    assert REPORT.with_suffix(".md").read_text() == text(report)
    assert json.loads(json.dumps(summary(report["trials"]))) == report["summary"]


def test_a_small_run_comes_out_alike(tmp_path: Path) -> None:
    member, album = cast(tmp_path, 1)[0], Album()
    told = trial(member, 12, 6, album)
    assert told["case"] == "solved" and told["frames"] == 12 and told["tested_frames"] == 2
    assert sum(told["crossings_before"].values()) > 5 and not any(told["crossings_after"].values())
    assert told["parting_ms_per_frame"] > 0 and told["opening_ms_per_frame"] > 0
    album.save(tmp_path / "folds.png")
    assert (tmp_path / "folds.png").stat().st_size > 10_000
