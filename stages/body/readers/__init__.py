"""Readers of motion files: whatever the format, one `Recording`."""

import hashlib
from collections.abc import Mapping
from pathlib import Path

from stages.body.joint_map import refuse_missing, rename
from stages.body.readers.amc import read_amc, skeleton_of
from stages.body.readers.arrays import read_npz
from stages.body.readers.bvh import read_bvh
from stages.body.readers.deepmimic import read_deepmimic
from stages.body.readers.text import read_bytes
from stages.body.recording import Recording
from stages.spec import DataError

SUFFIXES = (".bvh", ".amc", ".npz", ".txt")
"""Endings of motion files; .txt are clips of DeepMimic's."""

DEFAULT_RATE = 120.0
"""Frames per second of files that don't tell theirs: that of most of CMU's AMC files."""

NO_TABLE: Mapping[str, str] = {}

__all__ = ["DEFAULT_RATE", "SUFFIXES", "Recording", "fingerprint", "read_any", "read_motion", "split_name", "title"]


def split_name(motion: str) -> tuple[Path, str]:
    """The file of a motion, and which of its sequences: `smpl_data.npz:01_01` names one in a file that has many."""
    head, colon, sequence = motion.rpartition(":")
    if colon and head.lower().endswith(".npz") and "/" not in sequence:
        return Path(head), sequence
    return Path(motion), ""


def read_motion(motion: Path | str, *, joints: Mapping[str, str] = NO_TABLE, rate: float = DEFAULT_RATE) -> Recording:
    """Reads a motion file of any known format.

    Args:
        motion: The file; `file.npz:sequence` names one of many in a file.
        joints: Which joint of the file moves which joint of the body, where the names don't tell: SMPL's name of the
            joint -> the file's.
        rate: Frames per second, for files that don't tell theirs.

    Returns:
        The recording; every joint that a person needs is in it.

    Raises:
        DataError: The file can't be used: what is wrong, where, and what to do about it, in one line.
    """
    name = split_name(str(motion))[0].name
    recording = rename(read_any(motion, rate), joints, name)
    refuse_missing(recording.names, name)
    return recording


def read_any(motion: Path | str, rate: float = DEFAULT_RATE) -> Recording:
    """Reads a motion file, whatever its skeleton; see `read_motion`."""
    path, sequence = split_name(str(motion))
    kind = path.suffix.lower()
    if kind == ".bvh":
        return read_bvh(path)
    if kind == ".amc":
        return read_amc(path, rate)
    if kind == ".npz":
        return read_npz(path, rate, sequence)
    if kind == ".txt":
        return read_deepmimic(path)
    hint = "name the .amc file that moves it" if kind == ".asf" else f"known endings: {', '.join(SUFFIXES)}"
    raise DataError(f"{path.name}: is no motion file that can be read; {hint}")


def title(motion: Path | str) -> str:
    """A motion's name: its sequence's, else its file's, without what AMASS adds to it: `01_01` of `01_01_poses.npz`."""
    path, sequence = split_name(str(motion))
    name = sequence or path.stem
    if path.suffix.lower() == ".npz":
        name = name.removesuffix("_poses").removesuffix("_stageii").removesuffix(" poses")
    return name


def fingerprint(motion: Path | str) -> str:
    """Hash of all that a motion's file says, its skeleton's file included, sha256 in hex.

    Raises:
        DataError: A file can't be read.
    """
    path, _ = split_name(str(motion))
    digest = hashlib.sha256(read_bytes(path))
    if path.suffix.lower() == ".amc":
        digest.update(read_bytes(skeleton_of(path)))
    return digest.hexdigest()
