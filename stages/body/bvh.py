"""Reader of BVH motion files: any hierarchy, any order of channels, any frame rate."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stages.spec import DataError

Array = NDArray[np.float64]

MOTION_CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")
"""The names of channels that BVH knows."""

LARGEST = 1e6
"""No offset, position or angle of a person is larger, in any unit."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Recording:
    """A skeleton and its motion, in the file's own axes and length unit."""

    names: tuple[str, ...]
    """Names of the joints, parents first, J of them."""
    parents: NDArray[np.int64]
    """Parent of each joint, -1 for the root, shape [J]."""
    offsets: Array
    """Offset from the parent [file units], shape [J, 3]."""
    tips: dict[str, Array]
    """Offset of the end site of each joint that has one [file units], shape [3]."""
    rotations: Array
    """Rotation of each joint relative to its parent, matrices, shape [F, J, 3, 3]."""
    translations: Array
    """Position of each joint relative to its parent [file units], shape [F, J, 3]."""
    frame_time: float
    """Time between two frames [s]."""

    def forward(self) -> tuple[Array, Array]:
        """World rotations [F, J, 3, 3] and positions [F, J, 3] (file units) of all joints."""
        rotations, positions = np.empty_like(self.rotations), np.empty_like(self.translations)
        for j, parent in enumerate(self.parents):
            if parent < 0:
                rotations[:, j], positions[:, j] = self.rotations[:, j], self.translations[:, j]
                continue
            rotations[:, j] = rotations[:, parent] @ self.rotations[:, j]
            moved = np.einsum("fij,fj->fi", rotations[:, parent], self.translations[:, j])
            positions[:, j] = positions[:, parent] + moved
        return rotations, positions

    def rest(self) -> Array:
        """Joint positions with no rotation, the root at the origin [file units], shape [J, 3]."""
        positions = np.zeros_like(self.offsets)
        for j, parent in enumerate(self.parents):
            if parent >= 0:
                positions[j] = positions[parent] + self.offsets[j]
        return positions


