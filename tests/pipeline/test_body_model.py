"""A recipe that names a body model: made with it, keyed by its content, and refused in planning if it is none."""

from pathlib import Path

import igl
import numpy as np
import pytest

import store
from model.body import REST_POSE, load_free_body
from pipeline.cli import main
from stages.body.config import Config
from stages.body_model import load_body_model
from tests.model.body.smpl_files import as_python2, human_model, with_chumpy

RECIPE = """
[dataset]
name = "foreign"
seed = 4
statics = 2
outfits = ["jumpsuit"]

[dataset.body_models]
female = "{path}"

[[dataset.sequence]]
id = "stroll"
gender = "female"
motion = "walk"
frames = 5

[body]
shape_range = [-1.0, 1.0]
"""


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    """A recipe whose women have the body of `tmp_path/SMPL_FEMALE.pkl`, which isn't there yet."""
    path = tmp_path / "recipe.toml"
    path.write_text(RECIPE.format(path=tmp_path / "SMPL_FEMALE.pkl"))
    return path


def run(recipe: Path, *options: str) -> int:
    """The exit code of the command line."""
    return main([options[0], str(recipe), "--output", str(recipe.parent / "out"), *options[1:]])


def test_bodies_are_made_of_the_file(recipe: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made = human_model()
    file, out = recipe.parent / "SMPL_FEMALE.pkl", recipe.parent / "out"
    file.write_bytes(with_chumpy(made | {"J_regressor": made["J_regressor"].toarray()}))
    assert run(recipe, "run", "--until", "body") == 0
    shard = store.read(out / "body" / "stroll.h5", "body")
    body = load_body_model(shard.attrs)
    assert shard.attrs["body_model"] == str(file) and body.vertex_count == 6890 and body.posedirs is not None
    np.testing.assert_array_equal(shard["faces"], made["f"])
    posed = body.pose(shard["betas"], shard["pose"], np.zeros((5, 3)))
    apart = np.linalg.norm(shard["vertices"] - posed, axis=2)
    assert np.median(apart) < 1e-4 and apart.max() < Config().largest_move, "as posed, but for skin that was parted"
    # The same person in the same motion with the free body, which this one is but for its vertices and correctives.
    free = load_free_body("female").pose(shard["betas"], shard["pose"], shard["trans"])
    assert abs(np.ptp(posed[..., 2]) - np.ptp(free[..., 2])) < 0.01
    assert (posed + shard["trans"][:, None])[..., 2].min() == pytest.approx(0.0, abs=0.005), "feet on the ground"
    man = store.read_header(out / "body" / "static_00001.h5", "body")
    assert man.attrs["gender"] == "male" and "body_model" not in man.attrs
    capsys.readouterr()
    assert run(recipe, "run", "--until", "body") == 0
    assert capsys.readouterr().out.startswith("nothing to do: 3 tasks up to date")
    # Elsewhere, the same file makes the same; another file makes everything anew.
    moved = recipe.parent / "elsewhere" / file.name
    moved.parent.mkdir()
    moved.write_bytes(file.read_bytes())
    recipe.write_text(RECIPE.format(path=moved))
    assert run(recipe, "run", "--until", "body") == 0
    assert capsys.readouterr().out.startswith("nothing to do: 3 tasks up to date")
    moved.write_bytes(as_python2(made | {"v_template": 1.01 * made["v_template"]}))
    assert run(recipe, "status", "--until", "body", "--why") == 0
    said = capsys.readouterr().out
    assert "SMPL_FEMALE.pkl" in said or "body_model" in said, said
    # It is dressed as the free body is; what is too unlike it is refused in one line, not dressed badly.
    moved.write_bytes(file.read_bytes())
    assert run(recipe, "run", "--until", "outfit", "--only", "stroll") == 0, capsys.readouterr()
    outfit = store.read(out / "outfit" / "stroll.h5", "outfit")
    skin = body.pose(outfit["tight_betas"], REST_POSE[None], np.zeros((1, 3)))[0].astype(np.float64)
    worn = [outfit[f"garments/{name}/vertices"] for name in outfit.attrs["layers"]]
    cloth = np.concatenate(worn).astype(np.float64)
    distance = np.sqrt(igl.point_mesh_squared_distance(cloth, skin, body.faces.astype(np.int64))[0])
    assert distance.min() > 0.0025 and np.median(distance) < 0.06
    capsys.readouterr()
    rucksack = made["v_template"].copy()
    rucksack[(rucksack[:, 2] < -0.03) & (np.hypot(rucksack[:, 0], rucksack[:, 1] - 0.35) < 0.12), 2] -= 0.25
    moved.write_bytes(as_python2(made | {"v_template": rucksack}))
    assert run(recipe, "run", "--until", "outfit", "--only", "stroll") == 1
    said = " ".join(capsys.readouterr())
    assert "SMPL_FEMALE.pkl: cannot be dressed: the free body's skin laid onto this one misses it" in said, said


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "SMPL_FEMALE.pkl: No such file or directory; name a body model's file"),
        (b"cos\nsystem\n(S'true'\ntR.", "the pickle asks for 'os.system'"),
        (b"<html>", "neither a pickle nor an npz archive"),
    ],
)
def test_what_is_no_body_model_is_refused_in_planning(
    content: bytes | None, message: str, recipe: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if content is not None:
        (recipe.parent / "SMPL_FEMALE.pkl").write_bytes(content)
    assert run(recipe, "run", "--until", "body") == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "[dataset] body_models.female: " in error and message in error, error
    assert not (recipe.parent / "out" / "body").exists()


def test_a_gender_that_there_is_not(recipe: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recipe.write_text(RECIPE.format(path="x").replace("female =", "femail ="))
    assert run(recipe, "status") == 1
    assert "body_models: unknown key 'femail'; did you mean 'female'?" in capsys.readouterr().err
