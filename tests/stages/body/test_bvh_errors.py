"""Files that can't be used: each is refused in one line that names the file and a remedy."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stages.body.readers.bvh import read_bvh
from stages.spec import DataError
from tests.stages.body.skeletons import person

GOOD = person(np.zeros((3, 24, 3)), np.zeros((3, 3)), 1 / 120).text()


def _cut(lines: int) -> Callable[[str], str]:
    return lambda text: "\n".join(text.splitlines()[:-lines])


def _swap(old: str, new: str) -> Callable[[str], str]:
    assert old in GOOD
    return lambda text: text.replace(old, new, 1)


def _last(new: str) -> Callable[[str], str]:
    return lambda text: text.rsplit("\n", 2)[0] + "\n" + new + "\n"


VALUES = GOOD.splitlines()[-1]
MUTANTS: dict[str, tuple[Callable[[str], str], str]] = {
    "empty": (lambda text: "", "empty"),
    "blank": (lambda text: "\n \n", "empty"),
    "a picture": (lambda text: "PNG\n" + text, "HIERARCHY"),
    "no motion": (lambda text: text.split("MOTION")[0], "MOTION"),
    "one frame missing": (_cut(1), "Frames: 3"),
    "all frames missing": (_cut(3), "Frames: 3"),
    "a frame too many": (lambda text: text + VALUES + "\n", "more than it says"),
    "last line cut": (_last(" ".join(VALUES.split()[:-5])), "75 values, got 70"),
    "a value too many": (_last(VALUES + " 1"), "75 values, got 76"),
    "not a number": (_last(VALUES[:-1] + "x"), "must be numbers, got '"),
    "nan": (_last(VALUES[:-1] + " nan".strip()), "finite"),
    "infinity": (_last(VALUES[:-1] + "inf"), "finite"),
    "a huge number": (_last(VALUES[:-1] + "9e99"), "within"),
    "a huge offset": (_swap("OFFSET 1.6 -1.8 0.6", "OFFSET 1e30 0 0"), "within"),
    "a short offset": (_swap("OFFSET 1.6 -1.8 0.6", "OFFSET 1.6 -1.8"), "three numbers"),
    "no offset": (_swap("\tOFFSET 1.6 -1.8 0.6\n", "\n"), "OFFSET"),
    "zero frames": (_swap("Frames: 3", "Frames: 0"), "0 frames"),
    "negative frames": (_swap("Frames: 3", "Frames: -3"), "Frames:"),
    "frames in words": (_swap("Frames: 3", "Frames: three"), "Frames:"),
    "frames with a power": (_swap("Frames: 3", "Frames: 3\u00b2"), "Frames:"),
    "frames without end": (_swap("Frames: 3", "Frames: " + "3" * 5000), "Frames:"),
    "frames by the billion": (_swap("Frames: 3", "Frames: 999999999"), "Frames: 999999999' but 3"),
    "no frame time": (_swap("Frame Time: 0.0083333", "Frame Time:"), "Frame Time"),
    "frame time zero": (_swap("Frame Time: 0.0083333", "Frame Time: 0"), "Frame Time"),
    "frame time nan": (_swap("Frame Time: 0.0083333", "Frame Time: nan"), "Frame Time"),
    "frame time minutes": (_swap("Frame Time: 0.0083333", "Frame Time: 120"), "Frame Time"),
    "a wrong channel": (_swap("CHANNELS 3 Zrotation", "CHANNELS 3 Wrotation"), "Wrotation"),
    "a channel twice": (_swap("CHANNELS 3 Zrotation Yrotation", "CHANNELS 3 Zrotation Zrotation"), "twice"),
    "a wrong channel count": (_swap("CHANNELS 3", "CHANNELS 4"), "CHANNELS"),
    "a missing brace": (lambda text: text.replace("\t}\n}\nMOTION", "\t}\nMOTION"), "MOTION"),
    "a brace too many": (_swap("\nMOTION", "\n}\nMOTION"), "expected MOTION"),
    "the same name twice": (_swap("JOINT LeftLeg", "JOINT Hips"), "Hips"),
    "no name": (_swap("JOINT LeftLeg", "JOINT"), "names"),
    "two roots": (_swap("JOINT LeftLeg", "ROOT LeftLeg"), "one tree"),
    "no root": (_swap("ROOT Hips", "JOINT Hips"), "one tree"),
    "nonsense in the tree": (_swap("JOINT LeftLeg", "LeftLeg"), "expected JOINT"),
}


@pytest.mark.parametrize("name", MUTANTS)
def test_a_bad_file_is_refused(name: str, tmp_path: Path) -> None:
    change, wanted = MUTANTS[name]
    text = change(GOOD)
    assert text != GOOD
    path = tmp_path / "bad.bvh"
    path.write_text(text)
    with pytest.raises(DataError) as caught:
        read_bvh(path)
    message = str(caught.value)
    assert message.startswith("bad.bvh"), message
    assert wanted in message, message
    assert "\n" not in message and len(message) < 250


@pytest.mark.parametrize("share", np.linspace(0.02, 0.98, 13))
def test_a_file_cut_anywhere_is_refused(share: float, tmp_path: Path) -> None:
    path = tmp_path / "cut.bvh"
    path.write_text(GOOD[: int(share * len(GOOD))])
    with pytest.raises(DataError, match=r"cut\.bvh"):
        read_bvh(path)


def test_binary_data_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "noise.bvh"
    path.write_bytes(bytes(range(256)) * 10)
    with pytest.raises(DataError, match=r"noise\.bvh: is not a BVH text file"):
        read_bvh(path)


def test_utf_16_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "wide.bvh"
    path.write_text(GOOD, encoding="utf-16")
    with pytest.raises(DataError, match=r"wide\.bvh: is written in UTF-16; save it as UTF-8"):
        read_bvh(path)


def test_a_missing_file_or_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"gone\.bvh: there is no such motion file"):
        read_bvh(tmp_path / "gone.bvh")
    with pytest.raises(DataError, match="cannot be read"):
        read_bvh(tmp_path)


def test_the_line_is_named(tmp_path: Path) -> None:
    lines = GOOD.splitlines()
    lines[-2] = lines[-2][:-1] + "x"
    path = tmp_path / "bad.bvh"
    path.write_text("\n".join(lines))
    with pytest.raises(DataError, match=rf"bad\.bvh, line {len(lines) - 1}: "):
        read_bvh(path)
