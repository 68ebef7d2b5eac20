"""What planning must know of a motion file before it is read in earnest: which motions are in it, and how long."""

from pathlib import Path

from stages.body.readers import DEFAULT_RATE, SUFFIXES, fingerprint, read_any, title
from stages.body.readers.arrays import motions_of
from stages.body.resample import frames_at_30

__all__ = ["fingerprint", "frames_of", "motions_in", "title"]


def motions_in(path: Path) -> list[str]:
    """The motions of a file, as `read_motion` takes them; none if it is an .npz file without poses.

    Raises:
        DataError: An .npz file can't be read.
    """
    if path.suffix.lower() == ".txt" and not path.name.startswith("humanoid3d_"):
        return []  # a text about the motions
    if path.suffix.lower() != ".npz":
        return [str(path)] if path.suffix.lower() in SUFFIXES else []
    return [f"{path}:{name}" if name else str(path) for name in motions_of(path)]


def frames_of(motion: Path | str, rate: float = DEFAULT_RATE) -> int:
    """Number of frames of a motion at 30 fps; the whole file is read and checked.

    Args:
        motion: The file; `file.npz:sequence` names one of many.
        rate: Frames per second of files that don't tell theirs.

    Raises:
        DataError: The file can't be used; one line.
    """
    recording = read_any(motion, rate)
    return frames_at_30(len(recording.rotations), recording.frame_time)
