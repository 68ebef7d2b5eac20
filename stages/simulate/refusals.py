"""Starts that no step could put right, refused beforehand."""

from __future__ import annotations

import igl
import numpy as np

from stages.simulate.body_motion import BodyMotion
from stages.simulate.pairs import PairContact
from stages.simulate.scene import Scene
from stages.spec import DataError


def refuse_inside(scene: Scene, body: BodyMotion, deepest: float) -> None:
    """Refuse cloth that starts deep inside the body: what pushed it out would fling it.

    Raises:
        DataError: Naming the deepest vertex, its depth and the limit `deepest` [m].
    """
    if not len(body.whole):
        return
    faces, start = body.whole.astype(np.int64), np.ascontiguousarray(scene.start, np.float64)
    inside = np.flatnonzero(igl.fast_winding_number(body.x, faces, start) > 0.5)
    if not len(inside):
        return
    depth = np.sqrt(igl.point_mesh_squared_distance(start[inside], body.x, faces)[0])
    if depth.max() > deepest:
        offset = np.cumsum([0, *(len(g.vertices) for g in scene.garments)])
        vertex = inside[int(np.argmax(depth))]
        number = int(np.searchsorted(offset, vertex, side="right")) - 1
        raise DataError(
            f"{scene.garments[number].name}: vertex {vertex - offset[number]} starts {1e3 * depth.max():.0f} mm inside "
            f"the body, at most {1e3 * deepest:.0f} mm can be put right; start with the cloth outside"
        )


TANGLED = 0.15
"""Share of a scene's edges that may pass through their own garment at the start: so many can be taken apart."""


def refuse_tangled(pairs: PairContact, start: np.ndarray) -> None:
    """Refuse cloth that starts so tangled with itself that it can't be told which side of it belongs where.

    Garments that start through each other have an order; see `SimulateConfig.untangle`.

    Raises:
        DataError: Naming the number of edges and one of them.
    """
    pairs.search(start, np.zeros_like(start), 1e-3)
    pairs.age = pairs.every
    pairs.find_crossings(start, np.ones(len(start), np.int32), False)
    crossed = pairs.crossings.count
    if (crossed > 0).mean() > TANGLED:
        a, b = pairs.edges[int(np.argmax(crossed))]
        raise DataError(
            f"scene: {(crossed > 0).sum()} of {len(crossed)} edges pass through their own garment at the start, "
            f"edge {a}-{b} for one, at most {TANGLED:.1%} can be put up with; untangle the garment"
        )
