"""The twenty sequences: what is claimed of them in docs/solver/sequences.json, and that what goes wrong is seen."""

import argparse
import json
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from pipeline.catalog import load_catalog
from pipeline.dataset import OUTFITS
from pipeline.recipe import load_recipe
from stages.receipt import PUBLISHED, REJECTED, Receipt
from tools.solver import meshes, sequences, tables
from tools.solver.child import Ended
from tools.solver.sequences_audit import Body, Cloth, audit, faults, lasting
from tools.solver.sequences_cast import cast, clips, shapes
from tools.solver.sequences_scene import labels

FRAMES, FPS, AROUND = 30, 30.0, 20


@pytest.fixture(scope="module")
def table():
    """The committed table; skips while it hasn't been made."""
    data = tables.read("sequences")
    if data is None:
        pytest.skip("docs/solver/sequences.json hasn't been made: make sequences MOTION=FOLDER")
    return data


def test_the_table_is_whole(table):
    rows = table["rows"]
    assert len(rows) == 20 and table["made"]["accuracy"] == "standard"
    assert {row["outfit"] for row in rows} == set(OUTFITS)
    assert {row["gender"] for row in rows} == {"female", "male"}
    assert len({row["motion"] for row in rows}) >= 12 and sum(row["frames"] == 300 for row in rows) >= 5
    page = (tables.DOCS / "sequences.md").read_text()
    assert table["made"]["commit"] in page and all(row["name"] in page for row in rows)


def test_no_sequence_has_a_fault(table):
    for row in table["rows"]:
        assert not row["fault"] and row["crossing_lasts"] <= 10, row["name"]


def test_every_sequence_is_within_its_other_bars(table):
    for row in table["rows"]:
        assert row["depth_mm"] <= 0.5 and row["slip_mm"] <= 100, row["name"]
        assert row["lag"] is None or row["lag"] >= 0.25, row["name"]
        assert row["wildness"] <= 2.5 and row["peak_memory_mb"] < 2000 and row["s_per_frame"] > 0, row["name"]


def tube(radius, low, high):
    """A tube about z with its rings 3 cm apart, and its faces."""
    around, levels = AROUND, round((high - low) / 0.03) + 1
    angle = np.arange(around) * 2 * np.pi / around
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], 1)
    heights = np.linspace(low, high, levels)
    vertices = np.concatenate([np.column_stack([ring, np.full(around, z)]) for z in heights])
    k, i = np.divmod(np.arange(around * (levels - 1)), around)
    a, b = k * around + i, k * around + (i + 1) % around
    return vertices, np.concatenate([np.stack([a, b, b + around], 1), np.stack([a, b + around, a + around], 1)])


@pytest.fixture(scope="module")
def dressed():
    """A capsule that walks along y at 1 m/s, in a tube that hangs 1 cm off it and goes with it."""
    skin, skin_faces = meshes.capsule(0.1, 0.6, 24)
    cloth, faces = tube(0.11, -0.3, 0.3)
    way = np.zeros((FRAMES, 1, 3))
    way[:, 0, 1] = np.arange(FRAMES) / FPS
    up = np.array([0.0, 0.0, 1.0])
    body = Body(x=skin + way, faces=skin_faces.astype(np.int64), rest=skin, up=np.tile(up, (FRAMES, 1)), up_rest=up)
    worn = Cloth(x=cloth + way, faces=faces.astype(np.int64), rest=cloth, held=np.zeros(len(cloth), bool))
    return worn, body


def judged(dressed, spoil):
    """Figures and faults of the walk, its cloth's positions changed by `spoil`."""
    worn, body = dressed
    x = worn.x.copy()
    spoil(x)
    figures = audit({"tube": replace(worn, x=x)}, body, FPS)
    return figures, "; ".join(faults(figures))


def test_a_good_walk_has_no_fault(dressed):
    figures, fault = judged(dressed, lambda x: None)
    assert fault == ""
    assert figures["depth_mm"] == 0 and figures["crossings_most"] == 0 and figures["slip_mm"] == 0
    assert figures["lag"] == 1.0 and figures["speed"] == pytest.approx(1.0) and figures["stretch_max"] == 0.0


def penetrate(x):
    x[7, 100, :2] += (0.0986 - 0.11) * x[0, 100, :2] / 0.11


def cross(x, frames):
    # Part of a ring is lifted past those above, in and out by turns: its faces pass through theirs.
    part = slice(AROUND * 7, AROUND * 7 + 6)
    x[:frames, part, 2] += 0.08
    x[:frames, part, 1] -= np.arange(frames)[:, None] / FPS
    x[:frames, part, :2] *= np.array([0.97, 1.03] * 3)[:, None]
    x[:frames, part, 1] += np.arange(frames)[:, None] / FPS


def fall(x):
    x[10:, :, 2] -= np.linspace(0, 0.15, FRAMES - 10)[:, None]


def fall_on_one_side(x):
    left = x[0, :, 0] < 0
    x[10:, left, 2] -= np.linspace(0, 0.15, FRAMES - 10)[:, None]


