"""How high the pelvis may be so that the legs that stand reach the ground."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from stages.body.clips.footfalls import Plant, stand
from stages.body.figure import HIPS, Figure
from stages.body.legs import STRAIGHTEST, reach
from stages.body.sole import Sole
from stages.body.turns import rotate

Array = NDArray[np.float64]

SOFTNESS = 0.05
"""Standard deviation in time of the pelvis giving way [s]."""


def ceiling(
    figure: Figure,
    soles: tuple[Sole, Sole],
    plants: Sequence[Sequence[Plant]],
    times: Array,
    root: Array,
    pelvis: Array,
    bend: float = STRAIGHTEST,
) -> Array:
    """Greatest height of the root joint at which every standing leg reaches its foot.

    Args:
        figure: The person.
        soles: Ground contacts of the left and right foot.
        plants: Plants of the left and right foot.
        times: Times [s], shape [T].
        root: Path of the root joint [m]; its height is not read, shape [T, 3].
        pelvis: World rotation of the pelvis, shape [T, 3, 3].
        bend: Bend that the knee keeps [rad].

    Returns:
        Heights [m], infinite where no foot is on the ground, shape [T].
    """
    out = np.full(len(times), np.inf)
    for side in (0, 1):
        hip = rotate(pelvis, figure.joints[HIPS[side]] - figure.joints[0])
        longest = reach(figure.leg(side), bend)
        for plant in plants[side]:
            now = (times >= plant.start) & (times <= plant.end)
            ankle, _ = stand(soles[side], plant, times[now])
            away = ankle - root[now] - hip[now]
            flat = np.hypot(away[:, 0], away[:, 2])
            height = ankle[:, 1] - hip[now, 1] + np.sqrt(np.clip(longest**2 - flat**2, 0.0, None))
            out[now] = np.minimum(out[now], height)
    return out


def give_way(height: Array, limit: Array, dt: float) -> Array:
    """Lowers a path smoothly so that it stays below a limit.

    Args:
        height: Wanted heights [m], shape [T].
        limit: Greatest heights, infinite where there is none [m], shape [T].
        dt: Time between two samples [s].

    Returns:
        Heights at most `limit`, shape [T]: the excess, widened by three standard deviations, then smoothed.
    """
    excess = np.clip(height - limit, 0.0, None)
    sigma = SOFTNESS / dt
    wide = maximum_filter1d(excess, size=2 * int(np.ceil(3 * sigma)) + 1)
    return height - gaussian_filter1d(wide, sigma, truncate=3.0)
