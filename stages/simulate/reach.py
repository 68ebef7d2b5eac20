"""Where the cloth of a scene can get, foreseen from the body's motion alone.

Cloth that starts close to the skin, is tied or pinned is held there, and may slip by SLIP. Any other is no further from
the nearest of these than along the cloth; and it may leave the place that it would keep if it went along with its hold
by SWING times that. So every vertex stays where two balls about points of the body overlap. This is an expectation,
not a law, and slips of 0.12 m have been seen: the run checks what is concluded from it, in every frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from stages.simulate.body_motion import BodyMotion
from stages.simulate.reach_kernels import pass_by
from stages.simulate.scene import Scene
from stages.simulate.springs import unique_edges

SNUG = 0.03
"""Cloth that starts this near to the skin is held by it [m]."""
SLIP = 0.05
"""How far cloth is expected to slip at most from where it was held [m]."""
SWING = 0.5
"""How far cloth that hangs on what is held is expected to leave its place at most, over its length: by 29 degrees."""
STRETCH = 1.05
"""Greatest length of cloth over its rest length."""
SKIN = 1.2
"""Greatest size of a patch of skin over that in the first frame."""
CELL = 0.08
"""Cloth vertices that start in one cell of this size, held in one, are taken together [m]."""
SOME = 4
"""One in so many cloth vertices stands for those next to it."""
EVERY = 16
"""One in so many patches of skin tells how fast it goes into cloth: neighbours move alike."""
LOOK = 4
"""Frames from one look at the distance of skin and cloth to the next; the run looks in every frame."""


@dataclass(frozen=True, kw_only=True)
class Forecast:
    """What is foreseen of a scene.

    Attributes:
        spot [P]: Body vertex for each of the body's patches; spread [P] [m]: all of it is this near.
        gap [P] [m]: Least distance in any frame between the patch and where cloth can be; at most `enough` once it is.
        into [T + 1]: Greatest speed of skin into cloth expected near it, between each frame and the one before [m/s].
        speed [T + 1]: Greatest speed of what holds the cloth, relative to all of it [m/s].
        fastest: The same relative to the air [m/s].
        length: Greatest length of cloth that hangs on what is held [m], infinite if nothing holds it.
        apart: For pairs of garments (i, j), i < j, the least distance between where both can be [m].
    """

    spot: np.ndarray
    spread: np.ndarray
    gap: np.ndarray
    into: np.ndarray
    speed: np.ndarray
    fastest: float
    length: float
    apart: dict[tuple[int, int], float]


def foresee_reach(scene: Scene, body: BodyMotion, enough: float) -> Forecast:
    """The forecast of `scene`; skin no further than `enough` [m] from cloth is near it."""
    points = _Held(scene, body)
    spot, spread = _spots(body)
    gap, into_frame = np.full(len(spot), np.inf), np.zeros(scene.frames + 1)
    speed, fastest = np.zeros(scene.frames + 1), 0.0
    apart: dict[tuple[int, int], float] = {}
    into = np.zeros(len(spot))
    before = points.balls(0)[0]
    skin_before = body.frame(0)[spot]
    for k in range(scene.frames + 1):
        balls = points.balls(k)
        skin = body.frame(k)[spot]
        move = balls[0] - before
        if len(spot):
            limit = enough if k % LOOK == 0 else np.inf
            pass_by(skin, skin - skin_before, spread, *balls, move, limit, enough, EVERY, gap, into)
            into_frame[k] = scene.fps * into.max()
        speed[k] = scene.fps * np.linalg.norm(move - points.mean(move), axis=1).max()
        blown = np.linalg.norm(scene.fps * move - np.asarray(scene.wind), axis=1)
        fastest = max(fastest, float(blown.max()))
        _part(points.garment, *balls[:2], apart)
        before, skin_before = balls[0], skin
    speed[0] = speed[1] if scene.frames else 0.0
    return Forecast(
        spot=spot,
        spread=spread,
        gap=gap,
        into=into_frame,
        speed=speed,
        fastest=fastest,
        length=points.length,
        apart=apart,
    )


class _Held:
    """What holds the cloth: for groups of its vertices the balls in which they stay, and are expected."""

    def __init__(self, scene: Scene, body: BodyMotion) -> None:
        start, first = np.asarray(scene.start, np.float64), body.frame(0)
        self.scene, self.body = scene, body
        away, skin = np.full(len(start), np.inf), np.zeros(len(start), np.int64)
        if len(body.faces):
            used = np.unique(body.faces)
            away, near = cKDTree(first[used]).query(start, workers=1)
            skin = used[near]
        tied = np.concatenate([g.tied for g in scene.garments])
        held = (away < SNUG) | (tied & np.isfinite(away))
        point = skin.copy()
        away[scene.pins] = 0.0
        held[scene.pins] = True
        point[scene.pins] = len(first) + np.arange(len(scene.pins))
        along, source = _along_cloth(scene, held)
        self.length = float(along.max())
        point = np.where(source >= 0, point[source], point)
        reach = np.where(source >= 0, away[source] + STRETCH * along + SLIP, np.inf)
        wide = np.where(source >= 0, SWING * along + SLIP, np.inf)
        first = self._points(0)
        garment = np.repeat(np.arange(len(scene.garments)), [len(g.vertices) for g in scene.garments])
        at = first[point] if len(first) else start
        cells = np.floor(np.column_stack([at, start]) / CELL).astype(np.int64)
        some = np.unique(np.concatenate([np.arange(0, len(start), SOME), np.searchsorted(garment, np.unique(garment))]))
        _, group = np.unique(np.column_stack([garment, cells])[some], axis=0, return_inverse=True)
        order = np.argsort(group.ravel(), kind="stable")
        self.first = np.flatnonzero(np.diff(group.ravel()[order], prepend=-1))
        self.size = np.diff(np.append(self.first, len(order)))
        order = some[order]
        self.garment = garment[order][self.first]
        self.point, self.reach, self.wide, self.offset = point[order], reach[order], wide[order], (start - at)[order]

    def _points(self, k: int) -> np.ndarray:
        """Body vertices, then pins, of frame k."""
        points = self.body.frame(k)
        if self.scene.pin_goal is None:
            return points if not len(self.scene.pins) else np.concatenate([points, self.scene.start[self.scene.pins]])
        return np.concatenate([points, self.scene.pin_goal(k / self.scene.fps)])

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over all cloth of `values` [G, 3] of the groups."""
        return np.asarray(self.size @ values / self.size.sum())

    def balls(self, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Centre and radius of what each group can't leave in frame k; then the place where it is expected, how wide
        about it it can get, and its own extent; [G, 3] and [G], all [m]."""
        points = self._points(k)
        p = points[self.point] if len(points) else np.zeros_like(self.offset)
        centre, radius = self._ball(p, self.reach)
        place, wide = self._ball(p + self.offset, self.wide)
        return centre, radius, place, wide, self._ball(p + self.offset, np.zeros(len(p)))[1]

    def _ball(self, points: np.ndarray, more: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        centre = np.add.reduceat(points, self.first) / self.size[:, None]
        apart = np.linalg.norm(points - np.repeat(centre, self.size, axis=0), axis=1)
        return centre, np.maximum.reduceat(apart + more, self.first)


def _along_cloth(scene: Scene, held: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance [m] of every vertex along the edges at rest to the nearest `held` one, and which; inf and -1 if none."""
    count = len(held)
    if not held.any():
        return np.full(count, np.inf), np.full(count, -1)
    graphs = []
    for g in scene.garments:
        edges, _ = unique_edges(g.faces)
        length = np.linalg.norm(g.vertices[edges[:, 0]] - g.vertices[edges[:, 1]], axis=1)
        graphs.append(sparse.coo_matrix((length, edges.T), shape=(len(g.vertices), len(g.vertices))))
    along, _, source = csgraph.dijkstra(
        sparse.block_diag(graphs).tocsr(),
        directed=False,
        indices=np.flatnonzero(held),
        min_only=True,
        return_predecessors=True,
    )
    return along, np.where(np.isfinite(along), source, -1)


def _spots(body: BodyMotion) -> tuple[np.ndarray, np.ndarray]:
    """A vertex in each patch of the body, and the radius about it [m] that the patch won't leave."""
    if not len(body.faces):
        return np.zeros(0, np.int64), np.zeros(0)
    first, start = body.frame(0), 3 * body.patch_start[:-1].astype(np.int64)
    corners = body.faces.ravel()
    size = np.diff(np.append(start, len(corners)))
    at = first[corners]
    centre = np.add.reduceat(at, start) / size[:, None]
    off = np.linalg.norm(at - np.repeat(centre, size, axis=0), axis=1)
    order = np.lexsort((off, np.repeat(np.arange(len(start)), size)))
    spot = corners[order[start]]
    spread = np.maximum.reduceat(np.linalg.norm(at - np.repeat(first[spot], size, axis=0), axis=1), start)
    return spot, SKIN * spread


def _part(garment: np.ndarray, centre: np.ndarray, radius: np.ndarray, apart: dict[tuple[int, int], float]) -> None:
    """Lower `apart` to the least distance between the balls of every two garments, until they meet."""
    for i in range(int(garment.max())):
        for j in range(i + 1, int(garment.max()) + 1):
            if apart.get((i, j), np.inf) <= 0:
                continue
            a, b = garment == i, garment == j
            distance = np.linalg.norm(centre[a][:, None] - centre[b][None], axis=2) - radius[a][:, None] - radius[b]
            apart[i, j] = max(0.0, min(apart.get((i, j), np.inf), float(distance.min())))
