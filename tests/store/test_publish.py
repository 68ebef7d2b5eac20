"""Publishing: equal bytes for equal content, all or nothing, and nothing that breaks the schema."""

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shards import KEY, body_arrays, body_attrs

import store


def test_what_is_published_is_read(shard: Path) -> None:
    arrays = body_arrays()
    found = store.read(shard, "body", KEY)
    assert list(found) == sorted(arrays)
    assert found.attrs == body_attrs()
    np.testing.assert_array_equal(found["faces"], arrays["faces"])
    np.testing.assert_array_equal(found["pose"], arrays["pose"].astype(np.float32))
    assert np.abs(found["vertices"] - arrays["vertices"]).max() <= 5e-5 + 1e-7
    with store.open_shard(shard, "body", KEY) as opened:
        np.testing.assert_array_equal(opened.frame("vertices", 2), found["vertices"][2])
        assert opened.shape("vertices") == (3, 50, 3)


def test_equal_content_gives_equal_bytes(shard: Path, tmp_path: Path) -> None:
    time.sleep(1.1)  # HDF5's own stamps count in seconds
    again = tmp_path / "elsewhere" / "other.h5"
    reversed_order = dict(reversed(list(body_arrays().items())))
    reversed_attrs = dict(reversed(list(body_attrs().items())))
    store.publish(again, "body", KEY, reversed_order, reversed_attrs)
    assert again.read_bytes() == shard.read_bytes()


def test_garments_are_groups(tmp_path: Path) -> None:
    path = tmp_path / "outfit.h5"
    attrs = {"kind": "dress", "gender": "female", "tightness": [0.1, np.float64(0.2)], "garments": {}, "layers": []}
    arrays: dict[str, np.ndarray] = {"tight_betas": np.zeros(10)}
    for name, vertices in (("skirt", 7), ("top", 5)):
        arrays[f"garments/{name}/vertices"] = np.ones((vertices, 3))
        arrays[f"garments/{name}/faces"] = np.zeros((4, 3), int)
        arrays[f"garments/{name}/elastic"] = np.zeros(vertices, int)
        arrays[f"garments/{name}/waistband"] = np.zeros(vertices, bool)
    store.publish(path, "outfit", KEY, arrays, attrs)
    found = store.read(path)
    assert found.groups("garments") == ["skirt", "top"]
    assert found.attrs["tightness"] == [0.1, 0.2]
    assert "garments/top/faces" in found and "garments/top/nothing" not in found


def _simulated(**bars: np.ndarray) -> dict[str, np.ndarray]:
    """Two garments over three frames, and error bars by dataset ("top_..." are those of the top)."""
    arrays: dict[str, np.ndarray] = {}
    for name in ("skirt", "top"):
        arrays[f"garments/{name}/vertices"] = np.zeros((3, 4, 3))
        arrays[f"garments/{name}/faces"] = np.zeros((2, 3), int)
    return arrays | {name.replace("top_", "garments/top/"): values for name, values in bars.items()}


def test_error_bars_may_be_there_and_share_their_axes(tmp_path: Path) -> None:
    attrs: dict[str, Any] = {"fps": 30, "garments": {}, "quality": {}}
    store.publish(tmp_path / "without.h5", "simulate", KEY, _simulated(), attrs)
    bars = {"error_frames": np.array([[1, 2]]), "top_step_error_rms": np.array([[1e-4, 2e-4]])}
    store.publish(tmp_path / "with.h5", "simulate", KEY, _simulated(**bars), attrs)
    found = store.read(tmp_path / "with.h5", "simulate")
    np.testing.assert_allclose(found["garments/top/step_error_rms"], [[1e-4, 2e-4]], rtol=1e-6)
    bars["top_mesh_error_max"] = np.zeros((1, 3))
    with pytest.raises(store.ShardError, match=r"top/mesh_error_max': axis L must be 2 as in error_frames, got shape"):
        store.publish(tmp_path / "odd.h5", "simulate", KEY, _simulated(**bars), attrs)


