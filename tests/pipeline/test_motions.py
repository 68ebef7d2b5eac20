"""Motion files of every kind in planning: how long they are, which are in a folder, what their labels say."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.dataset import Dataset, SequenceEntry
from pipeline.errors import PipelineError
from pipeline.items import Item, collect
from pipeline.labels import read_labels
from pipeline.motion import MotionFiles
from tests.pipeline.test_items import write_clip

ASF = """:version 1.10
:units
  length 0.45
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name lfemur
    direction 0 -1 0
    length 7
    axis 0 0 0 XYZ
    dof rx
  end
:hierarchy
  begin
    root lfemur
  end
"""


def write_amc(path: Path, frames: int) -> None:
    """Write a motion of one bone that stays as it is."""
    rows = "".join(f"{k + 1}\nroot 0 0 0 0 0 0\nlfemur 5\n" for k in range(frames))
    path.write_text(f":FULLY-SPECIFIED\n:DEGREES\n{rows}")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A BVH file, an AMC file with its skeleton, an AMASS file with a shape beside it, and one of SURREAL."""
    root = tmp_path / "motion"
    (root / "07").mkdir(parents=True)
    write_clip(root / "walk_1.bvh", 40)
    (root / "07" / "07.asf").write_text(ASF)
    write_amc(root / "07" / "07_02.amc", 241)
    poses = {"poses": np.zeros((121, 156)), "trans": np.zeros((121, 3))}
    np.savez(root / "02_01_poses.npz", mocap_framerate=60.0, **poses)
    np.savez(root / "shape.npz", gender="female", betas=np.zeros(16))
    sequences = {f"{k}_{n}": np.zeros((50 + 30 * i, w)) for i, n in enumerate(("01_01", "01_02")) for k, w in SURREAL}
    np.savez(root / "smpl_data.npz", **sequences)
    return root


SURREAL = (("pose", 72), ("trans", 3))


def items(dataset: Dataset, tmp_path: Path, rate: float = 120.0) -> list[Item]:
    """The items of a dataset."""
    return collect(dataset, "r.toml [dataset]", MotionFiles(tmp_path / "motions.json", rate))


def test_a_folder_of_every_kind_is_cut_as_in_the_paper(folder: Path, tmp_path: Path) -> None:
    dataset = Dataset(name="d", motions=str(folder), sequences=9, frames=40, shortest=1)
    cuts = {item.id: (item.params["start"], item.params["frames"]) for item in items(dataset, tmp_path, 30.0)}
    assert len(cuts) == 9
    everything = items(Dataset(name="d", motions=str(folder), sequences=14, frames=40, shortest=1), tmp_path, 30.0)
    cuts = {item.id: (item.params["start"], item.params["frames"]) for item in everything}
    assert cuts == {
        "walk_1_s0": (0, 40),
        **{f"07_02_s{k}": (40 * k, 40) for k in range(6)},
        "07_02_s6": (240, 1),
        "02_01_s0": (0, 40),
        "02_01_s1": (40, 21),
        "01_01_s0": (0, 40),
        "01_01_s1": (40, 10),
        "01_02_s0": (0, 40),
        "01_02_s1": (40, 40),
    }
    surreal = next(item for item in everything if item.id == "01_02_s1")
    assert surreal.params["motion"].endswith("smpl_data.npz:01_02")


def test_the_rate_of_files_that_do_not_tell_is_the_recipe_s(folder: Path, tmp_path: Path) -> None:
    files = {rate: MotionFiles(tmp_path / "motions.json", rate) for rate in (120.0, 60.0)}
    amc = folder / "07" / "07_02.amc"
    assert files[120.0](amc, "r").frames == 61
    files[120.0].save()
    assert files[60.0](amc, "r").frames == 121, "the cache must not answer for another rate"
    assert MotionFiles(tmp_path / "motions.json", 60.0)(folder / "02_01_poses.npz", "r").frames == 61


