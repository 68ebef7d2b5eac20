"""Reads body models from the files of SMPL, SMPL-H and SMPL-X, as their users have them.

A file is a pickle (`basicModel_*.pkl`, `SMPL_*.pkl`, of Python 2 or 3, with arrays of chumpy or numpy and a sparse or
dense regressor) or an npz archive of the same arrays. Neither is trusted: see `safe_pickle` and `safe_npz`. Every array
is checked before it is used, and what isn't that of a body in metres, y up, is refused with one line.

Of SMPL-H and SMPL-X the 24 joints of SMPL are kept, see `model.body.extra_joints`. Of SMPL-X the betas of shape are
kept and those of expression are not.

Source: Loper et al., SMPL (2015); Romero et al., Embodied Hands (2017); Pavlakos et al., SMPL-X (2019); the names of
the arrays are those of the PyPI package smplx.
"""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from model.body.extra_joints import KEPT, fold_correctives, fold_weights, kept_joints, tree_of
from model.body.model import BodyModel
from model.body.pickled_arrays import as_array
from model.body.refusal import BodyFileError
from model.body.safe_npz import NpzArrays
from model.body.safe_pickle import read_pickle
from model.body.skeleton import JOINT_NAMES, PARENTS

MOST_FILE_BYTES = 2**30
"""Largest file that is read [bytes]; the largest of SMPL-X has half of that."""

TOLERANCE = 1e-3
"""How far weights may be from summing to 1, and below 0 [1]."""

REGRESSOR_TOLERANCE = 0.05
"""How far a joint's regressor may be from summing to 1 [1]; with another sum it wouldn't move with the body."""

HEIGHT = (0.3, 3.0)
"""Height of a body, from an infant's up [m]; what is outside isn't in metres."""

LARGEST_BETA = 1.0
"""Farthest that a beta of 1 may move a vertex [m]."""

LARGEST_CORRECTIVE = 1.0
"""Farthest that one entry of a joint's rotation may move a vertex [m]."""

LARGEST_REGRESSOR = 5.0
"""Largest entry of the joint regressor [1]: those of SMPL lie between 0 and 1."""

OUTSIDE = 0.1
"""How far a joint may be outside the box around the body [m]."""

UPRIGHT = ("head", "neck", "pelvis", "left_knee", "left_ankle")
"""Joints from top to bottom of who stands upright along y."""

LEFT_TO_RIGHT = ("left_wrist", "left_elbow", "pelvis", "right_elbow", "right_wrist")
"""Joints along -x of who stands in the T-pose, facing +z."""

MOST_ENTRIES = 2**26
"""Numbers in one array: the largest of SMPL-X has 15 million."""

X_SHAPES, X_ALL = 300, 400
"""SMPL-X stores 300 directions of shape and 100 of expression; its reduced files 10 and 10, as smplx reads them."""

_REMEDY = "get the file anew from where it is published"


def read_smpl(path: Path, gender: str, beta_count: int | None = None) -> BodyModel:
    """Reads a body model of SMPL's schema.

    Args:
        path: A pickle or npz file; which of them it is shows in its content.
        gender: `female`, `male` or `neutral`: files don't say it.
        beta_count: Number of betas to keep; all of them if left out.

    Returns:
        The model, with 24 joints and read-only arrays.

    Raises:
        BodyFileError: The file can't be read, isn't trustworthy or isn't a body's; one line.
    """
    return parse_smpl(file_content(path), str(path), gender, beta_count)


def file_content(path: Path) -> bytes:
    """The bytes of a file, if they aren't too many.

    Raises:
        BodyFileError: It can't be read, or is larger than any body model; one line.
    """
    try:
        size = path.stat().st_size
        if size > MOST_FILE_BYTES:
            limit = f"a body model has {MOST_FILE_BYTES} at most"
            raise BodyFileError(f"{path}: has {size} bytes, {limit}; name a body model's file")
        return path.read_bytes()
    except OSError as error:
        raise BodyFileError(f"{path}: {error.strerror}; name a body model's file") from None


def parse_smpl(content: bytes, name: str, gender: str, beta_count: int | None = None) -> BodyModel:
    """The body model of a file's content; `name` names it in errors. See `read_smpl`."""
    if gender not in ("female", "male", "neutral"):
        raise ValueError(f"gender must be female, male or neutral, got {gender!r}")
    try:
        return _model(_Arrays(content), gender, beta_count)
    except BodyFileError as error:
        # Names in the file are the file's: they may hold anything, a line's end among it.
        line = "".join(sign if sign.isprintable() else "?" for sign in str(error))
        raise BodyFileError(f"{name}: {line}") from None


