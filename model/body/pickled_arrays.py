"""Arrays from what `safe_pickle` found in a pickle: of numpy, of scipy's sparse matrices, and of chumpy around them.

Nothing of the file is trusted: types are those of plain numbers, sizes are held against the bytes that are there.
Layout: `numpy.ndarray.__reduce__`, `numpy.dtype.__reduce__`, scipy's csc and csr, chumpy's ch.py and reordering.py.
"""

import math
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.body.refusal import BodyFileError
from model.body.safe_pickle import Held, described

MOST_FILLED = 2**23
"""Entries of a sparse matrix: the regressor of SMPL-X has half a million."""

DEEPEST = 8
"""Objects of chumpy that may stand inside one another."""


def as_array(value: Any, depth: int = 0) -> NDArray[Any]:
    """The numbers that a value of `read_pickle` stands for.

    Args:
        value: An array, a sparse matrix, or an object of chumpy around one.
        depth: Objects of chumpy around it.

    Returns:
        The array; a sparse matrix is filled up.

    Raises:
        BodyFileError: It is none of these, or isn't whole.
    """
    if isinstance(value, Held) and value.is_chumpy:
        if depth >= DEEPEST:
            raise BodyFileError(f"has objects of chumpy more than {DEEPEST} deep")
        return _chumpy(value, depth)
    match value.name if isinstance(value, Held) else "":
        case "_reconstruct":
            return _array(value)
        case "_frombuffer":
            return _from_buffer(value)
        case "csc_matrix" | "csc_array" | "csr_matrix" | "csr_array":
            return _sparse(value)
    raise BodyFileError(f"is {described(value)}, not an array")


def _array(held: Held) -> NDArray[Any]:
    """What `ndarray.__setstate__` makes of its state: version, shape, dtype, whether Fortran's order, bytes."""
    state = held.state
    if not isinstance(state, tuple) or len(state) not in (4, 5):
        raise BodyFileError("is an array without its content")
    shape, dtype, fortran, raw = state[-4:]
    array = _numbers(dtype, raw, _shape(shape)[::-1] if fortran else _shape(shape))
    return array.T if fortran else array


def _from_buffer(held: Held) -> NDArray[Any]:
    """What `numpy._core.numeric._frombuffer` makes: the array form of the fifth protocol."""
    if len(held.arguments) != 4:
        raise BodyFileError("is an array without its content")
    raw, dtype, shape, order = held.arguments
    array = _numbers(dtype, raw, _shape(shape)[::-1] if order == "F" else _shape(shape))
    return array.T if order == "F" else array


