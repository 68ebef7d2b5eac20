"""Reading: whatever is wrong with a shard is found before its values are used, and said in one line."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from shards import KEY, body_arrays

import store
from store.__main__ import main
from store.check import check


def _refused(path: Path, message: str, schema: str | None = "body", key: str | None = KEY) -> None:
    with pytest.raises(store.ShardError, match=message) as caught:
        store.read(path, schema, key)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)
    assert caught.value.remedy


def test_missing(tmp_path: Path) -> None:
    _refused(tmp_path / "none.h5", "no such shard; make it first")


def test_a_folder_is_not_a_shard(tmp_path: Path) -> None:
    _refused(tmp_path, "not a file")


def test_empty(tmp_path: Path) -> None:
    path = tmp_path / "empty.h5"
    path.touch()
    _refused(path, "empty; remove it and make it again")


def test_not_hdf5(tmp_path: Path) -> None:
    path = tmp_path / "text.h5"
    path.write_text("walk " * 100)
    _refused(path, "not a readable HDF5 file of 500 bytes")


def test_hdf5_but_no_shard(tmp_path: Path) -> None:
    path = tmp_path / "foreign.h5"
    with h5py.File(path, "w") as file:
        file["x"] = 1
    _refused(path, "not a shard: it has no attribute 'schema'")


@pytest.mark.parametrize("part", [0.0001, 0.1, 0.5, 0.9, 0.9999])
def test_truncated(shard: Path, part: float) -> None:
    content = shard.read_bytes()
    shard.write_bytes(content[: int(len(content) * part)])
    _refused(shard, "empty|not a readable HDF5 file")


def test_wrong_key(shard: Path) -> None:
    _refused(shard, "it has key abababababab, not cdcdcdcdcdcd: it's out of date", key="cd" * 32)


def test_wrong_schema(shard: Path) -> None:
    _refused(shard, "it follows schema 'body', not 'outfit'", schema="outfit")


@pytest.mark.parametrize(
    ("version", "message"),
    [(0, "schema body v0 where this program reads v2; remove"), (9, "v9 .* use the newer program")],
)
def test_other_version(shard: Path, version: int, message: str) -> None:
    with h5py.File(shard, "a") as file:
        file.attrs["schema_version"] = version
    _refused(shard, message)


def test_changed_values_do_not_pass(shard: Path) -> None:
    with h5py.File(shard, "a") as file:
        file["betas"][3] = 7.0  # HDF5 renews its own checksum
    _refused(shard, "damaged: its content has checksum")


def test_changed_attributes_do_not_pass(shard: Path) -> None:
    with h5py.File(shard, "a") as file:
        file.attrs["attrs"] = file.attrs["attrs"].replace("female", "male")
    _refused(shard, "damaged: its content has checksum")


def test_a_changed_quantum_does_not_pass(shard: Path) -> None:
    with h5py.File(shard, "a") as file:
        file["vertices"].attrs["quantum"] = 2e-4
    _refused(shard, "damaged: its content has checksum")


def test_a_flipped_byte_in_a_frame_is_found_when_the_frame_is_read(shard: Path) -> None:
    with h5py.File(shard, "r") as file:
        info = file["vertices"].id.get_chunk_info(1)
    _flip(shard, info.byte_offset + info.size // 2)
    _refused(shard, "damaged in dataset 'vertices'")
    with store.open_shard(shard) as opened:
        opened.frame("vertices", 0)
        with pytest.raises(store.ShardError, match="damaged in dataset 'vertices'"):
            opened.frame("vertices", 1)


def test_no_flipped_byte_changes_a_value_unseen(shard: Path, tmp_path: Path) -> None:
    """Wherever a byte is flipped, in data or metadata, reading fails in one line or gives the same values: some bytes
    of an HDF5 file are padding."""
    whole = store.read(shard)
    refused = 0
    size = shard.stat().st_size
    offsets = np.unique(np.concatenate([np.arange(0, 400), np.random.default_rng(1).integers(0, size, 400)]))
    for offset in offsets:
        damaged = Path(shutil.copy(shard, tmp_path / "damaged.h5"))
        _flip(damaged, int(offset))
        try:
            found = store.read(damaged, "body", KEY)
        except store.ShardError as error:
            assert "\n" not in str(error)
            refused += 1
            continue
        assert found.attrs == whole.attrs
        assert all(np.array_equal(found[name], whole[name]) for name in body_arrays())
    assert refused > 0.5 * len(offsets)


def test_an_unknown_dataset_is_named(shard: Path) -> None:
    with pytest.raises(store.ShardError, match="no dataset 'verts'; it has betas, faces"):
        store.read(shard)["verts"]


def test_an_error_of_the_reader_stays_its_own(shard: Path) -> None:
    with pytest.raises(ValueError, match="mine"), store.open_shard(shard):
        raise ValueError("mine")


def test_a_folder_is_verified(tmp_path: Path) -> None:
    folder = tmp_path / "report"

    def fill(made: Path) -> None:
        for name in ("a.html", "b.png"):
            (made / name).write_text(name)

    store.publish_folder(folder, KEY, fill)
    assert check(folder, "report", KEY).key == KEY
    with pytest.raises(store.ShardError, match="out of date"):
        check(folder, "report", "cd" * 32)
    (folder / "b.png").write_text("other")
    with pytest.raises(store.ShardError, match=r"b.png: changed since it was published"):
        check(folder)
    (folder / "b.png").unlink()
    with pytest.raises(store.ShardError, match=r"b.png: missing"):
        check(folder)
    (folder / "key.json").write_text("{")
    with pytest.raises(store.ShardError, match=r"its key.json can't be read"):
        check(folder)


def test_the_command_line_shows_and_checks(shard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(shard)]) == 0
    shown = capsys.readouterr().out
    assert "schema body v2" in shown and "vertices" in shown and "0.0001" in shown and "relative to trans" in shown
    assert main(["check", str(shard), str(shard.with_name("none.h5"))]) == 1
    ended = capsys.readouterr()
    assert "ok, body v2" in ended.out and "no such shard" in ended.err
    assert main(["inspect", str(shard.with_name("none.h5"))]) == 1


def _flip(path: Path, offset: int) -> None:
    content = bytearray(path.read_bytes())
    content[offset] ^= 0xFF
    path.write_bytes(content)
