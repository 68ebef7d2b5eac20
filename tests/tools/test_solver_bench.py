"""The commands that measure the solver: they see what is wrong, and their tables hold what they found."""

import json
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from stages.simulate import springs
from stages.simulate.make_stepper import make_springs, make_stepper
from stages.spec import DataError
from tools.solver import curve, extremes, extremes_plot, judging, kept, meshes, peers, tables
from tools.solver.child import Ended, run
from tools.solver.curve_plot import plot
from tools.solver.energy import EnergyMeter
from tools.solver.extreme_cases import CASES, Case
from tools.solver.judging import judge
from tools.solver.scenes import drop, fabric, hang
from tools.solver.statistics import errors, silhouettes, statistics

SMALL = Case(name="small", group="size", build=partial(drop, meshes.sheet(6, 0.03), frames=3), still=True)


def area(mesh):
    corners = mesh[0][mesh[1]]
    return 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (meshes.sheet(5, 0.02), 0.08**2),
        (meshes.needles(6, 0.02, 0.01), 0.1 * (3 * 0.02 + 2 * 0.0002)),
        (meshes.caps(12, 0.02, 0.01), 0.22**2),
        (meshes.graded(0.002, 0.04, 0.3), np.pi * 0.3**2),
    ],
)
def test_flat_meshes_cover_their_area_once_face_up(mesh, expected):
    normal = area(mesh)
    assert normal[:, 2].min() > 0
    assert normal[:, 2].sum() == pytest.approx(expected, rel=0.15)
    edges = np.sort(mesh[1][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), 1)
    assert np.unique(edges, axis=0, return_counts=True)[1].max() == 2
    assert len(np.unique(mesh[1])) == len(mesh[0])


def test_slivers_are_slivers_and_grades_are_graded():
    for mesh in (meshes.needles(6, 0.02, 0.01), meshes.caps(12, 0.02, 0.01)):
        sides = np.linalg.norm(mesh[0][mesh[1]] - mesh[0][np.roll(mesh[1], 1, 1)], axis=2)
        assert (2 * area(mesh)[:, 2] / sides.max(1) ** 2).min() < 0.02
    vertices, faces = meshes.graded(0.002, 0.04, 0.3)
    sides = np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, 1)], axis=2)
    assert sides.max() / sides.min() > 15


@pytest.mark.parametrize("length", [0.0, 0.4])
def test_capsule_is_closed_and_faces_outward(length):
    vertices, faces = meshes.capsule(0.1, length, 32)
    volume = np.einsum("fc,fc->", vertices[faces].mean(1), area((vertices, faces))) / 3
    assert volume == pytest.approx(np.pi * 0.01 * length + 4 / 3 * np.pi * 0.001, rel=0.03)
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), 1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}


def test_energies_are_those_of_closed_form():
    scene = hang(meshes.sheet(25, 0.005))
    springs = make_springs(scene)
    energy = EnergyMeter(scene, springs, -9.81)
    mass, x, still = springs.mass.sum(), scene.start.copy(), np.zeros((625, 3))
    assert mass == pytest.approx(0.12**2 * fabric().density)
    moved = energy(x + np.array([0, 0, 0.5]), still + np.array([3.0, 0, 4.0]))
    assert moved.height == pytest.approx(mass * 9.81 * 0.5)
    assert moved.kinetic == pytest.approx(12.5 * mass)
    assert energy(x, still).stretch == pytest.approx(0.0, abs=1e-15)
    # All edges 1 % longer, below the limit where the cloth stiffens: k/2 (0.01 l)^2 each.
    expected = (0.5 * springs.stiffness * (0.01 * springs.rest_length) ** 2).sum()
    assert energy(1.01 * x, still).stretch == pytest.approx(expected, rel=1e-6)
    # A gentle cylinder of radius R holds B A / (2 R^2).
    rolled = np.column_stack([0.5 * np.sin(x[:, 0] / 0.5), x[:, 1], 0.5 * np.cos(x[:, 0] / 0.5)])
    assert energy(rolled, still).bending == pytest.approx(fabric().bend_stiffness * 0.12**2 / (2 * 0.25), rel=0.3)


