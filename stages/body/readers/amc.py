"""Reader of Acclaim motions (AMC), with the skeleton (ASF) that each belongs to."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stages.body.readers.asf import Bone, Skeleton, read_asf
from stages.body.readers.text import Lines, is_count, shown
from stages.body.recording import Recording
from stages.spec import DataError

Array = NDArray[np.float64]


def read_amc(path: Path, rate: float) -> Recording:
    """Reads a motion and its skeleton.

    Args:
        path: The .amc file.
        rate: Frames per second: the file doesn't tell; CMU's are at 120, a few at 60.

    Returns:
        The recording [m]; each joint is named after the bone that starts there.

    Raises:
        DataError: A file is missing, empty, truncated, or they don't belong together.
    """
    skeleton = read_asf(skeleton_of(path))
    lines = Lines(path, "AMC", comment="#")
    degrees = _head(lines, skeleton.degrees)
    values = _frames(lines, skeleton)
    count = len(values[0])
    offsets = np.zeros((len(skeleton.bones), 3))
    rotations, translations = [], []
    for j, (bone, parent) in enumerate(zip(skeleton.bones, skeleton.parents, strict=True)):
        offsets[j] = skeleton.bones[parent].tip if parent >= 0 else 0.0
        at_rest = skeleton.start if parent < 0 else offsets[j]
        rotations.append(_rotations(bone, values[j], degrees))
        shifts = np.zeros((count, 3))
        for column, freedom in enumerate(bone.freedoms):
            if freedom[0] == "t":
                shifts[:, "xyz".index(freedom[1])] = values[j][:, column] * skeleton.scale
        # The root's shifts are in the world's axes, those of bones in their own.
        translations.append(at_rest + (shifts if parent < 0 else shifts @ bone.axes.T))
    leaves = set(range(len(skeleton.bones))) - set(skeleton.parents)
    return Recording(
        names=tuple(bone.name for bone in skeleton.bones),
        parents=np.array(skeleton.parents),
        offsets=offsets,
        tips={skeleton.bones[j].name: skeleton.bones[j].tip for j in sorted(leaves)},
        rotations=np.stack(rotations, axis=1),
        translations=np.stack(translations, axis=1),
        frame_time=1.0 / rate,
    )


def skeleton_of(path: Path) -> Path:
    """The skeleton of a motion: beside it, of its own name or of the subject's (`01.asf` for `01_05.amc`).

    Raises:
        DataError: There is none.
    """
    subject = path.stem.split("_")[0]
    for name in (f"{path.stem}.asf", f"{subject}.asf", f"{path.stem}.ASF", f"{subject}.ASF"):
        if (beside := path.with_name(name)).is_file():
            return beside
    raise DataError(f"{path.name}: there is no skeleton {subject}.asf or {path.stem}.asf beside it; put it there")


def _head(lines: Lines, degrees: bool) -> bool:
    """Skips what stands before the frames; returns whether angles are in degrees."""
    while lines.peek() and lines.peek()[0].startswith(":"):
        word = lines.next("a heading")[0].upper()
        if word in (":DEGREES", ":RADIANS"):
            degrees = word == ":DEGREES"
    if not lines.more():
        raise lines.fault("the file holds 0 frames; export the motion again")
    if lines.peek() != ["1"] and not (len(lines.peek()) == 1 and is_count(lines.peek()[0])):
        raise lines.fault(f"expected the number of the first frame, got {shown(lines.peek())}; name an AMC file", 1)
    return degrees


def _frames(lines: Lines, skeleton: Skeleton) -> list[Array]:
    """The numbers of each bone in each frame, shape [F, its freedoms] each; what a frame leaves out is 0."""
    place = {bone.name: j for j, bone in enumerate(skeleton.bones)}
    frames: list[list[list[float]]] = []
    needed = {j for j, bone in enumerate(skeleton.bones) if bone.freedoms}
    while lines.more():
        number = lines.next("a frame")
        if len(number) != 1 or not is_count(number[0]):
            raise lines.fault(f"expected the number of a frame, got {shown(number)}; the file is damaged")
        started = lines.rows[lines.at - 1][0]
        frame: list[list[float]] = [[] for _ in place]
        seen: set[int] = set()
        while lines.more() and not (len(lines.peek()) == 1 and is_count(lines.peek()[0])):
            name, *words = lines.next("a bone")
            j = place.get(name, -1)
            if j < 0 or j in seen:
                what = "moves twice in a frame" if j in seen else "is not in the skeleton"
                raise lines.fault(f"bone {name[:40]!r} {what}; give the motion its own ASF file")
            if len(words) != len(skeleton.bones[j].freedoms):
                wanted = len(skeleton.bones[j].freedoms)
                raise lines.fault(f"bone {name!r} must have {wanted} values, got {len(words)}; the file is damaged")
            frame[j] = lines.numbers(words, "the values of a frame")
            seen.add(j)
        lost = needed - seen
        if lost:
            what = f"frame {number[0]} lacks {len(lost)} of {len(needed)} bones, such as"
            raise lines.fault(f"{what} {skeleton.bones[min(lost)].name!r}; the file is truncated or damaged", started)
        frames.append(frame)
    return [np.array([frame[j] for frame in frames]).reshape(len(frames), -1) for j in range(len(place))]


def _rotations(bone: Bone, values: Array, degrees: bool) -> Array:
    """Rotation of a joint in the skeleton's axes, C M C^-1, shape [F, 3, 3]."""
    turning = [i for i, freedom in enumerate(bone.freedoms) if freedom[0] == "r"]
    if not turning:
        return np.broadcast_to(np.eye(3), (len(values), 3, 3)).copy()
    order = "".join(bone.freedoms[i][1] for i in turning)
    own = Rotation.from_euler(order, values[:, turning], degrees=degrees).as_matrix()
    return np.asarray(bone.axes @ own @ bone.axes.T)
