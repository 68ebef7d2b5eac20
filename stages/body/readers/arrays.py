"""Reader of motions stored as SMPL poses in .npz files: AMASS, SURREAL, and plain `poses` with `trans`.

- AMASS (N. Mahmood et al. 2019): `poses` [F, 156] of SMPL-H or [F, 165] of SMPL-X, or in parts, `root_orient` and
  `pose_body`; `trans` [F, 3], `gender`, `mocap_framerate` or `mocap_frame_rate`. The first 66 columns of all are the 22
  joints that SMPL has too; hands, jaw and eyes are left out.
- SURREAL (G. Varol et al. 2017): `pose_<sequence>` [F, 72] and `trans_<sequence>` [F, 3], many sequences in one file.
- Plain: `poses` or `pose`, [F, 72], [F, 66], [F, 24, 3] or [F, 22, 3], `trans`, and the rate as `fps`.

No file tells the bones' lengths without the licensed body model, so the embedded body's stand in for them. Which axis
is up is taken from the trunk, as people are upright most of the time.
"""

import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from model.body import GENDERS, JOINT_NAMES, PARENTS, load_free_body
from stages.body.readers.text import LARGEST
from stages.body.recording import Recording
from stages.spec import DataError

Array = NDArray[np.float64]

LARGEST_FILE = 2**31
"""Most bytes that the arrays of one file may take: hours of motion take a hundredth."""

BODY_JOINTS = 22
"""Joints that SMPL, SMPL-H and SMPL-X have in common, in the same order."""

WIDTHS = {66: "22 joints", 72: "SMPL", 156: "SMPL-H", 165: "SMPL-X"}
"""Numbers of a frame, and whose they are."""

RATES = ("mocap_framerate", "mocap_frame_rate", "fps", "frame_rate", "framerate")
"""Names under which files tell the frames per second."""

UPRIGHT = 0.5
"""Mean share of the trunk along an axis that makes it the vertical one [1]."""

STEEPEST = 50.0
"""Rotation vectors longer than this are no rotation vectors [rad]."""