def test_a_good_case_is_finite():
    verdict = judge(SMALL, threads=1)
    assert verdict.outcome == "finite" and not verdict.reason
    assert verdict.steps >= 3 and verdict.vertices == 36
    assert 0.5 < verdict.max_speed < verdict.speed_bound
    assert verdict.crossings_end == 0 and verdict.depth_worst_mm == 0.0


@pytest.mark.parametrize("name", ["needles 1:100, falls on a ball", "pins jump 0.2 m in a frame"])
def test_cases_that_hung_on_a_trace_are_finite_by_far(name, monkeypatch):
    # Steps that weren't solved let needles gain energy, and cloth that was jerked passed through itself in one step:
    # each in some runs, which differed by a trace of bending, and not in others.
    monkeypatch.setattr(springs, "COARSE", 0.77)
    verdict = judge(CASES[name], threads=1)
    assert verdict.outcome == "finite", verdict.reason
    assert verdict.energy_gain_j < 0.8 * verdict.energy_bound_j and verdict.crossings_end == 0


def fold_through_itself(stepper):
    """Lay half of the sheet onto the other half, tilted, so that the two cross along a line."""
    half = stepper.x[:18]
    half[:, 0] = 0.007 - half[:, 0]
    half[:, 2] += 0.3 * (half[:, 1] - half[:, 1].mean() + 0.002)


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (lambda s: s.v.__setitem__((0, 2), np.nan), "not finite"),
        (lambda s: s.v.__imul__(3.0), "energy grew"),
        (lambda s: s.x.__setitem__((slice(None), 2), 0.1), "inside the body"),
        (lambda s: s.v.__setitem__((0, 0), 500.0), "cloth reached 500.0 m/s"),
        (fold_through_itself, "crossings of its own"),
    ],
)
def test_what_goes_wrong_is_seen(spoil, fault, monkeypatch):
    def solve(scene, config, observe):
        stepper = make_stepper(scene, config)
        observe(0, stepper)
        stepper.v[:, 2] = -1.0
        stepper.x[:, 2] -= 1e-3
        spoil(stepper)
        x = np.stack([scene.start, stepper.x])
        observe(1, stepper)
        return type("Solution", (), {"x": x, "report": stepper.report})

    monkeypatch.setattr(judging, "solve", solve)
    heavy = replace(SMALL, push=1.5) if "500" in fault else SMALL
    verdict = judge(heavy, threads=1)
    assert verdict.outcome == "FAILED" and fault in verdict.reason


@pytest.mark.parametrize(("steps", "outcome"), [(0, "refused"), (3, "FAILED")])
def test_a_refusal_counts_only_before_the_first_step(steps, outcome, monkeypatch):
    def solve(scene, config, observe):
        stepper = make_stepper(scene, config)
        observe(0, stepper)
        stepper.report.steps = steps
        raise DataError("edge 0-1 is too short")

    monkeypatch.setattr(judging, "solve", solve)
    verdict = judge(SMALL, threads=1)
    assert verdict.outcome == outcome and "edge 0-1 is too short" in verdict.reason


def test_cases_that_never_end_or_crash_are_seen(monkeypatch):
    endless = run([sys.executable, "-c", "while True: pass"], 0.5)
    assert endless.code is None and "still running" in endless.fault and endless.wall_s < 5
    crash = run(
        [sys.executable, "-c", "import os, sys; print('{}'); print('last words', file=sys.stderr); os.abort()"], 10
    )
    assert crash.fault == "exit code -6: last words"
    good = run([sys.executable, "-c", "x = bytearray(10**8); print('chatter'); print('{\"a\": 1}')"], 10)
    assert good.line == {"a": 1} and good.fault == "" and good.peak_mb > 100
    monkeypatch.setattr(extremes, "run", lambda command, limit: endless)
    row = extremes._solve(SMALL, 1, "1/1")
    assert row["outcome"] == "FAILED" and "still running" in row["reason"]


def test_the_matrix_is_run_and_its_table_read_back(tmp_path, capsys):
    assert extremes.main(["--only", "1 triangle", "--out", str(tmp_path), "--threads", "1"]) in (0, 1)
    assert capsys.readouterr().out.startswith("1/1 1 triangle: ")
    data = tables.read("extremes", tmp_path)
    assert [row["name"] for row in data["cases"]] == ["1 triangle"]
    assert data["cases"][0]["vertices"] == 3 and data["cases"][0]["wall_s"] > 0
    assert "| size | 1 triangle |" in (tmp_path / "extremes.md").read_text()
    assert (tmp_path / "extremes.png").stat().st_size > 5000
    failed = {"name": "a", "outcome": "FAILED"}, {"name": "b", "outcome": "refused"}
    extremes_plot.plot(failed, tmp_path / "failed.png")
    assert (tmp_path / "failed.png").stat().st_size > 5000
    with pytest.raises(SystemExit):
        extremes.main(["--only", "no such case"])