class _Arrays:
    """The arrays of a file, each checked when it is asked for."""

    def __init__(self, content: bytes) -> None:
        if not content:
            raise BodyFileError(f"the file is empty; {_REMEDY}")
        if content.startswith(b"PK"):
            self._source: Any = NpzArrays(content)
        elif content[:1] in (b"\x80", b"(", b"}", b"]", b"c"):
            self._source = read_pickle(content)
        else:
            raise BodyFileError(f"neither a pickle nor an npz archive: it begins with {content[:16]!r}; {_REMEDY}")

    def has(self, name: str) -> bool:
        """Whether there is such an array."""
        return name in self._source

    def __call__(self, name: str, shape: tuple[int | None, ...], what: str) -> NDArray[np.float64]:
        """The array `name` in double precision.

        Args:
            name: Its key.
            shape: Its shape; None where any size will do.
            what: The meaning of its axes, for errors.

        Raises:
            BodyFileError: It is missing, of another shape, or not finite.
        """
        if name not in self._source:
            there = ", ".join([str(name)[:40] for name in sorted(self._source)[:12]]) or "nothing"
            raise BodyFileError(f"{name} is missing, there is {there}; name a model's file, not a motion or a result")
        try:
            found = self._source[name]
            array = found if isinstance(found, np.ndarray) else as_array(found)
        except BodyFileError as error:
            raise BodyFileError(f"{name} {error}; {_REMEDY}") from None
        fits = array.ndim == len(shape) and all(want in (None, size) for want, size in zip(shape, array.shape))
        if not fits or array.size == 0:
            wanted = ", ".join(part if size is None else str(size) for part, size in zip(what.split(), shape))
            raise BodyFileError(f"{name} must have shape ({wanted}), got {array.shape}; {_REMEDY}")
        if array.size > MOST_ENTRIES:
            raise BodyFileError(f"{name} has {array.size} numbers, must have <= {MOST_ENTRIES}; {_REMEDY}")
        values = array.astype(np.float64, order="C")
        if not np.isfinite(values).all():
            place = tuple(int(i) for i in np.unravel_index(int(np.isfinite(values).argmin()), values.shape))
            raise BodyFileError(f"{name}{list(place)} is {values[place]:g}, all must be finite; {_REMEDY}")
        return values


def _model(arrays: _Arrays, gender: str, beta_count: int | None) -> BodyModel:
    template = arrays("v_template", (None, 3), "V xyz")
    count = len(template)
    _check_height(template)
    tree = tree_of(arrays("kintree_table", (2, None), "row joints"))
    joints = len(tree)
    weights = _weights(arrays("weights", (count, joints), "V K"))
    regressor = arrays("J_regressor", (joints, count), "K V")
    _check_regressor(regressor)
    faces = _faces(arrays("f", (None, 3), "F corner"), template)
    shapes = _shapes(arrays("shapedirs", (count, 3, None), "V xyz betas"), joints)
    if beta_count is not None and shapes.shape[2] < beta_count:
        raise BodyFileError(f"shapedirs has {shapes.shape[2]} betas, {beta_count} are needed; name a file with more")
    shapes = shapes[..., :beta_count]
    posedirs = None
    if arrays.has("posedirs"):
        posedirs = arrays("posedirs", (count, 3, 9 * (joints - 1)), "V xyz features")
        _check_largest("posedirs", posedirs, LARGEST_CORRECTIVE)
        posedirs = fold_correctives(posedirs, joints) if posedirs.any() else None
    kept = kept_joints(joints)
    # J (v + S b) = J v + (J S) b: the joints are as linear in the betas as the vertices are.
    # Sparse products add in one order; dense ones in another with another number of threads.
    rows = sp.csr_array(regressor[kept])
    joint_template = rows @ template
    joint_shapedirs = (rows @ shapes.reshape(count, -1)).reshape(len(kept), 3, -1)
    _check_frame(joint_template, template)
    model = BodyModel(
        gender=gender,
        v_template=template.astype(np.float32),
        shapedirs=shapes.astype(np.float32),
        joint_template=joint_template,
        joint_shapedirs=joint_shapedirs,
        weights=fold_weights(weights, tree).astype(np.float32),
        parents=PARENTS.copy(),
        faces=faces,
        posedirs=None if posedirs is None else posedirs.astype(np.float32),
    )
    for value in vars(model).values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return model


def _check_height(template: NDArray[np.float64]) -> None:
    height, largest = float(np.ptp(template[:, 1])), float(np.abs(template).max())
    if not HEIGHT[0] <= height <= HEIGHT[1] or largest > 2 * HEIGHT[1]:
        raise BodyFileError(
            f"v_template is {height:.3g} m high (y) and reaches {largest:.3g} m from the origin; a body is "
            f"{HEIGHT[0]:g} to {HEIGHT[1]:g} m high: give it in metres, y up"
        )