def _numbers(dtype: Any, raw: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    kind = _dtype(dtype)
    if not isinstance(raw, str | bytes):
        raise BodyFileError("is an array without its bytes")
    needed = math.prod(shape) * kind.itemsize
    if needed != len(raw):
        raise BodyFileError(f"is an array of shape {shape}, {needed} bytes, but {len(raw)} bytes are there")
    try:
        raw = raw.encode("latin1") if isinstance(raw, str) else raw  # Python 2's texts are bytes
    except UnicodeEncodeError:
        raise BodyFileError("is an array without its bytes") from None
    return np.frombuffer(raw, kind).reshape(shape)


def _shape(value: Any) -> tuple[int, ...]:
    value = (value,) if _is_count(value) else value
    if not isinstance(value, tuple) or len(value) > 4 or not all(_is_count(size) for size in value):
        raise BodyFileError("is an array whose shape isn't up to four whole numbers from 0 up")
    return value


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**40


def _dtype(held: Any) -> np.dtype[Any]:
    """The type of an array: plain numbers only."""
    code, order = held, "="
    if isinstance(held, Held) and held.name == "dtype":
        code = held.arguments[0] if held.arguments else ""
        if isinstance(held.state, tuple) and len(held.state) > 1:
            order = held.state[1]
            code = code if all(part is None for part in held.state[2:5]) else "a record"
    code = code if isinstance(code, str) else ""
    found = re.fullmatch(r"([<>=|]?)(b1|[iu][1248]|f[248])", code)
    if not found or order not in ("<", ">", "=", "|"):
        raise BodyFileError(f"is an array of type {code[:20] or '?'!r}, not of numbers")
    return np.dtype((found[1] or order).replace("|", "=") + found[2])


def _sparse(held: Held) -> NDArray[np.float64]:
    """A matrix of compressed columns or rows, filled up."""
    state = held.state if isinstance(held.state, dict) else {}
    missing = [name for name in ("data", "indices", "indptr") if name not in state]
    shape = _shape(state.get("_shape", state.get("shape", ())))
    if missing or len(shape) != 2:
        raise BodyFileError(f"is a sparse matrix without its {missing[0] if missing else 'shape'}")
    data, indices, starts = (as_array(state[name], DEEPEST) for name in ("data", "indices", "indptr"))
    by_row = held.name.startswith("csr")
    lines, places = shape if by_row else shape[::-1]
    if math.prod(shape) > MOST_FILLED:
        raise BodyFileError(f"is a sparse matrix of shape {shape}, which has more than {MOST_FILLED} entries")
    whole = all(part.ndim == 1 and (part is data or part.dtype.kind in "iu") for part in (data, indices, starts))
    if not whole or len(starts) != lines + 1 or len(data) != len(indices):
        raise BodyFileError("is a sparse matrix whose parts don't belong together")
    counts = starts[1:].astype(np.int64) - starts[:-1]
    if starts[0] != 0 or (counts < 0).any() or starts[-1] != len(data):
        raise BodyFileError("is a sparse matrix whose parts don't belong together")
    if len(indices) and (indices.min() < 0 or indices.max() >= places):
        raise BodyFileError(f"is a sparse matrix with an index out of its {places} places")
    filled = np.zeros((lines, places))
    np.add.at(filled, (np.repeat(np.arange(lines), counts), indices.astype(np.int64)), data.astype(np.float64))
    return filled if by_row else filled.T


def _chumpy(held: Held, depth: int) -> NDArray[Any]:
    """The value of an object of chumpy that holds or reorders an array (chumpy: ch.py, reordering.py)."""
    state = held.state if isinstance(held.state, dict) else {}

    def part(name: str) -> Any:
        if name not in state:
            raise BodyFileError(f"is {described(held)} without {name!r}")
        return state[name]

    match held.name:
        case "Ch":
            return as_array(part("x"), depth + 1)
        case "Select":
            flat = as_array(part("a"), depth + 1).reshape(-1)
            places = as_array(part("idxs"), depth + 1)
            if places.dtype.kind not in "iu" or (places.size and (places.min() < 0 or places.max() >= len(flat))):
                raise BodyFileError(f"is {described(held)} with an index out of its {len(flat)} places")
            chosen = flat[places]
            return chosen if "preferred_shape" not in state else _reshaped(chosen, state["preferred_shape"], held)
        case "Reshape":
            return _reshaped(as_array(part("a"), depth + 1), part("newshape"), held)
        case "transpose":
            array, axes = as_array(part("a"), depth + 1), state.get("axes")
            if axes is not None and sorted(_shape(axes)) != list(range(array.ndim)):
                raise BodyFileError(f"is {described(held)} with axes that aren't the array's")
            return np.transpose(array, axes)
    raise BodyFileError(f"is {described(held)}, which is no stored array; write the array itself into the file")


def _reshaped(array: NDArray[Any], shape: Any, held: Held) -> NDArray[Any]:
    sizes = shape if isinstance(shape, tuple) else (shape,)
    if len(sizes) > 4 or not all(size == -1 or _is_count(size) for size in sizes):
        raise BodyFileError(f"is {described(held)} with a shape that isn't one")
    try:
        return array.reshape(sizes)
    except ValueError:
        raise BodyFileError(f"is {described(held)} of shape {array.shape}, which can't be had as {sizes}") from None