def test_the_matrix_holds_every_extreme_of_the_issue():
    text = "\n".join(CASES)
    for needed in ("stiffness x 0.001", "stiffness x 10000", "density x 0.01", "density x 100", "1/30 s", "1/2000 s",
                   "2 mm", "50 mm", "2 to 40 mm", "needles", "caps", "15 m/s", "frozen", "jumps", "inside", "crossed",
                   "zero gravity", "friction 0", "friction 5", "1 triangle", "200 k", "1 frame", "3,000 frames",
                   "betas -3 -3", "betas +3 +3", "tightness -1.5", "tightness +0.5",
                   "preview", "reference"):  # fmt: skip
        assert needed in text


def test_errors_are_root_mean_squares_in_millimetres():
    x = np.zeros((31, 4, 3))
    y = x.copy()
    y[10:, :, 0] = 0.003
    found = errors(y, x, 30.0)
    assert found["error_at_0.5s_mm"] == pytest.approx(3.0)
    assert found["error_0.5s_mm"] == pytest.approx(3.0 * (6 / 16) ** 0.5)
    assert found["error_1s_mm"] == pytest.approx(3.0 * (21 / 31) ** 0.5)
    assert "error_1s_mm" not in errors(y[:20], x, 30.0)


def test_statistics_of_a_sheet_that_flies_and_stretches():
    vertices, faces = meshes.sheet(11, 0.02)
    x = np.stack([vertices * [1 + 0.01 * k, 1, 1] + [0, 0, 0.1 * k] for k in range(4)])
    found = statistics(x, vertices, faces, 30.0, 2)
    assert found["strain_max"] == pytest.approx(0.03)
    assert found["kinetic_j_per_kg"] == pytest.approx(4.5, rel=0.01)
    assert found["curvature"] == pytest.approx(0.0, abs=1e-6)
    assert silhouettes(vertices, faces) == pytest.approx(0.2**2, rel=0.25)
    bent = np.column_stack([0.3 * np.sin(vertices[:, 0] / 0.3), vertices[:, 1], 0.3 * np.cos(vertices[:, 0] / 0.3)])
    assert statistics(np.stack([bent, bent]), vertices, faces, 30.0, 1)["curvature"] == pytest.approx(1 / 0.3, rel=0.15)


def write_scene(path):
    vertices, faces = meshes.sheet(6, 0.03)
    body, body_faces = meshes.capsule(0.1, 0.0, 12)
    np.savez(path, fps=30, frames=4, cloth_v=vertices + np.array([0.01, 0, 0.11]), cloth_f=faces, body_v=body[None],
             body_f=body_faces, pins=np.zeros(0, int), pin_pos=np.zeros((4, 0, 3)))  # fmt: skip


BLENDER = """
import json, numpy as np, sys
scene = np.load(sys.argv[1])
np.savez(sys.argv[2], x=np.repeat(scene["cloth_v"][None], 4, 0), t=np.ones(3))
print(json.dumps({"wall_s_per_simulated_s": 50.0}))
"""
SCORE = """
import json, numpy as np, sys
x = np.load(sys.argv[2])["x"]
print(json.dumps({"finite": bool(np.isfinite(x).all()), "strain_p99": 0.01, "penetration_mm_max": 0.0}))
"""


def peers_folder(path):
    """A folder like the peers', with a small scene and stand-ins for Blender and for the scorer."""
    (path / "scenes").mkdir(parents=True)
    write_scene(path / "scenes" / "S.npz")
    (path / "run_blender.py").write_text(BLENDER)
    (path / "measure.py").write_text(SCORE)
    return path


def ended(seconds, fault=""):
    """A run that took `seconds` per simulated second, or failed."""
    return Ended(1 if fault else 0, {} if fault else {"wall_s_per_simulated_s": seconds}, fault, 100.0, seconds)