def freeze(x):
    x[10:] = x[10]


def explode(x):
    x[20, 5, 2] += 0.3


@pytest.mark.parametrize(
    ("spoil", "fault"),
    [
        (penetrate, "mm inside the body in frame 7"),
        (lambda x: cross(x, 15), "a crossing lasts 15 frames, until 14"),
        (fall, "fallen by 150 mm in frame 29"),
        (fall_on_one_side, "fallen by 150 mm in frame 29"),
        (freeze, "frozen"),
        (explode, "exploded"),
        (lambda x: x.__setitem__((3, 3, 0), np.nan), "not finite"),
    ],
)
def test_what_goes_wrong_is_seen(dressed, spoil, fault):
    assert fault in judged(dressed, spoil)[1]


def test_depth_is_exact_and_short_crossings_pass(dressed):
    figures, _ = judged(dressed, penetrate)
    # The capsule is of flat faces, up to 0.9 % of the radius below the circle.
    assert 0.5 <= figures["depth_mm"] <= 1.4
    figures, fault = judged(dressed, lambda x: cross(x, 5))
    assert figures["crossed_frames"] == 5 and figures["crossing_lasts"] == 5 and "crossing" not in fault


def test_a_place_lasts_while_its_vertex_is_crossed():
    frames = [np.array(v, np.int64) for v in ([1, 2], [2, 3], [3, 4], [], [4], [4, 2], [4], [4], [0])]
    assert lasting(frames, 5) == (4, 7)
    assert lasting([np.zeros(0, np.int64)] * 3, 5) == (0, 0)


BVH = """HIERARCHY
ROOT Hips
{{
 OFFSET 0 0 0
 CHANNELS 3 Xposition Yposition Zposition
 End Site
 {{
  OFFSET 0 1 0
 }}
}}
MOTION
Frames: {frames}
Frame Time: 0.0333333
"""


@pytest.fixture(scope="module")
def motion(tmp_path_factory):
    """A folder of three kinds of motion, one of them long."""
    folder = tmp_path_factory.mktemp("motion")
    for name, frames in {"walk_1": 50, "walk_2": 90, "run": 40, "dance_a_1": 250}.items():
        (folder / f"{name}.bvh").write_text(BVH.format(frames=frames) + "0 0 0\n" * frames)
    return folder


def test_every_kind_of_motion_comes_in_turn(motion):
    assert [(clip.name, clip.frames) for clip in clips(motion, 100)] == [
        ("dance_a_1", 100), ("run", 40), ("walk_2", 90), ("dance_a_1_from100", 100), ("walk_1", 50),
        ("dance_a_1_from200", 50),
    ]  # fmt: skip


def test_the_cast_has_everything_and_its_recipes_can_be_read(motion, tmp_path):
    members = [takes[0] for takes in cast(motion, 20, 100)]
    assert len({m.name for m in members}) == 20
    assert {(m.outfit, m.gender) for m in members} == {(o, g) for o in OUTFITS for g in ("female", "male")}
    assert {m.lower for m in members} == {"cotton", "silk", "denim", "leather"}
    assert {m.tightness for m in members} == {(-1.5, -1.5), (0.5, 0.5), (-1.5, 0.5)}
    assert len({m.betas for m in members}) == 20 and max(max(m.betas) for m in members) == 3
    assert len(set(shapes())) == len(shapes()) and not any(np.abs(betas).min() > 2 for betas in shapes())
    (tmp_path / "r.toml").write_text(members[6].recipe("preview", 1))
    recipe = load_recipe(tmp_path / "r.toml", load_catalog())
    entry = recipe.dataset.sequence[0]
    assert (entry.id, entry.frames, Path(entry.motion)) == (
        members[6].name,
        members[6].clip.frames,
        members[6].clip.path,
    )
    assert recipe.sections["body"].betas == members[6].betas
    assert recipe.sections["simulate"].accuracy == "preview"
    assert tomllib.loads(members[6].recipe("preview", 1))["outfit"]["tightness_range"] == list(members[6].tightness)


def test_who_is_rejected_is_replaced(motion):
    takes = cast(motion, 3, 100)[1]
    assert [(np.sign(m.betas).sum(), m.clip.name) for m in takes[:2]] == [(1, "run"), (-1, "run")]
    assert [m.clip.name for m in takes[2:]] == ["dance_a_1_from100", "walk_1", "dance_a_1_from200"]
    assert takes[2].betas == takes[0].betas
    assert cast(motion, 3, 100)[2][2].clip.name == "walk_1"
    assert len({m.name for m in takes}) == len(takes)


def receipt(stage, status=PUBLISHED, **about):
    return Receipt(stage=stage, item="i", key="k", status=status, document={}, **about)


GOOD = {"finite": True, "depth_mm": 0.0, "crossing_lasts": 0, "slip_mm": 3, "lag": 0.9, "wildness": 0.8,
        "depth_frame": 0, "crossing_until": 0, "slip_frame": 2}  # fmt: skip