def _weights(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Skinning weights, rows summing to 1 exactly."""
    sums = weights.sum(axis=1)
    row = int(np.abs(sums - 1).argmax())
    if abs(sums[row] - 1) > TOLERANCE:
        limit = f"must be 1 within {TOLERANCE:g}"
        raise BodyFileError(f"weights of vertex {row} sum to {sums[row]:.6g}, {limit}; {_REMEDY}")
    if weights.min() < -TOLERANCE:
        row = int(weights.min(axis=1).argmin())
        raise BodyFileError(f"weights of vertex {row} reach {weights.min():.6g}, must be >= 0; {_REMEDY}")
    weights = np.clip(weights, 0.0, None)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _check_regressor(regressor: NDArray[np.float64]) -> None:
    _check_largest("J_regressor", regressor, LARGEST_REGRESSOR, "")
    sums = regressor.sum(axis=1)
    row = int(np.abs(sums - 1).argmax())
    if abs(sums[row] - 1) > REGRESSOR_TOLERANCE:
        limit = f"must be 1 within {REGRESSOR_TOLERANCE:g}"
        raise BodyFileError(f"J_regressor of joint {row} sums to {sums[row]:.6g}, {limit}; {_REMEDY}")


def _faces(corners: NDArray[np.float64], template: NDArray[np.float64]) -> NDArray[np.int32]:
    """Triangles, wound outwards."""
    count = len(template)
    wrong = (corners < 0) | (corners >= count) | (corners != np.rint(corners))
    if wrong.any():
        face = int(wrong.any(axis=1).argmax())
        raise BodyFileError(
            f"f: face {face} has corners {[float(c) for c in corners[face]]}, there are vertices 0 to {count - 1}; "
            f"{_REMEDY}"
        )
    faces = corners.astype(np.int32)
    a, b, c = (faces[:, k] for k in range(3))
    flat = (a == b) | (b == c) | (c == a)
    if flat.any():
        face = int(flat.argmax())
        raise BodyFileError(f"f: face {face} has corners {faces[face].tolist()}, they must be three; {_REMEDY}")
    x = template - template.mean(axis=0)
    volume = float(np.einsum("fd,fd->", x[a], np.cross(x[b], x[c]))) / 6
    if volume <= 0:
        raise BodyFileError(
            f"f: the faces enclose {volume:.3g} m^3, must be > 0; order corners counter-clockwise seen from outside"
        )
    return faces


def _shapes(shapes: NDArray[np.float64], joints: int) -> NDArray[np.float64]:
    """Directions of shape; of SMPL-X without those of expression, which stand behind them."""
    if joints == KEPT["SMPL-X"]:
        shapes = shapes[..., : X_SHAPES if shapes.shape[2] >= X_ALL else 10]
    _check_largest("shapedirs", shapes, LARGEST_BETA)
    if not shapes.any():
        raise BodyFileError(f"shapedirs is 0 everywhere: no beta would change the body; {_REMEDY}")
    return shapes


def _check_largest(name: str, values: NDArray[np.float64], limit: float, unit: str = " m") -> None:
    largest = float(np.abs(values).max())
    if largest > limit:
        raise BodyFileError(f"{name} reaches {largest:.3g}{unit}, must be <= {limit:g}{unit}; {_REMEDY}")


def _check_frame(joints: NDArray[np.float64], template: NDArray[np.float64]) -> None:
    """Refuse a skeleton that isn't in the body, doesn't stand upright along y or has its left side along -x."""
    out = np.maximum(template.min(axis=0) - joints, joints - template.max(axis=0)).max(axis=1)
    if out.max() > OUTSIDE:
        k = int(out.argmax())
        where = f"J_regressor puts joint {k} ({JOINT_NAMES[k]}) {out[k]:.3g} m out of the body"
        raise BodyFileError(f"{where}, must be <= {OUTSIDE:g} m; {_REMEDY}")
    for axis, names, side in ((1, UPRIGHT, "below"), (0, LEFT_TO_RIGHT, "to the right of")):
        for one, other in itertools.pairwise(names):
            difference = joints[JOINT_NAMES.index(one), axis] - joints[JOINT_NAMES.index(other), axis]
            if difference <= 0:
                raise BodyFileError(
                    f"J_regressor puts {one} {-difference:.3g} m {side} {other}; the body must stand upright along y, "
                    "in the T-pose, its left arm along +x"
                )
