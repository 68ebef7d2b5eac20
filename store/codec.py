"""Arrays <-> what stands in the file: fixed point for positions, exact types for the rest."""

from __future__ import annotations

import numpy as np


def encode(values: np.ndarray, dtype: str, quantum: float) -> np.ndarray:
    """Turn `values` into the array to store.

    Args:
        values: Any shape. Floats for "float32" and for fixed point, integers for "int8" .. "int64", bool for "bool".
        dtype: Type in the file; "any" keeps the type given (bool, integer, float32 or float64).
        quantum: Step of the fixed point, in the dataset's units; 0 stores `values` as they are.

    Returns:
        C-contiguous little-endian array of type `dtype`; under fixed point, `rint(values / quantum)`, so that decoding
        is off by `quantum` / 2 at most.

    Raises:
        ValueError: NaN or infinity, a value outside the type's range, or a type that `dtype` can't hold; one line.
    """
    values = np.asarray(values)
    if values.dtype.kind == "f":
        _refuse_non_finite(values)
    if quantum:
        return _fixed_point(values, np.dtype(dtype), quantum)
    if dtype == "any":
        if values.dtype.kind not in "biuf" or (values.dtype.itemsize < 4 and values.dtype.kind == "f"):
            raise ValueError(f"type must be bool, integer, float32 or float64, got {values.dtype}")
        target = values.dtype.newbyteorder("<")
    else:
        target = np.dtype(dtype).newbyteorder("<")
    if target.kind == "f" and values.dtype.kind in "fiu":
        with np.errstate(over="ignore"):  # what overflows is infinite, and refused
            stored = values.astype(target)
        _refuse_non_finite(stored)
    elif target.kind in "iu" and values.dtype.kind in "iu":
        _refuse_overflow(values, np.iinfo(target), 1.0)
        stored = values.astype(target)
    elif target.kind == values.dtype.kind == "b":
        stored = values
    else:
        raise ValueError(f"type must be {dtype}, got {values.dtype}")
    return np.ascontiguousarray(stored).reshape(values.shape)


def decode(stored: np.ndarray, quantum: float) -> np.ndarray:
    """The values that `encode` stored: float32 in the dataset's units under fixed point, otherwise `stored` itself."""
    if not quantum:
        return stored
    return (stored * np.float64(quantum)).astype(np.float32)


def _fixed_point(values: np.ndarray, dtype: np.dtype, quantum: float) -> np.ndarray:
    if values.dtype.kind != "f":
        raise ValueError(f"type must be float32 or float64 for fixed point, got {values.dtype}")
    steps = np.rint(values.astype(np.float64) / quantum)
    _refuse_overflow(steps, np.iinfo(dtype), quantum)
    return np.ascontiguousarray(steps.astype(dtype.newbyteorder("<"))).reshape(values.shape)


def _refuse_non_finite(values: np.ndarray) -> None:
    finite = np.isfinite(values)
    if not finite.all():
        index = _first(~finite)
        raise ValueError(f"value at {index} must be finite, got {values[index]}")


def _refuse_overflow(values: np.ndarray, limits: np.iinfo, quantum: float) -> None:
    outside = (values < limits.min) | (values > limits.max)
    if outside.any():
        index = _first(outside)
        low, high = limits.min * quantum, limits.max * quantum
        raise ValueError(
            f"value at {index} must be from {low:g} to {high:g} ({limits.dtype}), got {values[index] * quantum:g}"
        )


def _first(flags: np.ndarray) -> tuple[int, ...]:
    return tuple(int(i) for i in np.unravel_index(int(np.argmax(flags)), flags.shape))
