"""The stage as the pipeline runs it: from a body shard to an outfit shard."""

from pathlib import Path

import numpy as np
import pytest

from model.body import REST_POSE, load_free_body
from stages.outfit import SPEC
from stages.outfit.config import Config
from stages.outfit.stage import run
from stages.settings import plain
from stages.spec import DataError, Task
from store import publish, read


def body_shard(folder: Path, gender: str) -> str:
    model = load_free_body(gender)
    betas = np.linspace(-1.0, 1.0, 10)
    rest = model.pose(betas, REST_POSE[None], np.zeros((1, 3)))
    arrays = {
        "betas": betas,
        "pose": REST_POSE[None],
        "trans": np.zeros((1, 3)),
        "rest_pose": REST_POSE,
        "faces": model.faces,
        "vertices": rest,
        "rest_vertices": rest[0],
    }
    attrs = {"gender": gender, "motion": "rest", "action": "rest", "fps": 30, "kind": "static"}
    publish(folder / "body.h5", "body", "b" * 64, arrays, attrs)
    return str(folder / "body.h5")


def task(folder: Path, outfit: str, name: str = "outfit.h5", seed: int = 3) -> Task:
    return Task(
        stage="outfit",
        item="one",
        kind="static",
        key="a" * 64,
        seed=seed,
        config=plain(Config(edge_length=0.014)),
        params={"outfit": outfit},
        inputs={"body": {"one": {"path": str(folder / "body.h5"), "key": "b" * 64}}},
        output=str(folder / name),
    )


def test_an_outfit_is_published_with_all_that_the_next_stages_need(tmp_path: Path) -> None:
    body_shard(tmp_path, "male")
    steps: list[tuple[float, float, str]] = []
    figures = run(task(tmp_path, "tshirt+trousers"), lambda done, total, label="": steps.append((done, total, label)))
    shard = read(tmp_path / "outfit.h5", SPEC.schema, "a" * 64)
    assert shard.attrs["layers"] == ["trousers", "tshirt"]
    assert shard.attrs["gender"] == "male"
    tight = np.linspace(-1.0, 1.0, 10)
    tight[:2] -= shard.attrs["tightness"]
    assert shard["tight_betas"] == pytest.approx(tight, abs=1e-6)
    total = 0
    for name in shard.groups("garments"):
        count = len(shard[f"garments/{name}/vertices"])
        total += count
        assert shard[f"garments/{name}/faces"].max() == count - 1
        assert len(shard[f"garments/{name}/elastic"]) == len(shard[f"garments/{name}/waistband"]) == count
        about = shard.attrs["garments"][name]
        assert about["fabric"]["density"] > 0
        assert shard[f"garments/{name}/border"].max() == len(about["borders"])
        assert shard[f"garments/{name}/panel"].max() == len(about["panels"]) - 1
        assert shard[f"garments/{name}/uv_faces"].max() == len(shard[f"garments/{name}/uv"]) - 1
        for seam in about["panel_seams"].values():
            assert (shard[f"garments/{name}/seam"] == seam["number"]).sum() == seam["edges"]
        assert len(shard[f"garments/{name}/seam_edges"]) == len(shard[f"garments/{name}/seam"])
    assert figures["vertices"] == total
    assert [s[0] for s in steps] == sorted(s[0] for s in steps)
    assert steps[-1][0] == steps[-1][1]


def test_equal_tasks_give_equal_bytes_and_other_seeds_other_outfits(tmp_path: Path) -> None:
    body_shard(tmp_path, "female")
    for name, seed in (("a.h5", 3), ("b.h5", 3), ("c.h5", 4)):
        run(task(tmp_path, "random", name, seed), lambda *_: None)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()
    assert (tmp_path / "a.h5").read_bytes() != (tmp_path / "c.h5").read_bytes()


def test_an_unknown_outfit_is_bad_data(tmp_path: Path) -> None:
    body_shard(tmp_path, "female")
    with pytest.raises(DataError, match=r"outfit must be one of .* got 'cape'"):
        run(task(tmp_path, "cape"), lambda *_: None)
    assert not (tmp_path / "outfit.h5").exists()
