"""The whole mill, once, on a tiny recipe: every stage does its real work, and its shards hold what they should."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

import store
from pipeline.cli import main

RECIPE = Path(__file__).parents[1] / "recipes" / "tiny.toml"


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Everything that the tiny recipe makes."""
    output = tmp_path_factory.mktemp("tiny")
    assert main(["run", str(RECIPE), "--output", str(output)]) == 0
    return output


def test_every_shard_is_whole_and_a_second_run_does_nothing(output: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(RECIPE), "--output", str(output)]) == 0
    assert "31 of 31 shards verified" in capsys.readouterr().out
    assert main(["run", str(RECIPE), "--output", str(output)]) == 0
    assert capsys.readouterr().out.startswith("nothing to do: 31 tasks up to date\n")


def test_the_garments_move_with_the_person(output: Path) -> None:
    body = store.read(output / "body" / "walk.h5", "body")
    cloth = store.read(output / "simulate" / "walk.h5", "simulate")
    assert len(body["pose"]) == 8
    assert len(cloth.groups("garments")) == 2
    for name in cloth.groups("garments"):
        vertices = cloth[f"garments/{name}/vertices"]
        assert vertices.shape[0] == 8
        # Relative to the root joint: within reach of the person wherever they walk, and never still.
        assert np.abs(vertices).max() < 1.5
        assert np.abs(np.diff(vertices, axis=0)).max(axis=(1, 2)).min() > 1e-3


def test_cloth_stays_outside_the_body_and_hardly_stretches(output: Path) -> None:
    # Depth by ray parity and trimesh's closest points: not the library that the solver measures itself with.
    body = store.read(output / "body" / "walk.h5", "body")
    cloth = store.read(output / "simulate" / "walk.h5", "simulate")
    outfit = store.read(output / "outfit" / "walk.h5", "outfit")
    for name in cloth.groups("garments"):
        vertices, faces = cloth[f"garments/{name}/vertices"], cloth[f"garments/{name}/faces"]
        for frame in (0, 4, 7):
            skin = trimesh.Trimesh(body["vertices"][frame], body["faces"], process=False)
            inside = vertices[frame][skin.contains(vertices[frame])]
            if len(inside):
                assert trimesh.proximity.closest_point(skin, inside)[1].max() < 1e-3, (name, frame)
        a, b = trimesh.Trimesh(outfit[f"garments/{name}/vertices"], faces, process=False).edges_unique.T
        rest = np.linalg.norm(np.subtract(*outfit[f"garments/{name}/vertices"][[a, b]]), axis=1)
        stretch = np.linalg.norm(vertices[:, a] - vertices[:, b], axis=2) / rest - 1
        assert (stretch > 0.1).mean(axis=1).max() < 0.01, name


def test_garments_are_encoded_at_rest_and_in_motion(output: Path) -> None:
    moving = store.read(output / "encode" / "walk.h5", "encode")
    still = store.read(output / "encode" / "static_00000.h5", "encode")
    for shard, has_motion in ((moving, True), (still, False)):
        for name in shard.groups("garments"):
            mask = shard[f"garments/{name}/mask"]
            assert 0.02 < mask.mean() < 0.9
            assert (f"garments/{name}/offsets" in shard) == has_motion
            assert np.abs(shard[f"garments/{name}/static_offsets"][mask]).max() < 0.6


def test_the_models_are_scored_and_shown(output: Path) -> None:
    model = store.read(output / "train" / "all.h5", "train")
    assert model.attrs["metrics"] and model.groups("generated")
    page = (output / "report" / "all" / "index.html").read_text()
    assert "<video" in page and "http://" not in page and "https://" not in page
