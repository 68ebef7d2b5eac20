"""Judges a simulated sequence frame by frame, from positions alone: in the body, tangled, fallen, frozen, exploded."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from model.mesh.barycentric import carry
from model.mesh.intersection import self_crossings
from stages.report.quality import depth_inside, stretches

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

DEPTH = 0.5e-3
"""Depth in the body that may not be exceeded [m]."""
LASTING = 10
"""Frames for which the same place of the cloth may pass through other cloth."""
FALLEN = 0.10
"""How far what holds a garment, its waistband or its shoulders, may slide down the body on either side [m]."""
TOP = 0.05
"""A garment without a waistband is held by what lies no more than this below its highest vertex at rest [m]."""
MOVING = 0.2
"""Skin faster than this on average moves [m/s]: the cloth on it must move too."""
FROZEN = 0.25
"""Least mean speed of cloth over that of the skin it lies on, while that moves."""
EXPLODED = 2.5
"""Most speed of any vertex over the fastest skin's: hems crack like whips."""
FALL_SPEED = 1.0
"""Added to the skin's speed: cloth falls while the body stands [m/s]."""
WINDOW = 15
"""Frames over which speeds are compared, half a second."""
EVERY = 8
"""Of the vertices, whose mean speed is taken."""
STRETCHED = 0.10
"""Stretch beyond which an edge counts as stretched, as a share of its rest length."""


@dataclass(frozen=True)
class Cloth:
    """One garment over time.

    Attributes:
        x: Positions in the world [m], shape [T, N, 3]; faces: shape [F, 3].
        rest: Positions at rest on the body that it was made for [m], shape [N, 3].
        held: Which vertices hold it up, shape [N]; none for those near the top.
    """

    x: Array
    faces: Faces
    rest: Array
    held: NDArray[np.bool_]


@dataclass(frozen=True)
class Body:
    """The body over time.

    Attributes:
        x: Positions in the world [m], shape [T, V, 3]; faces: shape [G, 3].
        rest: The body at rest that the garments were made for [m], shape [V, 3].
        up: Direction from its pelvis to its head, shape [T, 3], and up_rest at rest, shape [3].
    """

    x: Array
    faces: Faces
    rest: Array
    up: Array
    up_rest: Array


def audit(garments: Mapping[str, Cloth], body: Body, fps: float) -> dict[str, Any]:
    """Figures of a sequence, the worst of all garments, and in which frame each is worst."""
    x = np.concatenate([g.x for g in garments.values()], axis=1)
    if not np.isfinite(x).all():
        return {"finite": False}
    offset = np.cumsum([0, *(g.x.shape[1] for g in garments.values())])
    faces = np.concatenate([g.faces + o for g, o in zip(garments.values(), offset)])

    def look(k: int) -> tuple[float, Faces]:
        return float(depth_inside(x[k], body.x[k], body.faces).max(initial=0.0)), self_crossings(x[k], faces)

    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        depth, crossed = zip(*pool.map(look, range(len(x))))
    counts = [len(pairs) for pairs in crossed]
    lasts, until = lasting([np.unique(faces[pairs]) for pairs in crossed], x.shape[1])
    slips = np.max([slip(g, body) for g in garments.values()], axis=0)
    lags = [lag(g, body, fps) for g in garments.values()]
    speed, wildest = wildness(x, body.x, fps)
    stretch = [_stretch(g) for g in garments.values()]
    return {
        "finite": True,
        "vertices": x.shape[1],
        "depth_mm": round(1e3 * max(depth), 3),
        "depth_frame": int(np.argmax(depth)),
        "crossings_most": max(counts),
        "crossings_frame": int(np.argmax(counts)),
        "crossed_frames": int(np.count_nonzero(counts)),
        "crossing_lasts": lasts,
        "crossing_until": until,
        "stretch_max": round(max(most for most, _ in stretch), 3),
        "stretched_share": round(max(share for _, share in stretch), 4),
        "slip_mm": round(1e3 * float(slips.max())),
        "slip_frame": int(slips.argmax()),
        "lag": min((round(value, 2) for value in lags if value is not None), default=None),
        "wildness": round(wildest, 2),
        "speed": round(float(speed.max()), 2),
        "speed_frame": int(speed.argmax()),
    }


