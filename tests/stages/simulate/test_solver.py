"""What a user sees of the solver: same bits, clear refusals, scene files, searches that miss nothing."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import igl
import numpy as np
import pytest
from small_scenes import PLAIN, ball, garment, scene, sheet, stepper

from stages.simulate.config import SimulateConfig
from stages.simulate.fabric import Fabric
from stages.simulate.quality import measure
from stages.simulate.scene_file import read_scene
from stages.simulate.solve import STARCH, SUPPLE, ease_in, solve
from stages.simulate.springs import Springs, unique_edges
from stages.simulate.wide_pcg import WidePcg
from stages.spec import DataError

DIGEST = """
import hashlib, sys
sys.path.insert(0, {here!r})
from dataclasses import replace
from small_scenes import PLAIN, ball, garment, scene, sheet
from stages.simulate.config import SimulateConfig
from stages.simulate.solve import STARCH, SUPPLE, ease_in, solve
v, f = sheet(30, 30, 0.01)
one = scene(garment(v, f, PLAIN), start=v + [-0.14, -0.14, 0.105], body=ball(0.1, 3), frames=3)
print(hashlib.sha256(solve(one, SimulateConfig(threads={threads})).x.tobytes()).hexdigest())
"""


def test_same_bits_at_any_number_of_threads() -> None:
    digests = []
    for threads in (1, 2):
        code = DIGEST.format(here=str(Path(__file__).parent), threads=threads)
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
        digests.append(run.stdout.split()[-1])
    assert digests[0] == digests[1]


def test_the_solve_for_gpus_is_that_of_the_cpu(monkeypatch: pytest.MonkeyPatch) -> None:
    # Two sheets fall on a ball: springs, bending, skin, pairs of cloth. Every system is solved both ways, to the end:
    # before it conjugate gradients go ways that depend on the last bit.
    vertices, faces = sheet(20, 20, 0.01)
    both = [garment(vertices, faces, PLAIN, name) for name in ("inner", "outer")]
    start = np.concatenate([vertices + np.array([-0.09, -0.09, z]) for z in (0.102, 0.105)])
    s = stepper(scene(*both, start=start, body=ball(0.1, 3), frames=6), tolerance=1e-9, precision="f64")
    wide, narrow, seen = WidePcg(s.pcg), s._solve, []

    def solve_twice() -> None:
        found = []
        for s.wide in (wide, None):
            narrow()
            found.append((s.pcg.dx.copy(), int(s.pcg.done[0])))
        assert found[0][1] == pytest.approx(found[1][1], rel=0.2, abs=2)
        assert np.abs(found[0][0] - found[1][0]).max() < 1e-3 * np.abs(found[1][0]).max()
        seen.append((found[1][1], s.pairs.count if s.pairs else 0, s.contact.touching))

    monkeypatch.setattr(s, "_solve", solve_twice)
    s.advance_to(0.1, s.config.dt)
    assert (np.max(seen, axis=0) > [8, 50, 10]).all(), "iterations beyond the first look, pairs of cloth, skin"


def test_a_gpu_that_is_not_there_is_told(tmp_path: Path) -> None:
    path = scene_file(tmp_path / "s.npz")
    done = subprocess.run(
        [sys.executable, "-m", "stages.simulate", "scene", path, "--out", tmp_path / "x.npz", "--device", "gpu"],
        capture_output=True,
        text=True,
    )
    if done.returncode == 0:
        cpu = tmp_path / "cpu.npz"
        subprocess.run([sys.executable, "-m", "stages.simulate", "scene", path, "--out", cpu], check=True)
        a, b = (np.load(file)["x"] for file in (tmp_path / "x.npz", cpu))
        assert np.abs(a - b).max() < 1e-4, "a GPU solves the same scene"
    else:
        assert done.returncode == 65 and "no GPU" in done.stderr and "Traceback" not in done.stderr


def test_nan_in_the_cloth_is_refused() -> None:
    vertices, faces = sheet(4, 4, 0.02)
    start = vertices.copy()
    start[5, 1] = np.nan
    with pytest.raises(DataError, match=r"shirt: start position of vertex 5 .* must be finite"):
        solve(scene(garment(vertices, faces, name="shirt"), start=start), SimulateConfig(threads=1))


def test_nan_in_the_body_is_refused_at_its_frame() -> None:
    vertices, faces = sheet(4, 4, 0.02)
    one = scene(
        garment(vertices, faces), body=ball(0.05, 1), frames=4, motion=lambda k: np.full(3, np.nan if k > 2 else 0.0)
    )
    with pytest.raises(DataError, match=r"body: frame 3, vertex 0 is not finite"):
        solve(one, SimulateConfig(threads=1, deepest_start=1.0))


def test_what_cannot_be_solved_ends_with_frame_vertex_and_cause() -> None:
    # A pin that jumps a kilometre: no step is short enough.
    vertices, faces = sheet(4, 4, 0.02)
    one = scene(garment(vertices, faces), pins=np.array([0]), frames=2)
    one = replace(one, pin_goal=lambda time: vertices[:1] + (1e3 if time > 0.01 else 0.0))
    with pytest.raises(DataError, match=r"simulation failed at frame 0 \(0\.0.* s\): vertex \d+ .*floor") as caught:
        solve(one, SimulateConfig(threads=1))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("constant", ["density", "stretch_stiffness"])
def test_impossible_fabric_is_refused(constant: str) -> None:
    with pytest.raises(DataError, match=rf"shirt: fabric constant {constant} must be finite and > 0, got -1.0"):
        Fabric.of({constant: -1.0}, "shirt")


def test_broken_meshes_are_refused() -> None:
    vertices, faces = sheet(3, 3, 0.02)
    same = vertices.copy()
    same[1] = same[0]
    for bad, message in (
        (garment(same, faces), "edge 0-1 is"),
        (garment(np.concatenate([vertices, [[1.0, 1, 1]]]), faces), "vertex 9 has no face"),
        (garment(vertices, np.concatenate([faces, [[0, 1, 8]], [[0, 1, 7]]])), "shared by"),
    ):
        with pytest.raises(DataError, match=message):
            stepper(scene(bad))


def test_cloth_starts_starched_and_is_supple_before_the_first_frame() -> None:
    vertices, faces = sheet(6, 6, 0.02)
    one = replace(scene(garment(vertices, faces, PLAIN), frames=30), record=20, ease_in=4)
    s = stepper(one)
    held = (s.springs.bend, s.springs.bend_sum, s.springs.edge_bend)
    own = [values.copy() for values in held]
    for frame, factor in ((0, STARCH), (7, STARCH**0.5), (20 - SUPPLE, 1.0), (20, 1.0)):
        ease_in(s, one, s.drag.copy(), frame)
        for values, unstarched in zip(held, own):
            assert values == pytest.approx(factor * unstarched, rel=1e-12)
        assert np.abs(s.bend - s.springs.bend).max() < 1e-3 * np.abs(s.springs.bend).max(), "what is solved with"
    # A scene that is recorded from its first frame on never is.
    ease_in(s, replace(one, record=0, ease_in=0), s.drag.copy(), 0)
    assert all((values == unstarched).all() for values, unstarched in zip(held, own))


def test_candidates_miss_no_triangle() -> None:
    vertices, faces = sheet(8, 8, 0.02)
    body, body_faces = ball(0.1, 3)
    s = stepper(scene(garment(vertices, faces), body=(body, body_faces)), deepest_start=1.0)
    x = np.random.default_rng(0).normal(size=(64, 3))
    x *= (0.1 + np.linspace(-0.005, 0.005, 64)[:, None]) / np.linalg.norm(x, axis=1, keepdims=True)
    s.contact.body.move_to(0.0, 1 / 240)
    s.contact.search(x, np.zeros((64, 3)), 1 / 240, x, 0.02)
    s.contact.locate(x)
    expected, _, closest = igl.signed_distance(x, body, body_faces.astype(np.int64))[:3]
    np.testing.assert_allclose(s.contact.distance, expected, atol=1e-12)
    mine = np.einsum("nk,nkc->nc", s.contact.bary, body[s.contact.body.faces[s.contact.face]])
    np.testing.assert_allclose(mine, closest, atol=1e-9)


def test_gather_lists_hold_every_spring_twice() -> None:
    vertices, faces = sheet(5, 4, 0.01)
    constants = {
        name: np.full(20, getattr(PLAIN, name))
        for name in ("density", "stretch_stiffness", "bend_stiffness", "stretch_limit", "stiffening", "damping")
    }
    s = Springs(vertices, faces, **constants)
    for i in range(20):
        rows = slice(s.start[i], s.start[i + 1])
        for j, e in zip(s.neighbour[rows], s.spring[rows]):
            assert sorted((i, j)) == list(s.edges[e])
    assert s.start[-1] == 2 * len(s.edges) == 2 * len(unique_edges(faces)[0])
    assert s.mass.sum() == pytest.approx(0.04 * 0.03 * PLAIN.density)


def test_measure_finds_what_is_wrong() -> None:
    body, body_faces = ball(0.1, 3)
    x = np.array([[[0.0, 0, 0.11], [0.01, 0, 0.11], [0, 0.01, 0.11]]] * 3)
    x[1, 0, 2] = 0.095
    edges = np.array([[0, 1], [0, 2]])
    figures = measure(x, edges, np.array([0.01, 0.008]), lambda k: body, body_faces)
    assert figures["max_penetration_m"] == pytest.approx(0.005, abs=2e-4)
    assert figures["share_over_10_percent"] == 1.0


def scene_file(path: Path) -> Path:
    """A small sheet held by two corners, as a scene file."""
    vertices, faces = sheet(5, 5, 0.02)
    np.savez(
        path, fps=30, frames=3, cloth_v=vertices, cloth_f=faces, body_v=np.zeros((0, 0, 3)),
        body_f=np.zeros((0, 3), int), pins=np.array([0, 4]), pin_pos=np.repeat(vertices[None, [0, 4]], 3, axis=0),
    )  # fmt: skip
    return path


def test_scene_file_program(tmp_path: Path) -> None:
    vertices, _ = sheet(5, 5, 0.02)
    scene_file(tmp_path / "s.npz")
    command = [sys.executable, "-m", "stages.simulate", "scene", str(tmp_path / "s.npz"), "--out", str(tmp_path / "o")]
    run = subprocess.run([*command[:-1], str(tmp_path / "o.npz")], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    line = json.loads(run.stdout.splitlines()[-1])
    assert line["steps"] == sum(line["plan"]["steps"]["taken"]) >= 6
    assert line["contacts"] == 0
    assert 50 < line["peak_memory_mb"] < 2000
    x = np.load(tmp_path / "o.npz")["x"]
    assert x.shape == (3, 25, 3)
    np.testing.assert_allclose(x[:, [0, 4]], vertices[[0, 4]][None].repeat(3, 0), atol=1e-6)
    assert x[-1, :, 2].min() < -0.01


def test_scene_file_that_lacks_arrays(tmp_path: Path) -> None:
    np.savez(tmp_path / "s.npz", fps=30)
    with pytest.raises(DataError, match=r"scene lacks .*cloth_f"):
        read_scene(tmp_path / "s.npz")
    (tmp_path / "t.npz").write_bytes(b"not a zip")
    with pytest.raises(DataError, match="not a readable"):
        read_scene(tmp_path / "t.npz")


def test_a_start_deep_inside_the_body_is_refused() -> None:
    vertices, faces = sheet(5, 5, 0.02)
    cloth = garment(vertices, faces, name="shirt")
    middle = vertices - vertices.mean(0)
    stepper(scene(cloth, start=middle + np.array([0, 0, 0.105]), body=ball(0.1, 3)))
    with pytest.raises(DataError, match=r"shirt: vertex \d+ starts \d+ mm inside the body, at most 10 mm"):
        stepper(scene(cloth, start=middle + np.array([0, 0, 0.05]), body=ball(0.1, 3)))


def test_cloth_that_starts_tangled_with_itself_is_refused() -> None:
    # A sheet folded over, every other row of its upper half pressed through the lower one.
    vertices, faces = sheet(21, 11, 0.01)
    folded = vertices.copy()
    over = vertices[:, 0] > 0.1
    folded[over, 0] = 0.2 - vertices[over, 0]
    row = np.round(vertices[:, 1] / 0.01).astype(int)
    folded[:, 2] = np.where(over, np.where(row % 2, 0.004, -0.004), 0.0)
    with pytest.raises(DataError, match="edges pass through their own garment at the start"):
        stepper(scene(garment(vertices, faces), start=folded))
    folded[:, 2] = np.where(over, 0.004, 0.0)
    stepper(scene(garment(vertices, faces), start=folded))
