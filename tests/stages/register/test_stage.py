"""The stages register and encode on shards: what goes in comes out again within the quantum."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stages.encode.stage
import stages.register.stage
import store
from model.body import REST_POSE
from model.body.layer import GarmentLayer
from model.mesh.barycentric import carry
from model.offsets import apply_offsets
from stages.encode import SPEC as ENCODE
from stages.register import SPEC as REGISTER
from stages.spec import DataError, Task

KEY = {stage: f"{n}" * 64 for n, stage in enumerate(("body", "outfit", "simulate", "register", "encode"))}
FABRIC = {"density": 0.2}
BETAS = np.array([0.5, 0.3, 0, 0, 0, 0, 0, 0, 0, 0], dtype=np.float32)
FRAMES = 4
Made = Any


def quiet(done: float, total: float, label: str = "") -> None:
    """Progress that nobody watches."""


@pytest.fixture(scope="module")
def shards(tmp_path_factory: pytest.TempPathFactory, layer: GarmentLayer, tshirt: Made, skirt: Made) -> Path:
    """Shards of a person who walks through the world in a t-shirt and a skirt, both made for betas 0."""
    folder = tmp_path_factory.mktemp("shards")
    rng = np.random.default_rng(4)
    pose = (REST_POSE[None] + 0.1 * rng.standard_normal((FRAMES, 24, 3))).astype(np.float32)
    trans = np.array([[0.3 * t, -2.0, 0.9] for t in range(FRAMES)], dtype=np.float32)
    model = layer.model
    store.publish(
        folder / "body.h5",
        "body",
        KEY["body"],
        {
            "betas": BETAS,
            "pose": pose,
            "trans": trans,
            "rest_pose": REST_POSE,
            "faces": model.faces,
            "vertices": model.pose(BETAS, pose, 0 * trans),
            "rest_vertices": model.pose(BETAS, REST_POSE[None], np.zeros((1, 3)))[0],
        },
        {"gender": "female", "motion": "test", "action": "test", "fps": 30, "kind": "sequence"},
    )
    arrays: dict[str, np.ndarray] = {"tight_betas": np.zeros(10)}
    moving: dict[str, np.ndarray] = {}
    for name, made in (("tshirt", tshirt), ("skirt", skirt)):
        group, count = f"garments/{name}", len(made.vertices)
        arrays[f"{group}/vertices"], arrays[f"{group}/faces"] = made.vertices, made.faces
        arrays[f"{group}/elastic"], arrays[f"{group}/waistband"] = np.zeros(count, np.int8), np.zeros(count, bool)
        wave = 0.05 * rng.standard_normal((FRAMES, 1, 3)) + 0.01 * np.sin(30 * made.vertices)
        moving[f"{group}/vertices"], moving[f"{group}/faces"] = made.vertices + wave, made.faces
    garments = {
        name: {"type": name, "fabric": FABRIC, "parameters": {}, "elastics": {}} for name in ("tshirt", "skirt")
    }
    attrs = {"kind": "tshirt+skirt", "gender": "female", "tightness": [0.5, 0.3], "layers": ["tshirt", "skirt"]}
    store.publish(folder / "outfit.h5", "outfit", KEY["outfit"], arrays, {**attrs, "garments": garments})
    quality = {"fps": 30, "garments": garments, "quality": {}}
    store.publish(folder / "simulate.h5", "simulate", KEY["simulate"], moving, quality)
    return folder


def task(folder: Path, stage: str, needs: tuple[str, ...], **config: Any) -> Task:
    inputs = {need: {"a": {"path": str(folder / f"{need}.h5"), "key": KEY[need]}} for need in needs}
    out = str(folder / f"{stage}.h5")
    kind = "sequence" if "simulate" in needs else "static"
    return Task(
        stage=stage, item="a", kind=kind, key=KEY[stage], seed=7, config=config, params={}, inputs=inputs, output=out
    )


@pytest.fixture(scope="module")
def registered(shards: Path) -> Path:
    figures = stages.register.stage.run(task(shards, "register", REGISTER.needs), quiet)
    assert figures["error_mean_m"] < 1e-3 and figures["error_p95_m"] < 3.5e-3 and figures["coverage"] > 0.99
    return shards


def test_register_publishes_every_garment(registered: Path, layer: GarmentLayer) -> None:
    shard = store.read(registered / "register.h5", "register", KEY["register"])
    outfit = store.read(registered / "outfit.h5", "outfit", KEY["outfit"])
    assert {n: a["topology"] for n, a in shard.attrs["garments"].items()} == {"tshirt": "skirt", "skirt": "skirt"}
    for name in ("tshirt", "skirt"):
        group = f"garments/{name}"
        rows = shard[f"{group}/face"], shard[f"{group}/barycentric"]
        again = carry(outfit[f"{group}/vertices"], outfit[f"{group}/faces"], *rows)
        np.testing.assert_allclose(again, shard[f"{group}/registered"], atol=1e-6)
        assert shard[f"{group}/mask"].shape == (layer.vertex_count,)


def test_decoding_what_was_encoded_gives_the_garment_back(registered: Path, layer: GarmentLayer) -> None:
    figures = stages.encode.stage.run(task(registered, "encode", ENCODE.needs), quiet)
    assert figures == {"frames": FRAMES, "garments": 2}
    shard = store.read(registered / "encode.h5", "encode", KEY["encode"])
    register = store.read(registered / "register.h5", "register", KEY["register"])
    outfit = store.read(registered / "outfit.h5", "outfit", KEY["outfit"])
    simulate = store.read(registered / "simulate.h5", "simulate", KEY["simulate"])
    betas, pose = shard["betas"], shard["pose"]
    rest = layer.model.pose(betas, REST_POSE[None], np.zeros((1, 3)))[0]
    posed = layer.model.pose(betas, pose, np.zeros((FRAMES, 3)))
    for name in ("tshirt", "skirt"):
        group = f"garments/{name}"
        mask = shard[f"{group}/mask"]
        rows = outfit[f"{group}/faces"], register[f"{group}/face"], register[f"{group}/barycentric"]
        for offsets, body, source in (
            ("static_offsets", rest, outfit[f"{group}/vertices"]),
            ("offsets", posed, simulate[f"{group}/vertices"]),
        ):
            decoded = apply_offsets(body, shard[f"{group}/{offsets}"])
            error = np.abs(decoded - carry(source, *rows))[..., mask, :].max()
            assert error < 0.5 * 5e-5 + 1e-6
            assert not shard[f"{group}/{offsets}"][..., ~mask, :].any()
    assert shard.attrs["tightness"] == [0.5, 0.3] and shard.attrs["gender"] == "female" and shard.attrs["fps"] == 30
    expected = {"type": "skirt", "topology": "skirt", "fabric": FABRIC}
    assert shard.attrs["garments"]["skirt"] == expected
    np.testing.assert_allclose(shard["trans"][:, 0], 0.3 * np.arange(FRAMES), atol=1e-6)


def test_a_static_item_has_no_moving_offsets(registered: Path) -> None:
    needs = tuple(need for need in ENCODE.needs if need != "simulate")
    figures = stages.encode.stage.run(task(registered, "encode", needs), quiet)
    shard = store.read(registered / "encode.h5", "encode", KEY["encode"])
    assert figures["frames"] == 0
    assert "garments/tshirt/offsets" not in shard and "garments/tshirt/static_offsets" in shard


def test_every_second_frame(registered: Path) -> None:
    stages.encode.stage.run(task(registered, "encode", ENCODE.needs, every=2), quiet)
    shard = store.read(registered / "encode.h5", "encode", KEY["encode"])
    assert shard["garments/skirt/offsets"].shape[0] == len(shard["pose"]) == 2
    assert shard.attrs["fps"] == 15


def test_too_little_coverage_is_the_datas_fault(shards: Path) -> None:
    with pytest.raises(DataError, match=r"a: the registered skirt covers 0\.\d+ of the garment, min_coverage is 1\.0"):
        stages.register.stage.run(task(shards, "register", REGISTER.needs, min_coverage=1.0, reach=0.01), quiet)


def test_a_garment_inside_out_is_rejected(shards: Path, tmp_path: Path) -> None:
    outfit = store.read(shards / "outfit.h5", "outfit", KEY["outfit"])
    arrays = {name: outfit[name] for name in outfit}
    arrays["garments/skirt/faces"] = arrays["garments/skirt/faces"][:, ::-1]
    store.publish(tmp_path / "outfit.h5", "outfit", KEY["outfit"], arrays, outfit.attrs)
    job = task(shards, "register", REGISTER.needs)
    job.inputs["outfit"]["a"]["path"] = str(tmp_path / "outfit.h5")  # type: ignore[index]
    with pytest.raises(
        DataError, match=r"a: the registered skirt covers 0\.\d+ of the garment.*faces must turn outwards"
    ):
        stages.register.stage.run(job, quiet)


def test_shards_of_different_outfits_do_not_mix(registered: Path, tmp_path: Path) -> None:
    outfit = store.read(registered / "outfit.h5", "outfit", KEY["outfit"])
    arrays = {name: outfit[name] for name in outfit}
    for name in ("tshirt", "skirt"):
        arrays[f"garments/{name}/faces"] = arrays[f"garments/{name}/faces"][:100]
    job = task(registered, "encode", ENCODE.needs)
    store.publish(tmp_path / "outfit.h5", "outfit", KEY["outfit"], arrays, outfit.attrs)
    job.inputs["outfit"]["a"]["path"] = str(tmp_path / "outfit.h5")  # type: ignore[index]
    with pytest.raises(DataError, match=r"a: skirt: face must be < 100, the garment's faces, got \d+; make"):
        stages.encode.stage.run(job, quiet)