def read_npz(path: Path, rate: float, sequence: str = "") -> Recording:
    """Reads a motion.

    Args:
        path: The file.
        rate: Frames per second where the file doesn't tell.
        sequence: Which sequence of a SURREAL file; may be left out if there is only one.

    Returns:
        The recording, y up [m], with the rotations of SMPL's joints.

    Raises:
        DataError: The file is missing or no .npz, holds pickled objects, or no or no finite motion.
    """
    arrays = _Arrays(path)
    pose, trans = _motion(arrays, sequence)
    frame_time = 1.0 / _rate(arrays, rate)
    count = len(pose)
    rotations = np.broadcast_to(np.eye(3), (count, 24, 3, 3)).copy()
    joints = min(pose.shape[1] // 3, 24) if pose.shape[1] == 72 else BODY_JOINTS
    vectors = pose[:, : 3 * joints].reshape(-1, 3)
    rotations[:, :joints] = Rotation.from_rotvec(vectors).as_matrix().reshape(count, joints, 3, 3)
    turn = _upright(rotations[:, 0])
    rotations[:, 0] = turn @ rotations[:, 0]
    offsets = _offsets(arrays)
    translations = np.broadcast_to(offsets, (count, 24, 3)).copy()
    translations[:, 0] = trans @ turn.T
    return Recording(
        names=JOINT_NAMES,
        parents=np.array(PARENTS, dtype=np.int64),
        offsets=offsets,
        tips={},
        rotations=rotations,
        translations=translations,
        frame_time=frame_time,
        bodily=True,
    )


class _Arrays:
    """The arrays of an .npz file, read one by one, with errors that name the file and the array."""

    def __init__(self, path: Path) -> None:
        self.path, self.name = path, path.name
        try:
            with zipfile.ZipFile(path) as archive:
                size = sum(entry.file_size for entry in archive.infolist())
                self.names = [entry.filename.removesuffix(".npy") for entry in archive.infolist()]
        except FileNotFoundError:
            raise DataError(f"{path}: there is no such motion file; check the path of `motion`") from None
        except OSError as error:
            raise DataError(f"{path}: cannot be read ({error.strerror}); check the path of `motion`") from None
        except (zipfile.BadZipFile, ValueError, NotImplementedError):
            raise DataError(
                f"{self.name}: is not a whole .npz file; copy it again, or save it by numpy.savez"
            ) from None
        if size > LARGEST_FILE:
            raise DataError(f"{self.name}: its arrays take {size} bytes, the limit is {LARGEST_FILE}; split the motion")

    def get(self, key: str) -> NDArray[np.generic]:
        """One array.

        Raises:
            DataError: It can't be read, or holds pickled objects, which could run code.
        """
        try:
            with np.load(self.path, allow_pickle=False) as archive:
                return np.asarray(archive[key])
        except ValueError as error:
            if "pickle" in str(error):
                why = "holds pickled objects, which could run code; save it as a plain array"
            else:
                why = "is damaged; copy the file again"
        except (OSError, EOFError, KeyError, MemoryError, SyntaxError, TypeError, zipfile.BadZipFile, zlib.error):
            why = "is damaged; copy the file again"
        except (NotImplementedError, RuntimeError, OverflowError, AttributeError):  # ciphers, odd headers
            why = "can't be read; save it by numpy.savez"
        raise DataError(f"{self.name}: array {key!r} {why}")

    def numbers(self, key: str) -> Array:
        """One array of finite numbers.

        Raises:
            DataError: It is no such array.
        """
        array = self.get(key)
        if array.dtype.kind not in "fiu":
            raise DataError(f"{self.name}: {key} must hold numbers, got type {array.dtype}; save it as float32")
        values = array.astype(np.float64)
        wrong = ~(np.abs(values) <= LARGEST)
        if wrong.any():
            place = np.unravel_index(int(wrong.argmax()), wrong.shape)
            at = ", ".join(str(int(i)) for i in place)
            what = f"must be finite and within +-{LARGEST:g}, got {values[place]:g} at [{at}]"
            raise DataError(f"{self.name}: {key} {what}; repair the motion")
        return values


def motions_of(path: Path) -> list[str]:
    """Names of the sequences of a file, "" for the one motion of a file that isn't SURREAL's; none without poses.

    Raises:
        DataError: The file can't be read.
    """
    names = _Arrays(path).names
    if {"poses", "pose", "pose_body"} & set(names):
        return [""]
    return sequences_of(names)


def sequences_of(names: list[str]) -> list[str]:
    """Names of the sequences of a SURREAL file, from the names of its arrays."""
    return sorted(n.removeprefix("pose_") for n in names if n.startswith("pose_") and f"trans_{n[5:]}" in names)


def _motion(arrays: _Arrays, sequence: str) -> tuple[Array, Array]:
    """Rotation vectors [F, C] and path of the root [F, 3]."""
    names = arrays.names
    inside = sequences_of(names)
    if sequence or (inside and "poses" not in names):
        if not sequence and len(inside) > 1:
            few = ", ".join(inside[:4])
            example = f"{arrays.name}:{inside[0]}"
            raise DataError(f"{arrays.name}: holds {len(inside)} sequences ({few}...); name one, such as {example}")
        sequence = sequence or inside[0]
        if sequence not in inside:
            raise DataError(
                f"{arrays.name}: there is no sequence {sequence[:40]!r}; it has {', '.join(inside[:8]) or 'none'}"
            )
        key, path = f"pose_{sequence}", f"trans_{sequence}"
    elif "root_orient" in names and "pose_body" in names and "poses" not in names:
        root, body = arrays.numbers("root_orient"), arrays.numbers("pose_body")
        if root.ndim != 2 or root.shape[1] != 3 or body.shape != (len(root), 63):
            shapes = f"{root.shape} and {body.shape}"
            raise DataError(f"{arrays.name}: root_orient and pose_body must be [F, 3] and [F, 63], got {shapes}")
        return _checked(arrays, "pose_body", np.hstack([root, body]), "trans")
    else:
        key, path = ("poses" if "poses" in names else "pose"), "trans"
    for wanted in (key, path):
        if wanted not in names:
            there = ", ".join(names[:12]) or "nothing"
            raise DataError(f"{arrays.name}: has no array {wanted!r}, only {there}; name a file of poses and trans")
    return _checked(arrays, key, arrays.numbers(key), path)


def _checked(arrays: _Arrays, key: str, pose: Array, path: str) -> tuple[Array, Array]:
    trans = arrays.numbers(path)
    if pose.ndim == 3 and pose.shape[2] == 3:
        pose = pose.reshape(len(pose), 3 * pose.shape[1])
    if pose.ndim != 2 or pose.shape[1] not in WIDTHS:
        known = ", ".join(f"{width} ({whose})" for width, whose in WIDTHS.items())
        raise DataError(f"{arrays.name}: {key} must have {known} numbers a frame, got shape {list(pose.shape)}")
    if len(pose) == 0:
        raise DataError(f"{arrays.name}: {key} holds 0 frames; export the motion again")
    if trans.shape != (len(pose), 3):
        raise DataError(
            f"{arrays.name}: {path} must have shape [{len(pose)}, 3] as {key} does, got {list(trans.shape)}"
        )
    body = pose[:, : 3 * BODY_JOINTS].reshape(len(pose), -1, 3)
    longest = float(np.linalg.norm(body, axis=-1).max())
    if longest > STEEPEST:
        raise DataError(f"{arrays.name}: {key} must be rotation vectors in radians, got one of length {longest:g}")
    return pose, trans


def _rate(arrays: _Arrays, rate: float) -> float:
    """Frames per second."""
    for key in RATES:
        if key in arrays.names:
            value = arrays.numbers(key)
            if value.size != 1 or not 1.0 <= float(value.reshape(())) <= 10000.0:
                got = np.array2string(value.ravel()[:3])
                raise DataError(f"{arrays.name}: {key} must be from 1 to 10000 frames/s, got {got}; correct it")
            return float(value.reshape(()))
    return rate


def _upright(root: Array) -> Array:
    """Turn from the file's world to one with y up, from the root's rotations [F, 3, 3]; z is up if nothing tells."""
    trunk = root[:, :, 1].mean(axis=0)
    if abs(trunk[1]) > UPRIGHT and abs(trunk[1]) > abs(trunk[2]):
        return np.eye(3) if trunk[1] > 0 else np.diag([1.0, -1.0, -1.0])  # y down: a camera's axes
    return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def _offsets(arrays: _Arrays) -> Array:
    """Bones of the mean adult of the file's gender [m], shape [24, 3]."""
    gender = "female"
    if "gender" in arrays.names:
        told: Mapping[str, str] = {g: g for g in GENDERS}
        word = arrays.get("gender")
        text = word.reshape(-1)[0] if word.size and word.dtype.kind in "US" else ""
        text = text.decode("ascii", "ignore") if isinstance(text, bytes) else str(text)
        gender = told.get(text.strip().lower(), gender)
    joints = load_free_body(gender).joint_template
    offsets = np.zeros((24, 3))
    offsets[1:] = joints[1:] - joints[PARENTS[1:]]
    return offsets