def _without(name: str) -> dict[str, np.ndarray]:
    return {other: values for other, values in body_arrays().items() if other != name}


@pytest.mark.parametrize(
    ("arrays", "attrs", "message"),
    [
        (_without("betas"), body_attrs(), "dataset 'betas' of schema body v2 is missing"),
        (body_arrays() | {"velocity": np.zeros(3)}, body_attrs(), "dataset 'velocity' isn't in schema body v2"),
        (
            body_arrays() | {"betas": np.zeros(9)},
            body_attrs(),
            r"axis 10 must be 10 as in the schema, got shape \(9,\)",
        ),
        (body_arrays() | {"trans": np.zeros((4, 3))}, body_attrs(), r"axis T must be 3 as in pose, got shape \(4, 3\)"),
        (body_arrays() | {"faces": np.zeros(3, int)}, body_attrs(), r"shape must be \(F, 3\), got \(3,\)"),
        (
            body_arrays() | {"betas": np.full(10, np.nan)},
            body_attrs(),
            r"'betas' \[1\]: value at \(0,\) must be finite",
        ),
        (body_arrays() | {"vertices": np.full((3, 50, 3), 4.0)}, body_attrs(), r"'vertices' \[m\]: .* 3.2767 .*got 4"),
        (body_arrays(), {"gender": "female"}, "attribute 'motion' of schema body v2 is missing"),
        (body_arrays(), body_attrs() | {"fps": float("nan")}, "attribute 'fps' must be finite JSON"),
        (body_arrays(), body_attrs() | {"fps": Path("x")}, "attribute 'fps' must be finite JSON"),
    ],
)
def test_content_that_breaks_the_schema_is_refused(
    tmp_path: Path, arrays: dict[str, np.ndarray], attrs: dict[str, Any], message: str
) -> None:
    with pytest.raises(store.ShardError, match=message) as caught:
        store.publish(tmp_path / "bad.h5", "body", KEY, arrays, attrs)
    assert "\n" not in str(caught.value) and "bad.h5" in str(caught.value)
    assert list(tmp_path.iterdir()) == []


_FULL_DISK = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
sys.path.insert(0, {tests!r})
import store
from shards import KEY, body_arrays, body_attrs
resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
try:
    store.publish({path!r}, "body", KEY, body_arrays(frames=300), body_attrs())
except store.NoSpaceError as error:
    print(error)
"""


def test_a_full_disk_is_named_and_leaves_the_older_shard(shard: Path) -> None:
    """A limit on file sizes stands for the full disk: it fails the write in the same way, without privileges."""
    before = shard.read_bytes()
    code = _FULL_DISK.format(tests=str(Path(__file__).parent), path=str(shard))
    ended = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == f"{shard}: no room to write it (File too large); free some space there and run again"
    assert shard.read_bytes() == before
    assert list(shard.parent.iterdir()) == [shard]


def test_a_folder_is_published_whole(tmp_path: Path) -> None:
    target = tmp_path / "report"
    for text in ("first", "second"):
        store.publish_folder(target, KEY, lambda folder, text=text: _fill(folder, text))
        assert (target / "pages" / "index.html").read_text() == text
        assert [path.name for path in tmp_path.iterdir()] == ["report"]


def test_a_folder_that_fails_leaves_the_older_one(tmp_path: Path) -> None:
    target = tmp_path / "report"
    store.publish_folder(target, KEY, lambda folder: _fill(folder, "first"))

    def fail(folder: Path) -> None:
        _fill(folder, "second")
        raise RuntimeError("no ink")

    with pytest.raises(RuntimeError, match="no ink"):
        store.publish_folder(target, KEY, fail)
    assert (target / "pages" / "index.html").read_text() == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["report"]


def _fill(folder: Path, text: str) -> None:
    (folder / "pages").mkdir()
    (folder / "pages" / "index.html").write_text(text)