def test_solver_and_blender_are_run_and_scored(tmp_path):
    folder = peers_folder(tmp_path / "peers")
    before = [{"scene": "S", "solver": "standard", "wall": 1e6}, {"scene": "old", "solver": "standard"}]
    tables.write("peers", {"made": {"commit": "abc"}, "rows": before}, "", tmp_path)
    code = peers.main(["--peers", str(folder), "--blender", sys.executable, "--scenes", "S", "--runs", "1",
                       "--errors", "", "--work", str(tmp_path / "work"), "--out", str(tmp_path)])  # fmt: skip
    assert code == 0
    ours, theirs, old = tables.read("peers", tmp_path)["rows"]
    assert old == {"scene": "old", "solver": "standard", "commit": "abc"}, "what wasn't measured again stays"
    assert (ours["solver"], theirs["solver"]) == ("standard", "Blender 14")
    assert ours["finite"] and ours["steps"] > 4 and ours["peak_memory_mb"] > 50
    assert ours["ratio"] == pytest.approx(50.0 / ours["wall"])
    assert "| S | standard |" in (tmp_path / "peers.md").read_text()


def test_rounds_take_turns_and_one_failure_does_not_stop_the_rest(tmp_path, monkeypatch):
    folder = peers_folder(tmp_path / "peers")
    (folder / "scenes" / "broken.npz").write_bytes(b"no zip")
    turns = []

    def ours(bench, name, level):
        turns.append((name, level))
        return ended(0.0, "unreadable") if name == "broken" else ended(len(turns))

    def theirs(bench, name, quality):
        turns.append((name, quality))
        return ended(100.0)

    monkeypatch.setattr(peers.Bench, "ours", ours)
    monkeypatch.setattr(peers.Bench, "theirs", theirs)
    monkeypatch.setattr(peers.Bench, "score", lambda *_: {"finite": True})
    code = peers.main(["--peers", str(folder), "--blender", sys.executable, "--scenes", "broken,S", "--runs", "3",
                       "--errors", "", "--work", str(tmp_path / "work"), "--out", str(tmp_path)])  # fmt: skip
    assert code == 1
    assert turns == [(name, what) for name in ("broken", "S") for _ in range(3) for what in (14, "standard")]
    rows = {(row["scene"], row["solver"]): row for row in tables.read("peers", tmp_path)["rows"]}
    assert rows["broken", "standard"]["fault"].count("unreadable") == 3
    # Rounds of S took 8, 10 and 12 s, Blender's 100 s.
    assert rows["S", "standard"]["wall"] == 10 and rows["S", "standard"]["ratio"] == pytest.approx(10.0)
    assert rows["S", "standard"]["range"] == "8 to 12"


def test_own_errors_are_against_the_solvers_own_reference(tmp_path, monkeypatch):
    folder = peers_folder(tmp_path / "peers")
    places = {
        "preview": 0.004,
        "standard": 0.002,
        "fine": 0.001,
        "reference": 0.0,
        "Blender 14": 0.105,
        "Blender 56": 0.1,
    }

    def put(bench, name, solver, most=0):
        np.savez(bench.out(name, solver), x=np.full((16, 3, 3), places[solver] / 3**0.5))
        return ended(1.0)

    monkeypatch.setattr(peers.Bench, "ours", put)
    monkeypatch.setattr(
        peers.Bench, "theirs", lambda bench, name, quality, most=0: put(bench, name, f"Blender {quality}")
    )
    monkeypatch.setattr(peers.Bench, "score", lambda *_: {"finite": True})
    bench = peers.Bench(peers.Blender(Path(sys.executable), folder), tmp_path, 0)
    rows = {row["solver"]: row.get("error_0.5s_mm") for row in peers.measure(bench, "S", 1, True)}
    assert rows["preview"] == pytest.approx(4.0) and rows["standard"] == pytest.approx(2.0)
    assert rows["fine"] == pytest.approx(1.0)
    assert rows["Blender 14"] == pytest.approx(5.0)
    assert rows["reference"] is None and rows["Blender 56"] is None


def test_missing_peers_are_answered_with_what_to_do(tmp_path, capsys):
    with pytest.raises(SystemExit):
        peers.main(["--peers", str(tmp_path)])
    assert "name the peers' folder: PEERS=" in capsys.readouterr().err


