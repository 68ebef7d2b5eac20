"""Own garments and fabrics in a recipe: planned with their content, worn, and refused before anything is made."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import store
from pipeline.catalog import load_catalog
from pipeline.cli import _load, _parser, main
from pipeline.dataset import OUTFITS, Dataset
from pipeline.items import collect
from pipeline.motion import MotionFiles
from pipeline.plan import make_plan
from tests.stages.outfit.own.garments import kilt, write_kilt

RECIPE = """
[dataset]
name = "own"
seed = 4
statics = 2
outfits = ["kilt", "dress"]
test_share = 0.0
{more}

[[dataset.garment]]
name = "kilt"
file = "{folder}/kilt.obj"
type = "skirt"
gender = "female"
{garment}

[body]
shape_range = [-1.0, 1.0]

[outfit]
edge_length = 0.014
{outfit}
"""

FELT = """
[felt]
density = 0.3
thickness = 2e-3
stretch_stiffness = 300
shear_stiffness = 100
bend_stiffness = 2e-4
damping = 3e-3
friction = 0.7
"""


def recipe(folder: Path, more: str = "", garment: str = "", outfit: str = "") -> Path:
    """A recipe with a kilt of one's own."""
    path = folder / "recipe.toml"
    path.write_text(RECIPE.format(folder=folder, more=more, garment=garment, outfit=outfit))
    return path


def run(path: Path, *options: str) -> int:
    """The exit code of the command line."""
    return main([options[0], str(path), "--output", str(path.parent / "out"), *options[1:]])


def keys(path: Path) -> dict[str, str]:
    """Keys of the tasks of the stage outfit."""
    catalog = load_catalog()
    loaded, items = _load(_parser().parse_args(["run", str(path), "--output", str(path.parent / "out")]), catalog)
    plan = make_plan(loaded, catalog, items)
    return {task.item: task.key for task in plan.tasks.values() if task.stage == "outfit"}


def test_a_recipe_with_a_garment_and_a_fabric_of_ones_own_is_made(tmp_path: Path) -> None:
    write_kilt(tmp_path, unit="cm", up="y")
    (tmp_path / "mine.toml").write_text(FELT)
    path = recipe(
        tmp_path,
        more=f'fabrics = "{tmp_path}/mine.toml"',
        garment='unit = "cm"\nup = "y"\nfabrics = ["felt"]\nelastics = { hem = 0.9 }',
        outfit="[outfit.fabrics]\ndress = ['felt']",
    )
    assert run(path, "run", "--until", "encode") == 0
    out = tmp_path / "out"
    shard = store.read(out / "outfit" / "static_00000.h5", "outfit")
    assert shard.attrs["layers"] == ["kilt"]
    told = shard.attrs["garments"]["kilt"]
    assert told["type"] == "skirt" and told["fabric"]["name"] == "felt" and told["fabric"]["density"] == 0.3
    assert told["own"]["unit"] == "cm" and told["own"]["file"] == "kilt.obj" and len(told["own"]["sha256"]) == 64
    assert told["seed"] == shard.attrs["seed"]
    np.testing.assert_array_equal(shard["garments/kilt/faces"], kilt()[1])
    dress = store.read(out / "outfit" / "static_00001.h5", "outfit").attrs["garments"]["dress"]
    assert dress["fabric"]["name"] == "felt" and "own" not in dress
    found = store.read(out / "register" / "static_00000.h5", "register").attrs["garments"]["kilt"]
    assert found["topology"] == "skirt" and found["coverage"] > 0.95 and found["error_mean_m"] < 0.003
    assert (
        store.read(out / "encode" / "static_00000.h5", "encode").attrs["garments"]["kilt"]["fabric"]["name"] == "felt"
    )


