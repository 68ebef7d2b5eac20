"""Files as programs and people really write them, and short motions at any rate."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from model.body import BodyModel
from pipeline.motion import read_motion as plan_motion
from stages.body.fidelity import compare
from stages.body.figure import Figure
from stages.body.readers.amc import read_amc
from stages.body.readers.bvh import read_bvh
from stages.body.resample import frames_at_30
from stages.body.sequence import prepared, put_on
from stages.spec import DataError
from tests.stages.body.acclaim import cmu_person
from tests.stages.body.skeletons import person
from tests.stages.body.test_root_order import as_recording

WILD = {
    "a mark before the text": lambda text: "\ufeff" + text,
    "old Macs' line ends": lambda text: text.replace("\n", "\r"),
    "DOS's end of file": lambda text: text.replace("\n", "\r\n") + "\x1a",
    "tabs and blanks": lambda text: text.replace(" ", "\t").replace("\n", " \t\n\n"),
    "small letters": lambda text: text.replace("HIERARCHY", "Hierarchy").replace("MOTION", "Motion").lower(),
    "capitals": lambda text: text.replace("Frame Time", "FRAME TIME").replace("Frames", "FRAMES"),
    "no blanks after colons": lambda text: text.replace("Frames: ", "Frames:").replace("Frame Time: ", "Frame Time:"),
    "a brace before MOTION": lambda text: text.replace("}\nMOTION", "} MOTION"),
    "a bone named MOTION": lambda text: text.replace("LThumb", "MOTION"),
    "one frame a second": lambda text: text.replace("Frame Time: 0.0166667", "Frame Time: 1.0"),
    "scales": lambda text: text.replace("CHANNELS 6", "CHANNELS 9 Xscale Yscale Zscale").replace(
        "\n1 1 1 ", "\n1 1.001 1 1 1 1 "
    ),
}


@pytest.mark.parametrize("way", WILD)
def test_planning_and_reading_take_the_same_files(way: str, tmp_path: Path) -> None:
    """A folder and a file with blanks and accents in their names, what programs write, and both of its readers."""
    made = person(np.random.default_rng(4).uniform(-50, 50, (3, 24, 3)), np.ones((3, 3)), 1 / 60)
    plain, wild = tmp_path / "plain.bvh", tmp_path / "L\u00e4ufer und Tr\u00e4ger" / "\u6b69 \u304f.bvh"
    wild.parent.mkdir()
    plain.write_text(made.text())
    wild.write_bytes(WILD[way](made.text()).encode())
    one, other = read_bvh(plain), read_bvh(wild)
    np.testing.assert_array_equal(one.rotations, other.rotations)
    np.testing.assert_array_equal(one.translations, other.translations)
    assert plan_motion(wild, "r").frames == frames_at_30(3, other.frame_time)


def test_bytes_of_other_encodings_end_no_line(tmp_path: Path) -> None:
    """In Shift-JIS a name may have the byte that ends a line in Unicode's second control set."""
    text = person(np.zeros((1, 24, 3)), np.zeros((1, 3)), 1 / 30).text()
    (tmp_path / "a.bvh").write_bytes(text.encode().replace(b"LThumb", "\u30e5".encode("shift-jis")))
    assert len(read_bvh(tmp_path / "a.bvh").names) == 24
    (tmp_path / "b.bvh").write_text(WILD["scales"](text.replace("\n0 0 0 ", "\n1 1 1 ")).replace("1.001", "1.1"))
    with pytest.raises(DataError, match=r"b\.bvh, line \d+: Yscale of 'Hips' must be 1, got 1\.1; export"):
        read_bvh(tmp_path / "b.bvh")


@pytest.mark.parametrize(("frames", "rate"), [(1, 120), (1, 1), (2, 120), (2, 1), (9, 25), (9, 59.94), (9, 240)])
@pytest.mark.filterwarnings("error")
def test_short_motions_at_any_rate(frames: int, rate: float, woman: tuple[BodyModel, np.ndarray, Figure]) -> None:
    recording = replace(as_recording(woman[2], "walk"), frame_time=1 / rate)
    part = slice(100, 100 + frames)
    recording = replace(recording, rotations=recording.rotations[part], translations=recording.translations[part])
    at_30, _ = prepared(recording, "short")
    motion = put_on(woman[2], at_30, "short")
    assert len(motion) == int((frames - 1) / rate * 30 + 1e-3) + 1
    assert np.isfinite(motion.pose).all() and np.isfinite(motion.trans).all()
    assert np.isfinite(compare(woman[2], motion, at_30, "short").slide)


@pytest.mark.parametrize("way", ["a mark before the text", "old Macs' line ends", "DOS's end of file"])
def test_acclaim_s_files_in_the_wild(way: str, tmp_path: Path) -> None:
    made = cmu_person(3, np.random.default_rng(1))
    asf, amc = made.asf().replace(" ", "\t").replace(":version", ":VERSION").replace(":root", ":ROOT"), made.amc()
    for name, texts in (("01", (made.asf(), amc)), ("02", (WILD[way](asf), WILD[way](amc.replace(" ", " \t"))))):
        (tmp_path / f"{name}.asf").write_bytes(texts[0].encode())
        (tmp_path / f"{name}_01.amc").write_bytes(texts[1].encode())
    one, other = (read_amc(tmp_path / f"{name}_01.amc", 120.0) for name in ("01", "02"))
    assert one.names == other.names
    np.testing.assert_array_equal(one.rotations, other.rotations)