def faults(figures: Mapping[str, Any]) -> list[str]:
    """What of the figures breaks a bar."""
    if not figures["finite"]:
        return ["not finite"]
    found = []
    if figures["depth_mm"] > 1e3 * DEPTH:
        found.append(f"{figures['depth_mm']:.2f} mm inside the body in frame {figures['depth_frame']}")
    if figures["crossing_lasts"] > LASTING:
        found.append(f"a crossing lasts {figures['crossing_lasts']} frames, until {figures['crossing_until']}")
    if figures["slip_mm"] > 1e3 * FALLEN:
        found.append(f"fallen by {figures['slip_mm']:.0f} mm in frame {figures['slip_frame']}")
    if figures["lag"] is not None and figures["lag"] < FROZEN:
        found.append(f"frozen: {figures['lag']:.2f} of the skin's speed")
    if figures["wildness"] > EXPLODED:
        found.append(f"exploded: {figures['wildness']:.1f} times the skin's speed")
    return found


def lasting(crossed: list[NDArray[np.int64]], count: int) -> tuple[int, int]:
    """Most frames in a row in which one vertex belongs to faces that cross others, and the last of them.

    A tangle slides through the cloth, so that pairs of faces change while it stays: a place is a vertex.

    Args:
        crossed: Vertices of such faces in each frame.
        count: Number of all vertices.
    """
    run, longest, until = np.zeros(count, int), 0, 0
    for frame, vertices in enumerate(crossed):
        grown = run[vertices] + 1
        run[:] = 0
        run[vertices] = grown
        if len(grown) and grown.max() > longest:
            longest, until = int(grown.max()), frame
    return longest, until


def anchors(cloth: Cloth, body: Body, chosen: NDArray[np.int64]) -> tuple[Array, Array]:
    """Points of the skin nearest to the `chosen` vertices at rest: where they are at rest [n, 3], and over time."""
    faces = np.ascontiguousarray(body.faces, np.int64)
    surface = np.ascontiguousarray(body.rest, np.float64)
    points = np.ascontiguousarray(cloth.rest[chosen], np.float64)
    _, face, nearest = igl.point_mesh_squared_distance(points, surface, faces)
    a, b, c = (np.ascontiguousarray(surface[faces[face, k]]) for k in range(3))
    weights = igl.barycentric_coordinates(np.ascontiguousarray(nearest), a, b, c)
    return carry(surface, faces, face, weights), carry(body.x, faces, face, weights)


def slip(cloth: Cloth, body: Body) -> Array:
    """How far what holds the garment has slid down the body since it was made, the worse of both sides [m], [T]."""
    held = cloth.held if cloth.held.any() else cloth.rest[:, 2] > cloth.rest[:, 2].max() - TOP
    middle = 0.5 * (cloth.rest[held, 0].min() + cloth.rest[held, 0].max())
    sides = []
    for side in (held & (cloth.rest[:, 0] <= middle), held & (cloth.rest[:, 0] >= middle)):
        chosen = np.flatnonzero(side)
        start, moved = anchors(cloth, body, chosen)
        above_rest = ((cloth.rest[chosen] - start) @ body.up_rest).mean()
        above = np.einsum("tnc,tc->tn", cloth.x[:, chosen] - moved, body.up).mean(axis=1)
        sides.append(above_rest - above)
    return np.asarray(np.max(sides, axis=0))


def lag(cloth: Cloth, body: Body, fps: float) -> float | None:
    """Least mean speed of the cloth over that of the skin below it, in windows where that moves; None if none does."""
    if len(cloth.x) < 2:
        return None
    some = np.arange(0, len(cloth.rest), EVERY)
    below = anchors(cloth, body, some)[1]
    speeds = [np.linalg.norm(np.diff(x, axis=0), axis=2).mean(axis=1) * fps for x in (cloth.x[:, some], below)]
    ours, theirs = (uniform_filter1d(s, min(WINDOW, len(s)), mode="nearest") for s in speeds)
    moving = theirs > MOVING
    return float((ours[moving] / theirs[moving]).min()) if moving.any() else None


def wildness(x: Array, body: Array, fps: float) -> tuple[Array, float]:
    """Speed of the fastest vertex in each frame [m/s], [T], and the most it is over the fastest skin's around then."""
    if len(x) < 2:
        return np.zeros(len(x)), 0.0
    ours, theirs = (_fastest(points, fps) for points in (x, body))
    around = maximum_filter1d(theirs, 2 * WINDOW + 1, mode="nearest") + FALL_SPEED
    return ours, float((ours / around).max())


def _fastest(x: Array, fps: float) -> Array:
    steps = [0.0, *(float(np.linalg.norm(b - a, axis=1).max()) for a, b in pairwise(x))]
    return np.array(steps) * fps


def _stretch(cloth: Cloth) -> tuple[float, float]:
    """Greatest stretch of an edge, and the share of edges stretched in the worst frame."""
    stretch = stretches(cloth.x, cloth.rest, cloth.faces)
    return float(stretch.max()), float((stretch > STRETCHED).mean(axis=1).max())
