"""ASF and AMC files that can't be used: each is refused in one line that names the file and a remedy."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stages.body.readers import read_motion
from stages.spec import DataError
from tests.stages.body.acclaim import cmu_person

MADE = cmu_person(3, np.random.default_rng(1))
ASF, AMC = MADE.asf(), MADE.amc()
Change = Callable[[str], str]


def _swap(old: str, new: str, text: str = ASF) -> Change:
    assert old in text, old
    return lambda given: given.replace(old, new, 1)


def _until(mark: str) -> Change:
    return lambda text: text[: text.index(mark)]


LAST = AMC.splitlines()[-1]
FEMUR = next(line for line in AMC.splitlines() if line.startswith("lfemur"))

SKELETONS: dict[str, tuple[Change, str]] = {
    "empty": (lambda text: "", "empty"),
    "comments alone": (lambda text: "# nothing\n# at all\n", "empty"),
    "a motion": (lambda text: AMC, ":version"),
    "no bones": (_until(":bonedata"), "no section ':bonedata'"),
    "no tree": (_until(":hierarchy"), "no section ':hierarchy'"),
    "an empty tree": (lambda text: text[: text.index(":hierarchy")] + ":hierarchy\n", "between 'begin' and 'end'"),
    "cut in the tree": (_until("  lhumerus lradius"), "between 'begin' and 'end'"),
    "cut in a bone": (_until("  name lradius"), "the file ends where 'end' of a bone"),
    "no root": (lambda text: text.replace(":root", ":stem"), "no section ':root'"),
    "a bone without end": (_swap(" end\n begin\n  id 5", " begin\n  id 5"), "expected 'end' of a bone"),
    "no begin": (_swap(" begin\n  id 5", "  id 5"), "expected 'begin' of a bone"),
    "no name": (_swap("  name lradius\n", ""), "bones must have names"),
    "a name twice": (_swap("  name lradius", "  name rradius"), "bones must have names, each its own, got 'rradius'"),
    "nan": (_swap("length 7.2", "length nan"), "must be finite"),
    "infinity": (_swap("length 7.2", "length inf"), "must be finite"),
    "huge": (_swap("length 7.2", "length 7e30"), "within"),
    "a length in words": (_swap("length 7.2", "length long"), "must be numbers, got 'long'"),
    "a negative length": (_swap("length 7.2", "length -7.2"), "must have a direction and a length"),
    "no direction": (_swap("direction 0.342 -0.94 0", "direction 0 0 0"), "must have a direction and a length"),
    "a short direction": (_swap("direction 0.342 -0.94 0", "direction 0.342 -0.94"), "followed by 3 numbers, got 2"),
    "a wrong axis": (_swap("axis 0.0 0.0 20.0 XYZ", "axis 0 0 20 XYY"), "an axis order must be of X, Y and Z"),
    "a wrong freedom": (_swap("dof rx ry rz", "dof rx ry rw"), "degrees of freedom must be among"),
    "a length that changes": (_swap("dof rx ry rz", "dof rx ry l"), "got 'l'"),
    "a freedom twice": (_swap("dof rx ry rz", "dof rx rx rz"), "the same degree of freedom twice"),
    "a wrong unit": (_swap("angle deg", "angle grad"), "must be deg or rad"),
    "length unit zero": (_swap("length 0.45", "length 0"), "the unit of length must be > 0"),
    "a stranger in the tree": (_swap("  lhumerus lradius", "  lhumerus lulna"), "names 'lulna', which is no bone"),
    "a bone on two": (_swap("  lhumerus lradius", "  lhumerus lradius lhand"), "hangs on two bones"),
    "a circle": (_swap("  lhumerus lradius", "  lfingers lhumerus\n  lhumerus lradius"), "hangs on two bones"),
    "a loop": (
        lambda text: text.replace("lclavicle lhumerus", "lradius lhumerus"),
        "bones hang on nothing",
    ),
    "an orphan": (_swap("  lhumerus lradius\n", ""), "bones hang on nothing"),
    "binary": (lambda text: text[:200] + "\x00\x01" + text[200:], "binary data"),
}

MOTIONS: dict[str, tuple[Change, str]] = {
    "empty": (lambda text: "", "empty"),
    "no frames": (_until("1\nroot"), "0 frames"),
    "a skeleton": (lambda text: ASF, "expected the number of the first frame"),
    "cut in a frame": (_until(LAST), "lacks 1 of"),
    "cut in a line": (lambda text: text[: -len(LAST) + 8], ""),
    "nan": (_swap(FEMUR, "lfemur nan 0 0", AMC), "must be finite"),
    "huge": (_swap(FEMUR, "lfemur 0 1e200 0", AMC), "within"),
    "words": (_swap(FEMUR, "lfemur a b c", AMC), "must be numbers, got 'a'"),
    "a value too few": (_swap(FEMUR, "lfemur 0 0", AMC), "must have 3 values, got 2"),
    "a value too many": (_swap(FEMUR, "lfemur 0 0 0 0", AMC), "must have 3 values, got 4"),
    "a bone twice": (_swap(FEMUR, f"{FEMUR}\n{FEMUR}", AMC), "moves twice in a frame"),
    "a stranger": (_swap(FEMUR, f"{FEMUR}\ntail 0 0 0", AMC), "'tail' is not in the skeleton"),
    "a bone that is stiff": (_swap(FEMUR, f"{FEMUR}\nlhipjoint 3", AMC), "must have 0 values, got 1"),
    "no root": (lambda text: "\n".join(r for r in text.splitlines() if not r.startswith("root")), "such as 'root'"),
    "no number": (_swap("\n1\n", "\n", AMC), "expected the number of the first frame"),
    "a number in words": (_swap("\n2\n", "\ntwo\n", AMC), "'two' is not in the skeleton"),
    "an endless number": (_swap("\n1\n", "\n" + "1" * 5000 + "\n", AMC), "expected the number of the first frame"),
    "binary": (lambda text: text + "\x00\x01", "binary data"),
}


def _refused(folder: Path, asf: bytes, amc: bytes) -> str:
    (folder / "01.asf").write_bytes(asf)
    (folder / "01_01.amc").write_bytes(amc)
    with pytest.raises(DataError) as caught:
        read_motion(folder / "01_01.amc")
    message = str(caught.value)
    assert "\n" not in message and len(message) < 250, message
    return message


@pytest.mark.parametrize("name", SKELETONS)
def test_a_bad_skeleton_is_refused(name: str, tmp_path: Path) -> None:
    change, wanted = SKELETONS[name]
    assert change(ASF) != ASF
    message = _refused(tmp_path, change(ASF).encode(), AMC.encode())
    assert message.startswith("01.asf") and wanted in message, message


@pytest.mark.parametrize("name", MOTIONS)
def test_a_bad_motion_is_refused(name: str, tmp_path: Path) -> None:
    change, wanted = MOTIONS[name]
    assert change(AMC) != AMC
    message = _refused(tmp_path, ASF.encode(), change(AMC).encode())
    assert message.startswith("01_01.amc") and wanted in message, message


@pytest.mark.parametrize("share", np.linspace(0.03, 0.97, 9))
@pytest.mark.parametrize("kind", ["asf", "amc"])
def test_a_file_cut_anywhere_is_refused(kind: str, share: float, tmp_path: Path) -> None:
    asf, amc = (text[: int(share * len(text))] if kind == k else text for k, text in (("asf", ASF), ("amc", AMC)))
    assert f".{kind}" in _refused(tmp_path, asf.encode(), amc.encode())


def test_other_encodings(tmp_path: Path) -> None:
    assert "UTF-16" in _refused(tmp_path, ASF.encode("utf-16"), AMC.encode())
    (tmp_path / "01.asf").write_bytes(("# caf\u00e9\n" + ASF).encode("latin-1"))
    (tmp_path / "01_01.amc").write_bytes(b"\xef\xbb\xbf" + AMC.replace("\n", "\r\n").encode())
    assert len(read_motion(tmp_path / "01_01.amc").rotations) == 3


def test_one_frame_is_a_motion(tmp_path: Path) -> None:
    (tmp_path / "01.asf").write_text(ASF)
    (tmp_path / "01_01.amc").write_text(AMC[: AMC.index("\n2\n") + 1])
    assert len(read_motion(tmp_path / "01_01.amc").rotations) == 1
