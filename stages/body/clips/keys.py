"""Curves through key poses."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BPoly, PchipInterpolator

Array = NDArray[np.float64]


def ease(times: Array, keys: Sequence[tuple[float, float]]) -> Array:
    """A curve through keys that eases in and out of every extreme and never overshoots.

    Args:
        times: Times [s], shape [T].
        keys: (time [s], value), in order of time; the curve holds the first and the last value outside.

    Returns:
        Values, continuous in value and velocity, shape [T].
    """
    at, values = np.array([k[0] for k in keys]), np.array([k[1] for k in keys])
    at = np.concatenate([[at[0] - 1.0], at, [at[-1] + 1.0]])
    values = np.concatenate([values[:1], values, values[-1:]])
    curve = PchipInterpolator(at, values)
    return np.asarray(curve(np.clip(times, at[0], at[-1])), dtype=np.float64)


def flow(times: Array, nodes: Sequence[tuple[float, float, float, float]]) -> Array:
    """A curve through (time [s], position, velocity, acceleration): quintic pieces, continuous in all three.

    Between two nodes of free fall the piece is the parabola itself. Outside, the first and last positions are held.
    """
    at = [n[0] for n in nodes]
    curve = BPoly.from_derivatives(at, [n[1:] for n in nodes])
    return np.asarray(curve(np.clip(times, at[0], at[-1])), dtype=np.float64)
