"""The report on outfits: its measures find what is wrong, and its page holds what it claims."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stages.outfit.kinds import TYPES
from stages.outfit.plan import CUTS, KINDS
from tests.stages.outfit.measures import ball, tube
from tools.outfit.measures import crossings, measure
from tools.outfit.quality import EDGE, summary
from tools.outfit.quality_cast import cast
from tools.outfit.quality_page import a_minute, page
from tools.outfit.quality_statics import statics
from tools.outfit.quality_trial import trial

REPORT = Path(__file__).parents[2] / "docs" / "outfit" / "quality.json"
BODY, BODY_FACES = ball(0.05)
POINTS, FACES = tube(0.1, 0.1, 0.01)


def faults(points: np.ndarray, faces: np.ndarray) -> list[str]:
    return measure(points, faces, 0.01, BODY, BODY_FACES).faults()


@pytest.fixture(scope="module")
def report() -> dict[str, Any]:
    return json.loads(REPORT.read_text())


def test_the_report_claims_what_was_asked(report: dict[str, Any]) -> None:
    said, trials, static = report["summary"], report["trials"], report["statics"]
    assert said["outfits"] == len(trials) >= 500 and report["edge_m"] == 0.01
    assert {(t["gender"], t["kind"]) for t in trials} == {(g, k) for g in ("female", "male") for k in KINDS}
    assert all(abs(beta) == 3.0 for t in trials for beta in t["betas"])
    assert said["rejected"] == sum("rejected" in t for t in trials) < 0.01 * len(trials)
    assert not [fault for t in trials for fault in t.get("faults", [])]
    garments = [garment for t in trials for garment in t.get("garments", {}).values()]
    assert all(g["manifold"] and g["oriented"] and g["components"] == 1 for g in garments)
    assert not any(g["self_crossings"] or g["body_crossings"] or g["inside"] for g in garments)
    assert not any(t.get("layer_crossings") for t in trials)
    assert all(g["shortest"] >= 0.5 and g["longest"] <= 2.0 and not g["short"] + g["long"] for g in garments)
    assert sum(g["sharp"] for g in garments) < 1e-3 * sum(g["faces"] for g in garments)
    assert said["mass_garments"] >= 18 and said["mass_spread_worst"] < 0.01
    assert said["seconds_mean"] < 1.5 and static["published"] >= 40 and a_minute(static) > 40
    assert static["memory_mb"] < 1000 and said["memory_mb"] < 1000


def test_the_report_saw_every_garment_and_cut(report: dict[str, Any]) -> None:
    garments = [item for t in report["trials"] for item in t.get("garments", {}).items()]
    assert {name for name, _ in garments} == set(TYPES)
    made = [cut for _, garment in garments for cut in garment["cuts"]]
    assert {cut: made.count(cut) > 10 for cut in CUTS} == dict.fromkeys(CUTS, True)


def test_the_page_says_what_the_figures_say(report: dict[str, Any]) -> None:
    assert REPORT.stat().st_size < 1e6
    assert REPORT.with_suffix(".md").read_text() == page(report)
    assert json.loads(json.dumps(summary(report["trials"], report["masses_kg"]))) == report["summary"]


def test_an_outfit_made_now_comes_out_as_in_the_report(report: dict[str, Any]) -> None:
    number = next(n for n, t in enumerate(report["trials"]) if t["kind"] == "top+skirt")
    now, then = json.loads(json.dumps(trial(cast(500)[number], EDGE))), report["trials"][number]
    assert now["faults"] == [] and now["betas"] == then["betas"]
    for name, garment in now["garments"].items():
        before = dict(then["garments"][name])
        assert garment.pop("cuts") == before.pop("cuts")
        assert garment == pytest.approx(before, rel=1e-4)


def test_static_people_are_timed_and_counted(tmp_path: Path) -> None:
    told = statics(1, tmp_path)
    assert (told["published"], told["rejected"]) == (1, 0)
    assert 0.5 < told["seconds"] < 60 and 50 < told["memory_mb"] < 1000


def test_a_clean_tube_has_no_fault() -> None:
    found = measure(POINTS, FACES, 0.01, BODY, BODY_FACES)
    assert found.faults() == []
    assert found.smallest_angle > 50
    assert found.mean_edge == pytest.approx(1.0, abs=0.02)
    assert found.body_distance == pytest.approx(0.05, abs=2e-3)


def test_each_fault_is_found() -> None:
    assert faults(POINTS, FACES[:, ::-1]) == ["not oriented"]
    turned = FACES.copy()
    turned[5] = turned[5, ::-1]
    assert "not oriented" in faults(POINTS, turned)
    assert "not manifold" in faults(POINTS, np.vstack([FACES, [[FACES[3, 0], FACES[3, 1], 300]]]))
    pinched = np.where(FACES == 20, 0, FACES)
    assert "not manifold" in faults(POINTS, pinched), "two vertices of its rim, far apart, are one"
    two = np.vstack([POINTS, POINTS + np.array([1, 0, 0])]), np.vstack([FACES, FACES + len(POINTS)])
    assert "more than one component" in faults(*two)
    folded = POINTS.copy()
    folded[POINTS[:, 2] > 0.05, 0] *= -1
    assert "passes through itself" in faults(folded, FACES)
    small = POINTS * [0.04 / 0.1, 0.04 / 0.1, 1]
    assert "meets the body" in faults(small, FACES)
    assert "vertices inside the body" in faults(POINTS * 0.1, FACES)
    assert "over 0.1 % of faces sharp" in faults(POINTS * [1, 1, 0.1], FACES)
    pulled = POINTS.copy()
    pulled[200] += [0.0, 0.0, 0.02]
    assert "edges out of 0.5-2 of the target" in faults(pulled, FACES)


def test_two_garments_that_meet_are_told() -> None:
    wider = POINTS * [1.1, 1.1, 1.0]
    assert crossings(POINTS, FACES, wider, FACES) == 0
    assert crossings(POINTS, FACES, wider + np.array([0.02, 0.0, 0.0]), FACES) > 10


def test_the_cast_takes_every_kind_gender_and_corner() -> None:
    members = cast(96)
    assert len({(m.gender, m.kind, m.betas[0], m.betas[1]) for m in members}) == 48
    assert {abs(b) for m in members for b in m.betas} == {3.0}
    assert members[:10] == cast(10)
