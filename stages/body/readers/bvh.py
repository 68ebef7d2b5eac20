"""Reader of BVH motion files: any hierarchy, any order of channels, any frame rate."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stages.body.readers.text import Lines, is_count, shown
from stages.body.recording import Recording

Array = NDArray[np.float64]

MOTION_CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation", "scale") for axis in "XYZ")
"""The names of channels that BVH knows, and scales, which some programs add."""

STRETCH = 0.01
"""Scales farther from 1 than this stretch bones [1]."""


def read_bvh(path: Path) -> Recording:
    """Reads a motion file.

    Args:
        path: The file.

    Returns:
        The recording.

    Raises:
        DataError: The file is missing, empty, truncated, not BVH, or holds no or no finite motion.
    """
    lines = Lines(path, "BVH", braces=True)
    if not _says(lines.peek(), "HIERARCHY"):
        got = shown(lines.peek())
        raise lines.fault(f"a BVH file starts with 'HIERARCHY', got {got}; name a .bvh file", lines.rows[0][0])
    lines.at = 1
    names, parents, offsets, tips, channels = _hierarchy(lines)
    values, frame_time = _motion(lines, sum(len(c) for c in channels))
    _refuse_stretch(lines, values, names, channels)
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
    lines: Lines,
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
        head = words[0].upper()
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
        elif _says(words, "MOTION") and not stack and names:
            return names, parents, offsets, tips, channels
        else:
            wanted = "JOINT, End Site or '}'" if stack else ("MOTION" if names else "ROOT")
            raise lines.fault(f"expected {wanted}, got {shown(words)}; export the motion again")


def _says(words: list[str], wanted: str) -> bool:
    """Whether a line is one keyword, in letters of either case."""
    return [word.upper() for word in words] == [wanted]


def _expect(lines: Lines, wanted: list[str]) -> None:
    got = lines.next(f"'{wanted[0]}'")
    if got != wanted:
        raise lines.fault(f"expected '{wanted[0]}', got {shown(got)}; export the motion again")


def _offset(lines: Lines) -> list[float]:
    words = lines.next("OFFSET")
    if words[0].upper() != "OFFSET" or len(words) != 4:
        raise lines.fault(f"expected OFFSET and three numbers, got {shown(words)}; export the motion again")
    return lines.numbers(words[1:], "OFFSET")


def _channels(lines: Lines) -> list[str]:
    words = lines.next("CHANNELS")
    if words[0].upper() != "CHANNELS" or len(words) < 2 or words[1] != str(len(words) - 2):
        raise lines.fault(f"expected CHANNELS, their number and names, got {shown(words)}; export again")
    channels = [word.capitalize() for word in words[2:]]
    for word in channels:
        if word not in MOTION_CHANNELS:
            raise lines.fault(f"channels must be among {', '.join(MOTION_CHANNELS)}, got {word[:40]!r}; export again")
    if len(set(channels)) != len(channels):
        raise lines.fault("a joint names the same channel twice; export the motion again")
    return channels


def _motion(lines: Lines, width: int) -> tuple[Array, float]:
    """Channel values [F, C] and the time between frames [s]."""
    counted = _after(lines, "Frames")
    if len(counted) != 1 or not is_count(counted[0]):
        raise lines.fault(f"expected 'Frames:' and a whole number, got {shown(counted)}; export again")
    count = int(counted[0])
    timed = _after(lines, "Frame Time")
    if len(timed) != 1:
        raise lines.fault(f"expected 'Frame Time:' and a number, got {shown(timed)}; export again")
    frame_time = lines.numbers(timed, "Frame Time")[0]
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


def _after(lines: Lines, label: str) -> list[str]:
    """The words after "label:" in the next line, with or without a space between them."""
    words = lines.next(f"'{label}:'")
    found, colon, value = " ".join(words).partition(":")
    if not colon or found.strip().lower() != label.lower():
        raise lines.fault(f"expected '{label}:', got {shown(words)}; export again")
    return value.split()


def _refuse_stretch(lines: Lines, values: Array, names: list[str], channels: list[list[str]]) -> None:
    """Refuses scales other than 1: people's bones keep their lengths."""
    flat = [(name, channel) for name, own in zip(names, channels, strict=True) for channel in own]
    for column, (name, channel) in enumerate(flat):
        off = np.abs(values[:, column] - 1) > STRETCH
        if channel.endswith("scale") and off.any():
            got = f"{channel} of {name!r} must be 1, got {values[off.argmax(), column]:g}"
            raise lines.fault(
                f"{got}; export the motion without scales", lines.rows[-len(values) + int(off.argmax())][0]
            )


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
