"""What a plan gains: the command finds it, and the table in docs/solver holds what is claimed of it."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tools.solver import meshes, plan, tables
from tools.solver.plan import EVERYTHING, FORCES, HALF, VARIANTS, WHOLE, WORN, without
from tools.solver.scenes import drop


def made():
    """The committed table; skips while it hasn't been made."""
    data = tables.read("plan")
    if data is None:
        pytest.skip("docs/solver/plan.json hasn't been made: make plan")
    return {name: {row["variant"]: row for row in scene["rows"]} for name, scene in data["scenes"].items()}, data


def test_the_command_measures_every_variant_and_writes_what_it_found(tmp_path, monkeypatch):
    small = drop(meshes.sheet(6, 0.03), frames=3)
    monkeypatch.setattr(plan, "build", lambda name, peers, quick: small)
    assert plan.main(["--quick", "--threads", "1", "--scenes", "dress", "--out", str(tmp_path)]) == 0
    data = tables.read("plan", tmp_path)
    rows = {row["variant"]: row for row in data["scenes"]["dress"]["rows"]}
    assert list(rows) == [*VARIANTS, FORCES[0], FORCES[2], HALF], "there are no elastics"
    assert rows[EVERYTHING]["gain"] == 1.0 and "gain" not in rows[HALF]
    assert rows["body faces"]["same_bits"] and not rows[HALF]["same_bits"]
    assert rows["body faces"]["left_out"].endswith("of the body's faces")
    assert rows[WHOLE]["steps"] == sum(data["scenes"]["dress"]["plan"]["steps"]["taken"])
    page = (tmp_path / "plan.md").read_text()
    assert sum(line.startswith("| ") for line in page.splitlines()) == len(rows) + 1
    assert (tmp_path / "plan.png").stat().st_size > 5000


def test_a_scene_without_a_force_is_else_the_same():
    scene = drop(meshes.sheet(6, 0.03))
    scene = replace(scene, garments=[replace(g, rest_scale=0.9 * g.rest_scale) for g in scene.garments])
    air, elastics, limit = (without(scene, force).garments[0] for force in FORCES)
    before = scene.garments[0]
    assert air.fabric == replace(before.fabric, drag=0.0)
    assert limit.fabric == replace(before.fabric, stiffening=1.0)
    np.testing.assert_array_equal(elastics.rest_scale, 1.0)
    assert elastics.fabric == before.fabric


def test_plans_gain_time_on_every_outfit():
    scenes, data = made()
    assert set(scenes) >= set(WORN) and data["made"]["rounds"] >= 3
    for name in WORN:
        assert scenes[name][WHOLE]["gain"] > 1.05, name
        assert scenes[name][WHOLE]["steps"] < scenes[name][EVERYTHING]["steps"], name


def test_what_plans_change_is_bounded_by_what_the_step_does():
    scenes, _ = made()
    for name, rows in scenes.items():
        if not rows["body faces"]["events"]:
            assert rows["body faces"]["same_bits"], name
        own = rows[HALF]["error_0.5s_mm"]
        assert rows["pairs of cloth"]["error_0.5s_mm"] <= own, name
        assert rows[WHOLE]["error_0.5s_mm"] <= 2.1 * own, name
        assert rows[WHOLE]["error_1s_mm"] <= 3 * rows[HALF]["error_1s_mm"], name
        assert max(row["depth_mm"] for label, row in rows.items() if label not in FORCES) <= 0.5, name


def test_leaving_out_the_air_would_gain_nothing():
    scenes, _ = made()
    assert np.median([rows["without air"]["gain"] for rows in scenes.values()]) < 1.05