@pytest.fixture
def stand_in(monkeypatch):
    """Puts receipts and figures in place of making and judging; what was drawn is noted."""

    def put(said, figures=GOOD, make=lambda *_: ""):
        drawn = []
        monkeypatch.setattr(sequences, "_make", make)
        monkeypatch.setattr(sequences, "receipts", lambda output, item: said(item))
        monkeypatch.setattr(sequences, "_judge", lambda *_: dict(figures))
        monkeypatch.setattr(sequences, "_draw", lambda member, output, seen, film: drawn.append((member.name, film)))
        return drawn

    return put


def published(item, memory=700.0):
    figures = {"steps": 100, "halvings": 1, "unsolved": 0, "peak_memory_mb": memory}
    return {"body": receipt("body"), "simulate": receipt("simulate", wall_s=80.0, peak_bytes=10**8, figures=figures)}


def test_rows_are_timed_and_a_rejected_person_gives_way(motion, tmp_path, stand_in, capsys):
    def said(item):
        if item.startswith("02") and "opposite" not in item:
            return {"body": receipt("body", REJECTED, cause="an arm and the trunk")}
        return published(item)

    drawn = stand_in(said)
    arguments = ["--motion", str(motion), "--count", "3", "--frames", "100", "--films", "1"]
    assert sequences.main([*arguments, "--work", str(tmp_path)]) == 0
    rows = tables.read("sequences", tmp_path)["rows"]
    assert [row["s_per_frame"] for row in rows] == [0.8, 2.0, pytest.approx(0.889)]
    assert rows[0]["peak_memory_mb"] == 700 and rows[0]["steps"] == 100
    assert rows[1]["name"].endswith("_opposite") and "an arm and the trunk" in rows[1]["rejected"]
    assert [film for _, film in drawn] == [True, False, False]
    assert "1.04 s each" in (tmp_path / "sequences.md").read_text()
    assert capsys.readouterr().out.count(" s per frame") == 3


def test_faults_are_told_and_do_not_stop_the_rest(motion, tmp_path, stand_in, capsys):
    def make(member, output, given):
        if member.name.startswith("02"):
            raise OSError("no space")
        return "exit code 1: Killed" if member.name.startswith("01") else ""

    def said(item):
        return {"body": receipt("body")} if item.startswith("01") else published(item, memory=2500.0)

    drawn = stand_in(said, {**GOOD, "depth_mm": 3.0}, make)
    arguments = ["--motion", str(motion), "--count", "3", "--frames", "100", "--films", "0", "--work", str(tmp_path)]
    assert sequences.main(arguments) == 1
    rows = tables.read("sequences", tmp_path)["rows"]
    assert rows[0]["fault"] == "exit code 1: Killed" and rows[1]["fault"] == "OSError: no space"
    assert "3.00 mm inside the body" in rows[2]["fault"] and "2500 MB" in rows[2]["fault"]
    assert [film for _, film in drawn] == [True]
    assert "3 of 3 have a fault" in (tmp_path / "sequences.md").read_text()
    assert "FAULT: exit code 1" in capsys.readouterr().out


def test_another_solver_makes_sequences_anew(motion, tmp_path, monkeypatch):
    ran = []
    monkeypatch.setattr(sequences, "run", lambda command, limit: ran.append(command[3]) or Ended(0, {}, "", 1.0, 1.0))
    member, given = cast(motion, 1, 100)[0][0], argparse.Namespace(accuracy="preview", threads=1)
    sequences._make(member, tmp_path / "one", given)
    sequences._make(member, tmp_path / "one", given)
    assert ran == ["run", "run"]
    monkeypatch.setattr(sequences, "sources", lambda: "other")
    sequences._make(member, tmp_path / "one", given)
    assert ran == ["run", "run", "clean", "run"]


def test_an_audit_is_kept_until_the_shard_changes(dressed, motion, tmp_path, monkeypatch):
    member = cast(motion, 1, 100)[0][0]
    output = tmp_path / member.name
    output.mkdir()
    (output / "solver.txt").write_text("s")
    worn, body = dressed
    looks = []
    who = argparse.Namespace(body={"fps": FPS})
    monkeypatch.setattr(sequences, "person", lambda *_: looks.append(1) or (who, {"tube": worn}, body))
    first = sequences._judge(member, output, "key")
    assert first == sequences._judge(member, output, "key") == json.loads(json.dumps(first)) and len(looks) == 1
    sequences._judge(member, output, "other key")
    assert len(looks) == 2


def test_the_sheet_shows_the_worst_frames():
    words = labels(50, {**GOOD, "depth_mm": 0.4, "depth_frame": 9, "crossings_frame": 0, "crossings_most": 2})
    assert len(words) == 10 and words[9] == "9: deepest 0.4 mm" and words[0] == "0: 2 crossings"
    assert len(labels(50, {**GOOD, "slip_mm": 0})) == 8


def test_a_missing_folder_is_answered_with_what_to_do(tmp_path, capsys):
    for folder in (tmp_path / "none", tmp_path):
        with pytest.raises(SystemExit):
            sequences.main(["--motion", str(folder)])
        assert "name a folder of BVH files" in capsys.readouterr().err
