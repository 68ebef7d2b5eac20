"""What is claimed of the solver in docs/solver/README.md, read from the tables there."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tools.solver import tables
from tools.solver.curve_points import SCENES as CURVE_SCENES
from tools.solver.extreme_cases import CASES
from tools.solver.peers import SCENES as PEER_SCENES


def made(name):
    """The data of a committed table; skips while it hasn't been made."""
    data = tables.read(name)
    if data is None:
        pytest.skip(f"docs/solver/{name}.json hasn't been made: make {name}")
    return data


def known_failures():
    """The cases that docs/solver/README.md names as failing."""
    section = (tables.DOCS / "README.md").read_text().split("## Known failures")[1].split("\n## ")[0]
    return {line.split("`")[1] for line in section.splitlines() if line.startswith("- `")}


def test_no_extreme_fails_but_those_named_and_none_is_missing():
    rows = {row["name"]: row for row in made("extremes")["cases"]}
    assert list(rows) == list(CASES)
    assert {name for name, row in rows.items() if row["outcome"] not in ("finite", "refused")} == known_failures()
    assert all(row["reason"] for row in rows.values() if row["outcome"] == "refused")
    assert sum(row["outcome"] == "refused" for row in rows.values()) <= len(rows) // 8


def test_every_extreme_stays_within_its_bounds():
    for row in made("extremes")["cases"]:
        if row["outcome"] == "finite":
            assert row["energy_gain_j"] <= row["energy_bound_j"], row["name"]
            assert row["max_speed"] <= row["speed_bound"], row["name"]
            assert (row["depth_end_mm"] or 0.0) <= 0.5, row["name"]


@pytest.mark.parametrize(("scene", "ratio"), [("A", 6.0), ("A20", 6.0), ("C", 6.0)])
def test_standard_beats_blender(scene, ratio):
    rows = {row["solver"]: row for row in made("peers")["rows"] if row["scene"] == scene}
    ours, theirs = rows["standard"], rows["Blender 14"]
    assert len(ours["ratios"]) >= 3 and ours["ratio"] >= ratio
    assert ours["penetration_mm_max"] == 0.0
    assert ours["self_intersections_max"] == 0
    assert ours["strain_p99"] <= theirs["strain_p99"] and ours["stretch_max"] <= theirs["stretch_max"]


def test_the_comparison_is_whole():
    rows = made("peers")["rows"]
    assert {row["scene"] for row in rows} == set(PEER_SCENES)
    assert not [row for row in rows if row.get("fault")]
    assert {row["solver"] for row in rows} >= {"standard", "Blender 14"}


def test_error_falls_with_the_level():
    scenes = made("curve")["scenes"]
    assert set(scenes) == set(CURVE_SCENES)
    for name, scene in scenes.items():
        rows = {row["point"]: row for row in scene["points"]}
        assert not [row["point"] for row in scene["points"] if "fault" in row], name
        # Half a second where a clip or a scene ends before one.
        key = "error_1s_mm" if "error_1s_mm" in rows["standard"] else "error_0.5s_mm"
        # On C any difference grows tenfold within the second: its levels are told apart by less than their scatter.
        scatter = 1.1 if name == "C" else 1.0
        assert rows["fine"][key] < rows["standard"][key] < scatter * rows["preview"][key], name
        assert rows["standard"]["wall_s_per_simulated_s"] < rows["reference"]["wall_s_per_simulated_s"], name


def test_faster_than_blender_at_its_own_error():
    rows = {row["solver"]: row for row in made("peers")["rows"] if row["scene"] == "A"}
    ours, theirs = rows["fine"], rows["Blender 14"]
    assert len(ours["ratios"]) >= 3 and ours["ratio"] >= 3.0
    for key in ("error_0.5s_mm", "error_1s_mm"):
        assert ours[key] <= theirs[key]


@pytest.mark.parametrize(("name", "ratio"), [("A", 3.0), ("A-free", 2.0), ("B64", 2.0)])
def test_fine_has_less_error_than_blender_in_less_time(name, ratio):
    scene = made("curve")["scenes"][name]
    rows = {row["point"]: row for row in scene["points"] + scene["blender"]}
    ours, theirs = rows["fine"], rows["Blender, 14 steps"]
    assert ours["error_0.5s_mm"] < theirs["error_0.5s_mm"]
    assert ours["error_1s_mm"] < theirs["error_1s_mm"]
    assert theirs["wall_s_per_simulated_s"] > ratio * ours["wall_s_per_simulated_s"]


def test_fabrics_drape_alike_on_every_mesh():
    rows = made("fabrics")["rows"]
    assert {row["fabric"] for row in rows} == {"cotton", "silk", "denim", "leather"}
    assert {row["edge_mm"] for row in rows} == {5.0, 10.0, 14.0, 20.0}
    for row in rows:
        assert abs(row["over_10_mm"] - 1.0) < 0.03, (row["fabric"], row["edge_mm"])
        assert row["bending_length_mm"] == pytest.approx(row["bending_length_theory_mm"], rel=0.03)


def test_no_table_says_where_something_lies_on_the_machine_that_made_it():
    for path in tables.DOCS.parent.rglob("*.json"):
        assert '"/' not in path.read_text(), path.name


def test_pages_show_the_same_rows_as_the_data():
    for name, key in (("extremes", "cases"), ("peers", "rows"), ("fabrics", "rows")):
        data = tables.read(name)
        if data is not None:
            page = (tables.DOCS / f"{name}.md").read_text()
            rows = [line for line in page.splitlines() if line.startswith("| ") and "---" not in line]
            assert len(rows) == len(data[key]) + 1
            assert data["made"]["commit"] in page