def test_keys_follow_content_and_settings_not_folders(tmp_path: Path) -> None:
    write_kilt(tmp_path)
    path = recipe(tmp_path)
    first = keys(path)
    moved = tmp_path / "moved"
    moved.mkdir()
    write_kilt(moved)
    assert keys(recipe(moved)) == first
    with (tmp_path / "kilt.obj").open("a") as file:
        file.write("# mended\n")
    changed = keys(path)
    assert changed["static_00000"] != first["static_00000"]
    assert changed["static_00001"] == first["static_00001"], "who does not wear it is left alone"
    assert keys(recipe(tmp_path, garment="waistband = false"))["static_00000"] != changed["static_00000"]
    (tmp_path / "mine.toml").write_text(FELT)
    felt = keys(recipe(tmp_path, more=f'fabrics = "{tmp_path}/mine.toml"'))
    assert all(felt[item] != changed[item] for item in felt)
    (tmp_path / "mine.toml").write_text(FELT.replace("0.3", "0.4"))
    again = keys(recipe(tmp_path, more=f'fabrics = "{tmp_path}/mine.toml"'))
    assert all(felt[item] != again[item] for item in felt)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"garment": 'unit = "cm"'}, "garment 'kilt': {folder}/kilt.obj: does not lie on the female body: with unit"),
        ({"garment": 'type = "kilt"'}, "not valid TOML"),
        ({"garment": 'up = "x"'}, "garment: up must be one of z, y, got 'x'"),
        ({"garment": 'fabrics = ["felt"]'}, "garment 'kilt': fabrics has 'felt', which is no fabric; known: cotton, "),
        ({"garment": "elastics = { hems = 0.9 }"}, "has no border 'hems' for an elastic; did you mean 'hem'?"),
        ({"outfit": 'lower_fabrics = ["lether"]'}, "[outfit]: lower_fabrics has 'lether', which is no fabric; did"),
        ({"outfit": "fabrics = { skrit = ['silk'] }"}, "fabrics: there is no garment 'skrit'; did you mean 'skirt'?"),
        ({"outfit": "fabrics = { skirt = [] }"}, "fabrics.skirt must name at least one fabric, got none"),
        ({"outfit": "fabrics = { skirt = 'silk' }"}, "fabrics must be"),
        ({"outfit": "leg_length = [0.9, 0.4]"}, "leg_length must run from low to high, got [0.9, 0.4]"),
        ({"more": 'fabrics = "none.toml"'}, "/none.toml': No such file or directory; name an existing TOML file"),
        ({"more": 'fabrics = "{folder}/bad.toml"'}, "/bad.toml [felt]: density must be from 0.005 to 5 kg/m^2"),
        ({"more": "[[dataset.sequence]]\nid='a'\ngender='male'\nmotion='walk'\noutfit='kitl'"}, "did you mean 'kilt'?"),
        ({"more": "[[dataset.garment]]\nname='kilt'\nfile='b.obj'\ntype='top'\ngender='male'"}, "'kilt' stands there "),
    ],
)  # fmt: skip
def test_what_cannot_be_worn_is_refused_before_anything_is_made(
    tmp_path: Path, changes: dict[str, str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write_kilt(tmp_path)
    (tmp_path / "bad.toml").write_text(FELT.replace("0.3", "-0.3"))
    changes = {name: text.replace("{folder}", str(tmp_path)) for name, text in changes.items()}
    assert run(recipe(tmp_path, **changes), "status") == 1
    said = capsys.readouterr().err
    assert message.replace("{folder}", str(tmp_path)) in said and said.count("\n") == 1, said
    assert not (tmp_path / "out" / "outfit").exists()


def test_a_garment_that_is_not_there_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(recipe(tmp_path), "status") == 1
    said = capsys.readouterr().err
    assert said.endswith("kilt.obj: No such file or directory; name an existing OBJ file\n")


def test_statics_balance_kinds_and_genders(tmp_path: Path) -> None:
    """CLOTH3D, section 3: two women to one man, the kinds of outfit alike often for each."""
    dataset = Dataset(name="d", statics=2000, female_share=2 / 3)
    items = collect(dataset, "", MotionFiles(tmp_path / "motions.json"))
    counts = Counter((item.params["gender"], item.params["outfit"]) for item in items)
    assert len(counts) == 2 * len(OUTFITS)
    for (gender, _), count in counts.items():
        assert count == pytest.approx(2000 / len(OUTFITS) * (2 / 3 if gender == "female" else 1 / 3), abs=1.01)
    test = Counter(item.params["outfit"] for item in items if item.params["split"] == "test")
    assert all(400 / 6 - 30 < test[kind] < 400 / 6 + 30 for kind in OUTFITS)


def test_drawn_sequences_balance_kinds_and_genders(tmp_path: Path) -> None:
    from scipy import stats

    head = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 3 Zrotation Yrotation Xrotation\n}\nMOTION\n"
    (tmp_path / "a.bvh").write_text(head + "Frames: 300\nFrame Time: 0.0333333\n" + "0 0 0\n" * 300)
    dataset = Dataset(name="d", motions=str(tmp_path), sequences=2000, frames=30, female_share=2 / 3)
    items = collect(dataset, "", MotionFiles(tmp_path / "motions.json"))
    women = sum(item.params["gender"] == "female" for item in items)
    assert stats.binomtest(women, 2000, 2 / 3).pvalue > 1e-4
    counts = Counter((item.params["gender"], item.params["outfit"]) for item in items)
    shares = {"female": 2 / 3, "male": 1 / 3}
    expected = {(g, kind): 2000 / len(OUTFITS) * share for g, share in shares.items() for kind in OUTFITS}
    assert set(counts) == set(expected)
    assert stats.chisquare([counts[c] for c in expected], list(expected.values())).pvalue > 1e-4
