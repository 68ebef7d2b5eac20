"""Items: drawn from the seed and their names alone, cut from clips, split for testing."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.dataset import OUTFITS, Dataset, SequenceEntry
from pipeline.errors import PipelineError
from pipeline.items import Item, collect
from pipeline.motion import MotionFiles, read_motion

HEAD = "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 3 Zrotation Yrotation Xrotation\n}\nMOTION\n"


def write_clip(path: Path, frames: int, frame_time: float = 1 / 30) -> Path:
    """Write a BVH file of one joint that stays as it is."""
    path.write_text(HEAD + f"Frames: {frames}\nFrame Time: {frame_time}\n" + "0 0 0\n" * frames)
    return path


def _collect(dataset: Dataset, folder: Path, motion: Path | None = None) -> list[Item]:
    return collect(dataset, "r.toml [dataset]", MotionFiles(folder / "motions.json"), motion=motion)


@pytest.fixture
def clips(tmp_path: Path) -> Path:
    """Four clips: of 250, 100, 95 and 20 frames at 30 fps."""
    folder = tmp_path / "motion"
    folder.mkdir()
    for name, frames in (("a", 250), ("b", 100), ("c", 95), ("d", 20)):
        write_clip(folder / f"{name}.bvh", frames)
    return folder


def test_clips_are_cut_and_short_rests_left_out(clips: Path, tmp_path: Path) -> None:
    items = _collect(Dataset(name="d", motions=str(clips), sequences=5, frames=100, shortest=30), tmp_path)
    cuts = {item.id: (item.params["start"], item.params["frames"]) for item in items}
    assert cuts == {"a_s0": (0, 100), "a_s1": (100, 100), "a_s2": (200, 50), "b_s0": (0, 100), "c_s0": (0, 95)}


def test_more_sequences_than_cuts_take_the_motions_again(clips: Path, tmp_path: Path) -> None:
    items = _collect(Dataset(name="d", motions=str(clips), sequences=12, frames=100), tmp_path)
    assert len({item.id for item in items}) == 12
    assert Counter(item.id.split("_p")[0] for item in items).most_common()[-1][1] == 2
    assert sum(item.id.endswith("_p2") for item in items) == 2


def test_a_new_clip_leaves_the_other_items_as_they_were(clips: Path, tmp_path: Path) -> None:
    dataset = Dataset(name="d", motions=str(clips), sequences=5, frames=100, shortest=30)
    before = {item.id: item.params for item in _collect(dataset, tmp_path)}
    write_clip(clips / "e.bvh", 90)
    after = {item.id: item.params for item in _collect(replace(dataset, sequences=6), tmp_path)}
    assert after.keys() - before.keys() == {"e_s0"}
    for name, params in before.items():
        assert {**after[name], "split": ""} == {**params, "split": ""}


def test_statics_have_every_outfit_for_both_genders_in_the_right_share(tmp_path: Path) -> None:
    items = _collect(Dataset(name="d", statics=36, female_share=2 / 3), tmp_path)
    assert Counter(item.params["outfit"] for item in items) == dict.fromkeys(OUTFITS, 6)
    assert Counter((i.params["outfit"], i.params["gender"]) for i in items)["dress", "female"] == 4
    assert _collect(Dataset(name="d", statics=12, female_share=2 / 3), tmp_path)[5].id == items[5].id


@pytest.mark.parametrize(("count", "tests"), [(1, 0), (3, 1), (60, 12)])
def test_the_share_for_testing_is_exact(tmp_path: Path, count: int, tests: int) -> None:
    items = _collect(Dataset(name="d", statics=count, test_share=0.2), tmp_path)
    assert sum(item.params["split"] == "test" for item in items) == tests


def test_another_seed_splits_otherwise(tmp_path: Path) -> None:
    def tests(seed: int) -> set[str]:
        items = _collect(Dataset(name="d", statics=60, seed=seed), tmp_path)
        return {item.id for item in items if item.params["split"] == "test"}

    assert tests(1) == tests(1) != tests(2)


def test_one_motion_for_every_sequence(clips: Path, tmp_path: Path) -> None:
    entry = SequenceEntry(id="one", gender="female", motion="walk", frames=60, start=10)
    items = _collect(Dataset(name="d", sequence=(entry,)), tmp_path, clips / "d.bvh")
    assert items[0].params["motion"] == str(clips / "d.bvh")
    assert (items[0].params["start"], items[0].params["frames"]) == (0, 20)
    assert len(items[0].params["motion_sha256"]) == 64


def test_frame_rates_become_30(tmp_path: Path) -> None:
    assert read_motion(write_clip(tmp_path / "m.bvh", 241, 0.0083333), "").frames == 61
    assert read_motion(write_clip(tmp_path / "m.bvh", 100, 1 / 60), "").frames == 50
    assert read_motion(write_clip(tmp_path / "m.bvh", 100, 1 / 24), "").frames == 124


def test_motion_files_are_read_again_only_if_they_change(clips: Path, tmp_path: Path) -> None:
    files = MotionFiles(tmp_path / "motions.json")
    first = files(clips / "a.bvh", "")
    files.save()
    again = MotionFiles(tmp_path / "motions.json")
    assert again(clips / "a.bvh", "") == first
    write_clip(clips / "a.bvh", 251)
    assert again(clips / "a.bvh", "").frames == 251


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (b" \n", "the file is empty"),
        (b"solid cube", "not BVH: it must start with HIERARCHY, got 'solid cube'"),
        (bytes(range(256)), "not BVH: it must start with HIERARCHY"),
        (HEAD.encode()[:40], "truncated: it has no MOTION part"),
        (HEAD.encode(), "truncated: MOTION must go on with 'Frames:'"),
        (HEAD.encode() + b"Frames: 3\n", "truncated: MOTION must go on with 'Frames:'"),
        (
            HEAD.encode() + b"Frames: 3\nFrame Time: 0.03\n0 0 0\n0 0 0\n",
            "truncated: 3 frames are announced, 2 are there",
        ),
        (HEAD.encode() + b"Frames: 2\nFrame Time: 0.03\n0 0 0\n0 0", "truncated: the last frame has 2 of 3 numbers"),
        (
            HEAD.encode() + b"Frames: 1\nFrame Time: 0\n0 0 0\n",
            "Frames must be >= 1 and Frame Time from 0.0001 to 1 s, got 1 and 0.0",
        ),
    ],
)
def test_bad_motion_files_are_named(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "m.bvh"
    path.write_bytes(content)
    dataset = Dataset(name="d", sequence=(SequenceEntry(id="one", gender="female", motion=str(path)),))
    with pytest.raises(PipelineError) as caught:
        _collect(dataset, tmp_path)
    assert f"r.toml [dataset] sequence 'one': {path}: {message}" in str(caught.value)
    assert str(caught.value).endswith("name a whole BVH file") and "\n" not in str(caught.value)


def test_what_is_not_there_is_named(tmp_path: Path, clips: Path) -> None:
    def refused(message: str, **given: object) -> None:
        with pytest.raises(PipelineError, match=message):
            _collect(Dataset(name="d", **given), tmp_path)  # type: ignore[arg-type]

    one = {"id": "one", "gender": "female"}
    refused(r"no.bvh: No such file .*; name an existing motion file", sequence=(SequenceEntry(**one, motion="no.bvh"),))
    refused("motions = 'none': no such folder", motions="none", sequences=1)
    refused("has no motion files", motions=str(clips / "*.c3d"), sequences=1)
    refused("has no clip of 999 frames", motions=str(clips), sequences=1, shortest=999)
    refused("start must be < 95", sequence=(SequenceEntry(**one, motion=str(clips / "c.bvh"), start=95),))
    refused("id 'one' stands there twice", sequence=(SequenceEntry(**one, motion="walk"),) * 2)
    refused("id must be of letters", sequence=(SequenceEntry(id="a/b", gender="male", motion="walk"),))
