"""One function gives every stage its body: the free one, or the file that was planned with, and no other."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from model.body import load_free_body
from stages.body_model import body_model_attrs, load_body_model, load_wearer
from store import ShardError
from tests.model.body.smpl_files import as_npz, as_python2, random_model


def about(path: Path, **other: Any) -> dict[str, Any]:
    """What a shard says of a person with that file's body."""
    sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
    return {"gender": "male", "body_model": str(path), "body_model_sha256": sha256, **other}


def test_without_a_file_it_is_the_free_body() -> None:
    assert load_body_model({"gender": "male", "fps": 30}) is load_free_body("male")
    assert body_model_attrs({"gender": "male", "body_model": ""}) == {}
    assert load_wearer({"gender": "male"}) is load_free_body("male")


def test_a_file_is_read_once(tmp_path: Path) -> None:
    made = random_model(betas=12)
    (tmp_path / "smpl.pkl").write_bytes(as_python2(made))
    said = about(tmp_path / "smpl.pkl", fps=30)
    body = load_body_model(said)
    assert body.gender == "male" and body.beta_count == 10 and body.vertex_count == 144
    np.testing.assert_array_equal(body.v_template, made["v_template"].astype(np.float32))
    assert load_body_model(said) is body
    assert body_model_attrs(said) == {name: said[name] for name in ("body_model", "body_model_sha256")}
    with pytest.raises(ShardError, match=r"smpl\.pkl: cannot be dressed: .* must be <= .*; make none but bodies"):
        load_wearer(said)


def test_a_file_that_is_not_the_planned_one(tmp_path: Path) -> None:
    path = tmp_path / "smpl.npz"
    path.write_bytes(as_npz(random_model()))
    planned = about(path)
    path.write_bytes(as_npz(random_model(seed=1)))
    with pytest.raises(ShardError, match=r"smpl\.npz: the body model has changed since .*; plan again"):
        load_body_model(planned)
    path.unlink()
    with pytest.raises(ShardError, match=r"smpl\.npz: No such file or directory.*plan again"):
        load_body_model(planned)


def test_a_file_with_too_few_betas(tmp_path: Path) -> None:
    (tmp_path / "few.npz").write_bytes(as_npz(random_model(betas=8)))
    with pytest.raises(ShardError, match=r"few\.npz: shapedirs has 8 betas, 10 are needed"):
        load_body_model(about(tmp_path / "few.npz"))