def test_another_skeleton_is_another_motion(folder: Path, tmp_path: Path) -> None:
    amc = folder / "07" / "07_02.amc"
    files = MotionFiles(tmp_path / "motions.json")
    before = files(amc, "r").sha256
    (folder / "07" / "07.asf").write_text(ASF.replace("length 7", "length 7.5"))
    assert files(amc, "r").sha256 != before


def test_files_of_one_name_get_their_folder_s_before_it(tmp_path: Path) -> None:
    for place in ("a", "b"):
        (tmp_path / place).mkdir()
        write_clip(tmp_path / place / "walk_1.bvh", 40)
    found = items(Dataset(name="d", motions=f"{tmp_path}/*/*.bvh", sequences=2), tmp_path)
    assert {item.id for item in found} == {"a_walk_1_s0", "b_walk_1_s0"}


def test_labels_come_from_the_index(folder: Path, tmp_path: Path) -> None:
    index = tmp_path / "index.txt"
    index.write_text("CMU Graphics Lab\n\nSubject #1 (climb)\n01_01\tplayground - forward jumps, turn\n07_02, walk\n")
    dataset = Dataset(name="d", motions=str(folder), sequences=6, frames=300, shortest=1, labels=str(index))
    told = {item.id: item.params.get("action") for item in items(dataset, tmp_path)}
    assert told["01_01_s0"] == "playground - forward jumps, turn" and told["07_02_s0"] == "walk"
    assert told["walk_1_s0"] is None


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_labels_as_tables_are_saved(encoding: str, tmp_path: Path) -> None:
    """By Windows' programs, between quotes, by files' names, with names of any kind."""
    path = tmp_path / "labels.csv"
    path.write_bytes(
        '"walk_1.bvh";"caf\u00e9 walk"\r\nTake 7.bvh,run, jump\r\n07_02 sit\r\n07.12\tsing\r\n'.encode(encoding)
    )
    labels = read_labels(str(path), "r")
    told = [labels.of(name) for name in ("d/walk_1.bvh", "d/Take 7.bvh", "d/07_02.amc", "d/07.12.bvh", "d/x.bvh")]
    assert told == ["caf\u00e9 walk", "run, jump", "sit", "sing", ""]


def test_names_in_other_scripts_are_each_their_own(tmp_path: Path) -> None:
    for name in ("\u8d70\u308b", "\u6b69\u304f", "walk"):
        write_clip(tmp_path / f"{name}.bvh", 40)
    write_amc(tmp_path / "walk.amc", 40)
    (tmp_path / "walk.asf").write_text(ASF)
    found = items(Dataset(name="d", motions=str(tmp_path), sequences=4, shortest=1), tmp_path)
    assert len({item.id for item in found}) == 4
    assert len({item.params["motion"] for item in found}) == 4


@pytest.mark.parametrize(
    ("content", "message"), [(None, "No such file"), ("", "has no label"), ("Subject #1 (climb)\n", "has no label")]
)
def test_a_list_without_labels_is_refused(content: str | None, message: str, tmp_path: Path) -> None:
    path = tmp_path / "index.txt"
    if content is not None:
        path.write_text(content)
    with pytest.raises(PipelineError, match=message):
        read_labels(str(path), "r.toml [dataset]")


def test_a_damaged_file_is_named(folder: Path, tmp_path: Path) -> None:
    (folder / "broken.npz").write_bytes(b"PK\x03\x04 cut")
    with pytest.raises(PipelineError, match=r"r\.toml \[dataset\].*broken\.npz: is not a whole \.npz file"):
        items(Dataset(name="d", motions=str(folder), sequences=1), tmp_path)
    lone = SequenceEntry(id="a", gender="male", motion=str(folder / "07" / "07_03.amc"))
    write_amc(folder / "07" / "07_03.amc", 0)
    with pytest.raises(PipelineError, match=r"07_03\.amc, line 2: the file holds 0 frames"):
        items(Dataset(name="d", sequence=(lone,)), tmp_path)