def test_the_curve_is_measured_once_and_kept(tmp_path, monkeypatch, capsys):
    folder = peers_folder(tmp_path / "peers")
    (folder / "scenes" / "B64.npz").write_bytes((folder / "scenes" / "S.npz").read_bytes())
    arguments = ["--peers", str(folder), "--blender", sys.executable, "--quick", "--scenes", "B64", "--frames", "3",
                 "--work", str(tmp_path / "work"), "--out", str(tmp_path / "out"), "--threads", "1"]  # fmt: skip

    def solved(command, limit):
        name, point, file = command[command.index("--point") + 1 :][:3]
        return Ended(0, curve.measure(name, point, folder, 3, 1, Path(file)), "", 100.0, 1.0)

    monkeypatch.setattr(curve, "QUICK", ("preview", "standard"))
    monkeypatch.setattr(curve, "run", solved)
    assert curve.main(arguments) == 0
    assert capsys.readouterr().out.count("B64, ") == 4
    assert curve.main(arguments) == 0
    assert "B64, " not in capsys.readouterr().out
    data = tables.read("curve", tmp_path / "out")["scenes"]["B64"]
    assert [row["point"] for row in data["points"]] == ["preview", "standard"]
    assert data["points"][1]["relative"]["silhouette_m2"] == 1.0
    assert (tmp_path / "out" / "curve.png").read_bytes()[:4] == b"\x89PNG"
    assert "**standard**" in (tmp_path / "out" / "curve.md").read_text()
    # A scene that is measured by itself leaves the others' rows, and their commit, as they are.
    before = tables.read("curve", tmp_path / "out")
    old = {"made": before["made"] | {"commit": "older"}, "scenes": {"A": before["scenes"]["B64"]}}
    del old["scenes"]["A"]["made"]
    tables.write("curve", old, "", tmp_path / "out")
    assert curve.main(arguments) == 0
    after = tables.read("curve", tmp_path / "out")["scenes"]
    assert after["A"]["made"]["commit"] == "older" and after["A"]["points"] == data["points"]
    assert after["B64"] == before["scenes"]["B64"] | {"made": after["B64"]["made"]}
    assert "Commit older" in (tmp_path / "out" / "curve.md").read_text()


def test_a_changed_solver_is_measured_anew(tmp_path, monkeypatch):
    work = curve.Work(tmp_path, None, 0, 1)
    before = work.place("A", {"sources": curve.sources(), "settings": {}})
    assert before == work.place("A", {"sources": curve.sources(), "settings": {}})
    assert before != work.place("A", {"sources": curve.sources(), "settings": {"dt": 0.01}})
    (tmp_path / "stages" / "simulate").mkdir(parents=True)
    (tmp_path / "stages" / "simulate" / "config.py").write_text("other")
    monkeypatch.setattr(kept, "ROOT", tmp_path)
    assert before != work.place("A", {"sources": curve.sources(), "settings": {}})


def test_a_reference_is_kept_while_nothing_changes(tmp_path):
    out, runs = tmp_path / "r.npz", []

    def solve():
        runs.append(1)
        out.write_bytes(b"x")
        return ended(2.0, "no memory" if len(runs) == 1 else "")

    assert kept.once(out, "a", solve).fault and len(runs) == 1
    first = kept.once(out, "a", solve)
    assert kept.once(out, "a", solve) == first and len(runs) == 2, "a failed run isn't kept, a good one is"
    kept.once(out, "b", solve)
    assert len(runs) == 3
    out.unlink()
    kept.once(out, "b", solve)
    assert len(runs) == 4


def test_the_plot_takes_scenes_without_errors(tmp_path):
    rows = [{"point": "standard", "wall_s_per_simulated_s": 2.0, "error_1s_mm": 3.0}, {"point": "x", "fault": "no"}]
    plot({"A": {"title": "A", "points": rows, "blender": rows[:1]}, "B": {"title": "B", "points": [], "blender": []}},
         ("standard",), tmp_path / "p.png")  # fmt: skip
    assert (tmp_path / "p.png").stat().st_size > 1000


def test_tables_leave_empty_what_is_missing():
    text = tables.table({"a": "A", "b": "B"}, [{"a": 1.23456, "b": None}, {"a": True, "b": "x|y"}])
    assert text.splitlines()[2:] == ["| 1.23 |  |", "| yes | x\\|y |"]
    assert json.dumps(tables.made())
