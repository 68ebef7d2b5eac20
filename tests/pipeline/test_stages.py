"""The real stages as the runner sees them: light to import, and every recipe of the repository plans on them."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.catalog import Catalog, load_catalog
from pipeline.cli import main
from pipeline.dataset import Dataset
from pipeline.items import collect
from pipeline.motion import MotionFiles
from pipeline.plan import make_plan
from pipeline.recipe import Recipe, load_recipe
from stages import settings
from stages.key import document_of, key_of
from stages.spec import STAGE_NAMES, Task

ROOT = Path(__file__).parents[2]
HEAVY = ("torch", "taichi", "numpy", "scipy", "igl", "h5py", "trimesh", "matplotlib")


@pytest.fixture(scope="module")
def real() -> Catalog:
    """The mill's own stages."""
    return load_catalog()


def test_the_packages_are_this_repositorys() -> None:
    code = "import model, pipeline, stages, store; print(*[p.__file__ for p in (model, pipeline, stages, store)])"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert all(Path(path).is_relative_to(ROOT) for path in ended.stdout.split())


def test_planning_imports_nothing_heavy() -> None:
    code = "import sys; from pipeline.catalog import load_catalog; load_catalog(); print(*sys.modules)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not set(HEAVY) & set(ended.stdout.split())


def test_every_stage_is_there(real: Catalog) -> None:
    assert tuple(real.specs) == STAGE_NAMES


@pytest.mark.parametrize("name", ["demo", "tiny", "cloth3d"])
def test_recipes_fit_the_stages(real: Catalog, name: str) -> None:
    recipe = load_recipe(ROOT / "recipes" / f"{name}.toml", real)
    for stage, section in recipe.sections.items():
        again = settings.build(real[stage].config, json.loads(json.dumps(recipe.plain_section(stage))))
        assert again == section


def test_a_tasks_file_gives_back_its_key(real: Catalog, tmp_path: Path) -> None:
    """What a worker computes from its file is what the plan asked for."""
    recipe = load_recipe(ROOT / "recipes" / "demo.toml", real, tmp_path)
    plan = make_plan(recipe, real, collect(recipe.dataset, "", MotionFiles(tmp_path / "motions.json")))
    assert len(plan.tasks) == 63 * 4 + 3 + 2  # body, outfit, register, encode; simulate; train, report
    for task in plan.tasks.values():
        again = Task.from_json(plan.to_task(task).to_json())
        assert key_of(document_of(real[task.stage], again)) == task.key


def test_the_papers_dataset_has_its_numbers(real: Catalog, tmp_path: Path) -> None:
    """CLOTH3D, Section 3: 7,000 sequences of up to 300 frames, two women to one man, split 80/20 by sequence."""
    recipe = load_recipe(ROOT / "recipes" / "cloth3d.toml", real)
    clips = tmp_path / "motion"
    clips.mkdir()
    head = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 3 Zrotation Yrotation Xrotation\n}\nMOTION\n"
    for number in range(20):
        frames = 100 + 97 * number
        (clips / f"{number}.bvh").write_text(head + f"Frames: {frames}\nFrame Time: 0.0333333\n" + "0 0 0\n" * frames)
    given = settings.plain(recipe.dataset) | {"motions": str(clips)}
    items = collect(settings.build(Dataset, given), "", MotionFiles(tmp_path / "motions.json"))
    sequences = [item.params for item in items if item.kind == "sequence"]
    statics = [item.params for item in items if item.kind == "static"]
    assert (len(sequences), len(statics)) == (7000, 30000)
    assert max(params["frames"] for params in sequences) == 300
    for group in (sequences, statics):
        assert sum(p["gender"] == "female" for p in group) / len(group) == pytest.approx(2 / 3, abs=0.02)
        assert sum(p["split"] == "test" for p in group) / len(group) == 0.2
    plan = make_plan(Recipe(recipe.path, recipe.dataset, recipe.sections, tmp_path), real, items[:3])
    assert plan.tasks


def test_bad_input_ends_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recipe = tmp_path / "demo.toml"
    text = (ROOT / "recipes" / "demo.toml").read_text()
    for bad, message in (
        (text + "\n[simulat]\ndt = 1\n", "demo.toml: unknown section [simulat]; did you mean 'simulate'?\n"),
        (
            text + "\n[simulate]\nthicknes = 1\n",
            "demo.toml [simulate]: unknown key 'thicknes'; did you mean 'thickness'?\n",
        ),
        (text + "\n[simulate]\ndt = -1\n", "demo.toml [simulate]: dt must be > 0"),
    ):
        recipe.write_text(bad)
        assert main(["status", str(recipe), "--output", str(tmp_path / "out")]) == 1
        error = capsys.readouterr().err
        assert message in error and error.count("\n") == 1