class _Lines:
    """The lines of a file that are not blank, with their numbers, and errors that name them."""

    def __init__(self, path: Path, text: str) -> None:
        self.name = path.name
        self.rows = [(i, row.split()) for i, row in enumerate(text.splitlines(), start=1) if row.strip()]
        self.at = 0

    def fault(self, what: str, line: int | None = None) -> DataError:
        """An error at a line, by default at the one read last."""
        number = line if line is not None else self.rows[max(0, min(self.at, len(self.rows)) - 1)][0]
        return DataError(f"{self.name}, line {number}: {what}")

    def next(self, wanted: str) -> list[str]:
        """The words of the next line."""
        if self.at >= len(self.rows):
            raise self.fault(f"the file ends where {wanted} should follow; export the motion again")
        self.at += 1
        return self.rows[self.at - 1][1]

    def numbers(self, words: list[str], what: str) -> list[float]:
        """Finite numbers of a size that a motion can have."""
        try:
            values = [float(word) for word in words]
        except ValueError:
            bad = next(word for word in words if not _is_number(word))
            raise self.fault(f"{what} must be numbers, got {bad[:40]!r}; export the motion again") from None
        for value in values:
            if not abs(value) <= LARGEST:
                raise self.fault(f"{what} must be finite and within +-{LARGEST:g}, got {value:g}; repair the motion")
        return values


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def read_bvh(path: Path) -> Recording:
    """Reads a motion file.

    Args:
        path: The file.

    Returns:
        The recording.

    Raises:
        DataError: The file is missing, empty, truncated, not BVH, or holds no or no finite motion.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise DataError(f"{path}: there is no such motion file; check the path of `motion`") from None
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror}); check the path of `motion`") from None
    except UnicodeDecodeError:
        raise DataError(f"{path.name}: is not a BVH text file (it holds binary data); give a .bvh file") from None
    lines = _Lines(path, text)
    if not lines.rows:
        raise DataError(f"{path.name}: the file is empty; export the motion again")
    if lines.rows[0][1] != ["HIERARCHY"]:
        shown = " ".join(lines.rows[0][1])[:40]
        raise lines.fault(f"a BVH file starts with 'HIERARCHY', got {shown!r}; give a .bvh file", lines.rows[0][0])
    lines.at = 1
    names, parents, offsets, tips, channels = _hierarchy(lines)
    values, frame_time = _motion(lines, sum(len(c) for c in channels))
    rotations, translations = _transforms(values, channels, np.array(offsets))
    return Recording(
        names=tuple(names),
        parents=np.array(parents),
        offsets=np.array(offsets),
        tips=tips,
        rotations=rotations,
        translations=translations,
        frame_time=frame_time,
    )


def _hierarchy(
    lines: _Lines,
) -> tuple[list[str], list[int], list[list[float]], dict[str, Array], list[list[str]]]:
    """Names, parents, offsets, end sites and channels of all joints, up to the line MOTION."""
    names: list[str] = []
    parents: list[int] = []
    offsets: list[list[float]] = []
    channels: list[list[str]] = []
    tips: dict[str, Array] = {}
    stack: list[int] = []
    while True:
        words = lines.next("the rest of the hierarchy, then MOTION,")
        head = words[0]
        if head in ("ROOT", "JOINT"):
            name = " ".join(words[1:])
            if (head == "ROOT") != (not names) or (head == "JOINT" and not stack):
                raise lines.fault(f"{head} {name!r} stands outside the one tree; give a file with a single skeleton")
            if not name or name in names:
                raise lines.fault(f"joint names must be given and unique, got {name!r}; rename the joint")
            names.append(name)
            parents.append(stack[-1] if stack else -1)
            _expect(lines, ["{"])
            offsets.append(_offset(lines))
            channels.append(_channels(lines))
            stack.append(len(names) - 1)
        elif [w.lower() for w in words[:2]] == ["end", "site"] and stack:
            _expect(lines, ["{"])
            tips[names[stack[-1]]] = np.array(_offset(lines))
            _expect(lines, ["}"])
        elif words == ["}"] and stack:
            stack.pop()
        elif words == ["MOTION"] and not stack and names:
            return names, parents, offsets, tips, channels
        else:
            wanted = "JOINT, End Site or '}'" if stack else ("MOTION" if names else "ROOT")
            raise lines.fault(f"expected {wanted}, got {' '.join(words)[:40]!r}; export the motion again")


def _expect(lines: _Lines, wanted: list[str]) -> None:
    got = lines.next(f"'{wanted[0]}'")
    if got != wanted:
        raise lines.fault(f"expected '{wanted[0]}', got {' '.join(got)[:40]!r}; export the motion again")


def _offset(lines: _Lines) -> list[float]:
    words = lines.next("OFFSET")
    if words[0] != "OFFSET" or len(words) != 4:
        raise lines.fault(f"expected OFFSET and three numbers, got {' '.join(words)[:40]!r}; export the motion again")
    return lines.numbers(words[1:], "OFFSET")


def _channels(lines: _Lines) -> list[str]:
    words = lines.next("CHANNELS")
    if words[0] != "CHANNELS" or len(words) < 2 or words[1] != str(len(words) - 2):
        raise lines.fault(f"expected CHANNELS, their number and names, got {' '.join(words)[:60]!r}; export again")
    for word in words[2:]:
        if word not in MOTION_CHANNELS:
            raise lines.fault(f"channels must be among {', '.join(MOTION_CHANNELS)}, got {word[:40]!r}; export again")
    if len(set(words[2:])) != len(words[2:]):
        raise lines.fault("a joint names the same channel twice; export the motion again")
    return words[2:]


def _motion(lines: _Lines, width: int) -> tuple[Array, float]:
    """Channel values [F, C] and the time between frames [s]."""
    words = lines.next("'Frames:'")
    if words[0] != "Frames:" or len(words) != 2 or not words[1].isdigit():
        raise lines.fault(f"expected 'Frames:' and a whole number, got {' '.join(words)[:40]!r}; export again")
    count = int(words[1])
    words = lines.next("'Frame Time:'")
    if words[:2] != ["Frame", "Time:"] or len(words) != 3:
        raise lines.fault(f"expected 'Frame Time:' and a number, got {' '.join(words)[:40]!r}; export again")
    frame_time = lines.numbers(words[2:], "Frame Time")[0]
    if not 1e-4 <= frame_time <= 1.0:
        raise lines.fault(f"Frame Time must be from 0.0001 s to 1 s, got {frame_time:g}; correct it")
    if count == 0:
        raise lines.fault("the file holds 0 frames; export the motion again")
    if width == 0:
        raise lines.fault("no joint has a channel, so nothing moves; export the motion again")
    found = len(lines.rows) - lines.at
    if found != count:
        what = "is truncated" if found < count else "holds more than it says"
        raise lines.fault(
            f"the file {what}: 'Frames: {count}' but {found} lines of motion; export again or correct 'Frames:'",
            lines.rows[-1][0],
        )
    values = np.empty((count, width))
    for row in range(count):
        words = lines.next("a frame")
        if len(words) != width:
            raise lines.fault(f"a frame must have {width} values, got {len(words)}; the file is truncated or damaged")
        values[row] = lines.numbers(words, "the values of a frame")
    return values, frame_time


def _transforms(values: Array, channels: list[list[str]], offsets: Array) -> tuple[Array, Array]:
    """Local rotations [F, J, 3, 3] and translations [F, J, 3] from the channels."""
    count = len(values)
    rotations = np.broadcast_to(np.eye(3), (count, len(channels), 3, 3)).copy()
    translations = np.broadcast_to(offsets, (count, len(channels), 3)).copy()
    column = 0
    for j, names in enumerate(channels):
        block = values[:, column : column + len(names)]
        column += len(names)
        turning = [i for i, name in enumerate(names) if name.endswith("rotation")]
        if turning:
            # Channels are listed outermost first: "Zrotation Yrotation Xrotation" is Rz Ry Rx.
            order = "".join(names[i][0] for i in turning)
            rotations[:, j] = Rotation.from_euler(order, block[:, turning], degrees=True).as_matrix()
        for i, name in enumerate(names):
            if name.endswith("position"):
                translations[:, j, "XYZ".index(name[0])] = block[:, i]
    return rotations, translations
