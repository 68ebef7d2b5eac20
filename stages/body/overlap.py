"""How near one part of the body comes to another, frame by frame."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stages.body.collision.patches import Nearby
from stages.body.collision.vectors import dot, squares
from stages.body.parts import Part

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Points = NDArray[np.float32]

FAR = 0.08
"""Distances are not looked at beyond this [m]."""

STRAY = 0.03
"""Points that are farther apart than `FAR` needn't be looked at again before they moved by this together: until then
none comes as near as FAR - STRAY, which is more than any gap wanted [m]."""

TANGENT = 0.03
"""Nearer than this, the tangent plane at the nearest point gives the distance; points lie 14 mm apart [m]."""

INWARD = 0.5
"""Farther away, a point is inside only if it lies below that plane by this share of its distance."""


@dataclass(frozen=True, eq=False)
class Nearness:
    """The signed distance to another part of those points of a part that are near it, and which way leads out."""

    points: Points
    """The points [m], shape [N, 3]."""
    distance: Array
    """Signed distance, negative inside [m], shape [N]."""
    normals: Points
    """Outward normal of the other part there, shape [N, 3]."""

    def least(self) -> float:
        """The smallest distance, at most `FAR` [m]."""
        return float(self.distance.min(initial=FAR))


@dataclass(frozen=True, eq=False)
class Posed:
    """A part in some frames."""

    part: Part
    transforms: Array
    """Skinning transforms, shape [T, 24, 3, 4]."""
    points: Points
    """Points of the part [m], shape [T, N, 3]."""

    @classmethod
    def of(cls, part: Part, transforms: Array) -> "Posed":
        """The part, posed by transforms [T, 24, 3, 4]."""
        return cls(part, transforms, part.posed(transforms))

    def only(self, frames: Index) -> "Posed":
        """Some of the frames."""
        return Posed(self.part, self.transforms[frames], self.points[frames])


class Approach:
    """Two parts, looked at again and again while they are moved a little: only what was near once is looked at."""

    def __init__(self, frames: int, one: Part, other: Part, gap: float) -> None:
        """Nothing is known yet of so many frames; distances matter where they are less than `gap` [m]."""
        self.enough = max(gap, TANGENT)  # a point that stays farther away than this is measured by its own distance
        self.least = np.zeros(frames)
        rest, self.count = np.concatenate([one.points, other.points]).astype(np.float64), len(one.points)
        self.nearby = Nearby(rest, (np.arange(len(rest)) >= self.count).astype(np.int64), ((0, 1),), -np.inf, FAR)
        self.rows: list[tuple[Index, Index]] = [(np.zeros(0, np.int64),) * 2] * frames
        # Where all points were when those rows were found.
        self.then = np.full((frames, len(rest), 3), np.inf, np.float32)

    def look(self, frames: Index, one: Posed, other: Posed) -> Iterator[tuple[int, Nearness, Nearness]]:
        """How near they are in some `frames` [K], in which they are posed as given.

        Yields:
            Row of `frames`, and the nearness of either; but for rows in which it was enough and must still be so.
        """
        x = np.concatenate([one.points, other.points], axis=1)
        moved = self._follow(frames, x)
        for k in map(int, np.flatnonzero(self.least[frames] - moved < self.enough)):
            i, j = self.rows[frames[k]]
            a, b = x[k, i], x[k, self.count + j]
            if len(i):
                squared = squares(a, b)
                n_a, n_b = one.part.normals_in(one.transforms[k], i), other.part.normals_in(other.transforms[k], j)
                near = _nearness(a, b, n_b, squared.argmin(axis=1)), _nearness(b, a, n_a, squared.argmin(axis=0))
            else:
                near = Nearness(a, np.zeros(0), a), Nearness(b, np.zeros(0), b)
            if not moved[k]:
                self.least[frames[k]] = min(one.least() for one in near)
            yield k, *near

    def _follow(self, frames: Index, x: Points) -> Array:
        """Finds the `rows` of some `frames` [K] anew if points x [m], shape [K, N + M, 3], have moved too far.

        Returns:
            How far points of both parts have moved together since their rows were found [m], shape [K].
        """
        shift = x - self.then[frames]
        far = dot(shift, shift)
        moved = np.sqrt(far[:, : self.count].max(axis=1)) + np.sqrt(far[:, self.count :].max(axis=1))
        strayed = np.flatnonzero(~(moved < STRAY))
        for t in frames[strayed]:
            self.rows[t] = (np.zeros(0, np.int64),) * 2
        self.then[frames[strayed]], self.least[frames[strayed]], moved[strayed] = x[strayed], 0.0, 0.0
        for k, _, (i, j) in self.nearby.find(x[strayed], FAR):
            t = strayed[k]
            close = squares(x[t, i], x[t, j]) < FAR**2
            self.rows[frames[t]] = i[close.any(axis=1)], j[close.any(axis=0)] - self.count
        return moved


def _nearness(points: Points, others: Points, normals: Points, nearest: Index) -> Nearness:
    """Of points [N, 3] to `others` [M, 3] with their outward normals, of which the `nearest` to each is known [N]."""
    way, normals = (points - others[nearest]).astype(np.float64), normals[nearest]
    apart, height = np.sqrt(dot(way, way)), dot(way, normals.astype(np.float64))
    inside = height < -INWARD * apart
    return Nearness(points, np.where((apart < TANGENT) | inside, height, apart), normals)
