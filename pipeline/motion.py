"""What planning must know of a motion file: that it is one, how long it is, and its hash. Not its contents' meaning.

BVH files, of which there may be thousands, are counted by their lines; the readers of the stage `body` count others.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import PipelineError
from stages.spec import DataError
from store.atomic import replace_file

FPS = 30  # frames per second of everything made

# As the reader of the stage `body` has them: letters of either case, spaces or none, a brace before MOTION.
MOTION = re.compile(r"(?:^|\})[ \t]*MOTION[ \t]*$", re.IGNORECASE | re.MULTILINE)
FRAMES = re.compile(r"\s*Frames\s*:\s*([0-9]{1,9})\s*", re.IGNORECASE)
FRAME_TIME = re.compile(r"\s*Frame\s+Time\s*:\s*([-+.0-9e]+)\s*", re.IGNORECASE)


@dataclass(frozen=True)
class Motion:
    """A motion file.

    Attributes:
        path: Absolute path; `file.npz:sequence` for one of many in a file.
        sha256: Hash of its content, in hex.
        frames: Number of frames at 30 fps.
    """

    path: Path
    sha256: str
    frames: int


class MotionFiles:
    """Reads motion files, each once: sizes, times and results are kept in a cache file between runs.

    Args:
        cache: The cache file.
        rate: Frames per second of files that don't tell theirs.
    """

    def __init__(self, cache: Path, rate: float = 120.0) -> None:
        self._cache = cache
        self._rate = rate
        self._known: dict[str, list[int | float | str]] = {}
        self._changed = False
        try:
            self._known = json.loads(cache.read_text())
        except (OSError, ValueError):
            self._changed = True  # no cache, or none that can be read: it is written anew

    def __call__(self, path: Path | str, where: str) -> Motion:
        """The motion at `path`, which `where` in the recipe asks for.

        Raises:
            PipelineError: It's missing, empty, truncated or no motion file; one line.
        """
        path = Path(path).absolute()
        stamp: list[int | float | str] = [self._stamp(path, where), self._rate]
        entry = self._known.get(str(path))
        if entry is None or entry[:2] != stamp:
            motion = read_motion(path, where, self._rate)
            self._known[str(path)] = [*stamp, motion.sha256, motion.frames]
            self._changed = True
            return motion
        return Motion(path, str(entry[2]), int(entry[3]))

    def _stamp(self, path: Path, where: str) -> str:
        """Sizes and times of all that a motion is read from."""
        file = file_of(path)
        try:
            files = [file.stat()]
            if file.suffix.lower() == ".amc":
                files += [skeleton.stat() for skeleton in sorted(file.parent.glob("*.[aA][sS][fF]"))]
        except OSError as error:
            raise PipelineError(f"{where}: {path}: {error.strerror}; name an existing motion file") from None
        return " ".join(f"{about.st_size} {about.st_mtime_ns}" for about in files)

    def save(self) -> None:
        """Write the cache, if there is something new in it."""
        if self._changed and self._known:
            replace_file(self._cache, json.dumps(self._known).encode())


def file_of(path: Path) -> Path:
    """The file of a motion: what stands before the colon, where one of many in a file is named."""
    head, colon, _ = path.name.rpartition(":")
    return path.with_name(head) if colon and head.lower().endswith(".npz") else path


def read_motion(path: Path, where: str, rate: float = 120.0) -> Motion:
    """Check that `path` is a whole motion file and count its frames at 30 fps.

    Raises:
        PipelineError: It can't be read, or is empty, truncated or no motion file; one line.
    """
    if file_of(path).suffix.lower() != ".bvh":
        from stages.body.readers.survey import fingerprint, frames_of

        try:
            return Motion(path, fingerprint(path), frames_of(path, rate))
        except DataError as error:
            raise PipelineError(f"{where}: {error}") from None
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PipelineError(f"{where}: {path}: {error.strerror}; name an existing motion file") from None
    problem = ""
    frames = 0
    try:
        frames = _frames(content.decode("utf-8-sig", errors="replace"))
    except ValueError as error:
        problem = str(error)
    if problem:
        raise PipelineError(f"{where}: {path}: {problem}; name a whole BVH file")
    return Motion(path, hashlib.sha256(content).hexdigest(), frames)


def _frames(text: str) -> int:
    if not text.strip():
        raise ValueError("the file is empty")
    text = text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\x1a")
    if not text.lstrip()[:9].upper() == "HIERARCHY":
        raise ValueError(f"not BVH: it must start with HIERARCHY, got {text.lstrip()[:20]!r}")
    found = MOTION.search(text)
    if not found:
        raise ValueError("truncated: it has no MOTION part")
    lines = [line for line in text[found.end() :].split("\n") if line.strip()]
    counted, timed = (pattern.fullmatch(line) for pattern, line in zip((FRAMES, FRAME_TIME), [*lines[:2], "", ""]))
    if not counted or not timed:
        raise ValueError("truncated: MOTION must go on with 'Frames:' and 'Frame Time:', a number after each")
    frames, frame_time = int(counted[1]), float(timed[1])
    if frames < 1 or not 1e-4 <= frame_time <= 1:
        raise ValueError(f"Frames must be >= 1 and Frame Time from 0.0001 to 1 s, got {frames} and {frame_time}")
    if len(lines) - 2 != frames:
        what = "truncated" if len(lines) - 2 < frames else "damaged"
        raise ValueError(f"{what}: {frames} frames are announced, {len(lines) - 2} are there")
    words = text[: found.start()].upper().split()
    channels = sum(int(words[i + 1]) for i, word in enumerate(words[:-1]) if word == "CHANNELS")
    numbers = len(lines[frames + 1].split())
    if numbers < channels:
        raise ValueError(f"truncated: the last frame has {numbers} of {channels} numbers")
    # Frame i lies at i * frame_time; the tolerance keeps 1/120 s written as 0.0083333 from losing a frame.
    return math.floor((frames - 1) * frame_time * FPS + 1e-3) + 1
