"""Files of SMPL's schema: every way of writing one gives the same body, and it moves as the package smplx moves it."""

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
import smplx
import torch
from smplx.lbs import lbs

from model.body import PARENTS, BodyModel, read_smpl
from model.body.extra_joints import fold_weights, kept_joints
from model.body.smpl_file import parse_smpl
from tests.model.body.smpl_files import (
    as_npz,
    as_pickle,
    as_python2,
    random_model,
    tree,
    with_chumpy,
)

SPARSE = {"csc": sp.csc_matrix, "csr": sp.csr_matrix, "csc array": sp.csc_array, "csr array": sp.csr_array}


def read(content: bytes, **options: Any) -> BodyModel:
    """The model of a file's content."""
    return parse_smpl(content, "body", "neutral", **options)


def assert_same(one: BodyModel, other: BodyModel) -> None:
    """Equal to the last bit."""
    for name, value in vars(one).items():
        np.testing.assert_array_equal(getattr(other, name), value, err_msg=name)


@pytest.mark.parametrize("betas", [10, 300])
def test_an_archive_gives_the_arrays_that_were_written(betas: int) -> None:
    made = random_model(betas=betas)
    body = read(as_npz(made))
    assert body.vertex_count == 144 and body.beta_count == betas and body.gender == "neutral"
    np.testing.assert_array_equal(body.v_template, made["v_template"].astype(np.float32))
    np.testing.assert_array_equal(body.shapedirs, made["shapedirs"].astype(np.float32))
    np.testing.assert_array_equal(body.posedirs, made["posedirs"].astype(np.float32))
    np.testing.assert_array_equal(body.faces, made["f"])
    np.testing.assert_array_equal(body.parents, PARENTS)
    np.testing.assert_allclose(body.weights, made["weights"], atol=1e-7)
    np.testing.assert_allclose(body.joint_template, made["J_regressor"] @ made["v_template"], atol=1e-12)
    seventh = made["J_regressor"] @ made["shapedirs"][:, :, 6]
    np.testing.assert_allclose(body.joint_shapedirs[:, :, 6], seventh, atol=1e-12)
    assert not body.shapedirs.flags.writeable


@pytest.mark.parametrize("protocol", range(6))
@pytest.mark.parametrize("regressor", ["dense", *SPARSE])
def test_pickles_of_python_3(protocol: int, regressor: str) -> None:
    made = random_model()
    matrix = SPARSE[regressor](made["J_regressor"]) if regressor in SPARSE else made["J_regressor"]
    assert_same(read(as_npz(made)), read(as_pickle(made | {"J_regressor": matrix}, protocol)))


@pytest.mark.parametrize("protocol", range(3))
def test_pickles_of_python_2(protocol: int) -> None:
    made = random_model()
    assert_same(read(as_npz(made)), read(as_python2(made, protocol)))
    assert_same(read(as_npz(made)), read(with_chumpy(made, protocol=protocol)))


def test_pickles_of_python_3_with_chumpy() -> None:
    made = random_model(betas=300)
    assert_same(read(as_npz(made)), read(with_chumpy(made, python2=False, protocol=4)))


def test_memory_order_number_type_and_root_do_not_matter() -> None:
    made = random_model()
    signed = made["kintree_table"].astype(np.int64)
    signed[0, 0] = -1
    shuffled = made | {
        "v_template": np.asfortranarray(made["v_template"]),
        "weights": np.asfortranarray(made["weights"]),
        "f": made["f"].astype(np.int64),
        "kintree_table": signed,
    }
    assert_same(read(as_npz(made)), read(as_npz(shuffled)))
    assert_same(read(as_npz(made)), read(as_pickle(shuffled)))
    assert_same(read(as_npz(made)), read(as_npz(made | {"kintree_table": signed.astype(np.uint64)})))
    swapped = made | {"v_template": made["v_template"].astype(">f8")}
    assert_same(read(as_npz(made)), read(as_python2(swapped)))


def test_joints_may_bear_other_numbers() -> None:
    """The lower row names the joints of the columns, the upper one refers to these names."""
    made = random_model()
    names = np.random.default_rng(3).permutation(24) + 100
    table = np.stack([np.where(PARENTS < 0, 2**32 - 1, names[PARENTS]), names])
    assert_same(read(as_npz(made)), read(as_npz(made | {"kintree_table": table})))


def test_betas_and_correctives_that_are_not_there() -> None:
    made = random_model(betas=20)
    assert read(as_npz(made), beta_count=10).beta_count == 10
    without = {name: value for name, value in made.items() if name != "posedirs"}
    assert read(as_npz(without)).posedirs is None
    assert read(as_npz(made | {"posedirs": 0 * made["posedirs"]})).posedirs is None, "it would cost time alone"


def test_a_file_on_disk(tmp_path: Path) -> None:
    """What it is shows in its content, not in its name."""
    made = random_model()
    (tmp_path / "SMPL_FEMALE.npz").write_bytes(as_python2(made))
    body = read_smpl(tmp_path / "SMPL_FEMALE.npz", "female")
    assert body.gender == "female"
    np.testing.assert_array_equal(body.v_template, made["v_template"].astype(np.float32))
    with pytest.raises(ValueError, match="gender must be female, male or neutral, got 'woman'"):
        read_smpl(tmp_path / "SMPL_FEMALE.npz", "woman")


def _tensor(array: Any) -> torch.Tensor:
    return torch.tensor(np.asarray(array, np.float64))


@pytest.mark.parametrize("correctives", [True, False])
def test_skinning_agrees_with_smplx(correctives: bool, tmp_path: Path) -> None:
    """The class SMPL of the package smplx on the same arrays, in double precision, to 1e-5 m."""
    made = random_model(seed=5)
    if not correctives:
        made["posedirs"][:] = 0.0
    struct = SimpleNamespace(**made)
    spots = dict.fromkeys(smplx.vertex_ids.vertex_ids["smplh"], 0)  # its landmarks are vertices of the real mesh
    rng = np.random.default_rng(6)
    pose, betas, trans = rng.normal(0.0, 0.6, (7, 24, 3)), rng.uniform(-3.0, 3.0, 10), rng.normal(0.0, 1.0, (7, 3))
    oracle = smplx.SMPL("", data_struct=struct, batch_size=7, dtype=torch.float64, vertex_ids=spots)
    result = oracle(
        betas=_tensor(betas)[None].repeat(7, 1),
        global_orient=_tensor(pose[:, 0]),
        body_pose=_tensor(pose[:, 1:].reshape(7, 69)),
        transl=_tensor(trans),
    )
    body = read(with_chumpy(made))
    assert (body.posedirs is not None) == correctives
    # smplx moves the model's origin by transl, here trans is where the root joint stands.
    root = body.shape(betas)[1][0]
    ours = body.pose(betas, pose, trans + root)
    np.testing.assert_allclose(ours, result.vertices.detach().numpy(), atol=1e-5, rtol=0)
    still = result.vertices.detach().numpy()[0] - body.shape(betas)[0]
    assert np.abs(still).max() > 0.1, "the poses do something here"


@pytest.mark.parametrize(("count", "stored", "kept"), [(52, 16, 16), (55, 20, 10), (55, 400, 300)])
def test_larger_models_agree_with_smplx_while_fingers_and_face_rest(count: int, stored: int, kept: int) -> None:
    """smplx moves all joints of SMPL-H and SMPL-X, here 24 carry the same body, to 1e-5 m."""
    made = random_model(count, betas=stored, seed=count)
    body = read(as_pickle(made | {"J_regressor": sp.csc_matrix(made["J_regressor"])}))
    assert body.weights.shape == (6 * count, 24) and body.beta_count == kept
    rng = np.random.default_rng(8)
    pose, betas = np.zeros((5, count, 3)), rng.uniform(-2.0, 2.0, min(kept, 10))
    pose[:, :22] = rng.normal(0.0, 0.6, (5, 22, 3))
    vertices, _ = lbs(
        _tensor(betas)[None].repeat(5, 1),
        _tensor(pose.reshape(5, -1)),
        _tensor(made["v_template"]),
        _tensor(made["shapedirs"][..., : len(betas)]),
        _tensor(made["posedirs"].reshape(-1, 9 * (count - 1)).T),
        _tensor(made["J_regressor"]),
        torch.tensor(tree(count)),
        _tensor(made["weights"]),
    )
    reduced = np.concatenate([pose[:, :22], np.zeros((5, 2, 3))], axis=1)
    np.testing.assert_allclose(body.pose(betas, reduced), vertices.numpy(), atol=1e-5, rtol=0)
    # Left and right middle finger: the second of five, three joints each, behind 22 joints of the body and 3 of a face.
    first = count - 30
    shaped = made["v_template"] + made["shapedirs"][..., : len(betas)] @ betas
    knuckles = (made["J_regressor"] @ shaped)[[first + 3, first + 18]]
    np.testing.assert_allclose(body.shape(betas)[1][22:], knuckles, atol=1e-9)


def test_extra_joints_go_with_the_joint_above_them() -> None:
    """By hand, one vertex a joint: thumbs with the wrist, other fingers with the hand, jaw and eyes with the head."""
    for count in (52, 55):
        carried = fold_weights(np.eye(count), tree(count)).argmax(axis=1).tolist()
        left = [22] * 12 + [20] * 3
        right = [23] * 12 + [21] * 3
        assert carried == [*range(22), *([15] * (count - 52)), *left, *right]
        assert kept_joints(count).tolist() == [*range(22), count - 27, count - 12]


def _fingerprint(threads: int) -> str:
    """Hashes of what a fresh process with that many threads for matrix products reads and poses."""
    program = (
        "import hashlib, numpy as np\n"
        "from dataclasses import replace\n"
        "from tests.model.body.smpl_files import as_pickle, human_model\n"
        "from model.body.smpl_file import parse_smpl\n"
        "body = parse_smpl(as_pickle(human_model()), '', 'female')\n"
        "pose = np.random.default_rng(1).normal(0, 0.5, (70, 24, 3))\n"
        "plain = replace(body, posedirs=None)\n"
        "made = [*body.shape(np.ones(10)), body.pose(np.ones(10), pose), plain.pose(np.ones(10), pose)]\n"
        "print([hashlib.sha256(array.tobytes()).hexdigest() for array in made])\n"
    )
    count = {name: str(threads) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    return subprocess.run(
        [sys.executable, "-c", program], env=os.environ | count, check=True, capture_output=True, text=True
    ).stdout


def test_the_number_of_threads_changes_no_bit() -> None:
    """6,890 vertices with correctives over 70 frames: products large enough for a library to divide them."""
    assert _fingerprint(1) == _fingerprint(2)
