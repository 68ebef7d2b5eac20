"""What still crosses in a frame that is recorded, taken apart in the record alone.

Where skin presses folds together a crossing or two may stay for as long as it presses: what pulls them apart is weaker
than skin. The record shows such cloth apart; the simulation goes on from its own positions, which come apart with time.
"""

from __future__ import annotations

import numpy as np

from stages.simulate.body_kernels import face_frames
from stages.simulate.contact import BodyContact
from stages.simulate.pairs import PairContact
from stages.simulate.untangle import Crossings

ROUNDS = 16
"""Times that what crosses is moved, by a millimetre each at most."""
FURTHEST = 0.006
"""How far a vertex may be moved in all [m]."""


class Tidy:
    """Takes cloth apart where the last search for its pairs saw cloth near cloth."""

    def __init__(self, pairs: PairContact, contact: BodyContact) -> None:
        self.pairs, self.contact, self.crossings = pairs, contact, Crossings(pairs.patches, pairs.layer)
        self.normal, self.centre = np.zeros_like(pairs.face_normal), np.zeros_like(pairs.face_centre)
        self.radius = np.zeros_like(pairs.face_radius)

    def __call__(self, x: np.ndarray, fixed: np.ndarray, floor: float) -> tuple[int, int]:
        """Move vertices of x [N, 3], in place, so that fewer edges pass through faces.

        What is `fixed` [N] or shut in a fold of the body stays; nothing is moved nearer than `floor` [m] to skin.

        Returns:
            How many edges did, and do. Where moving leaves no fewer, x stays as it is.
        """
        before = least = self._count(x)
        if not before:
            return 0, 0
        start, y = x.copy(), x.copy()
        skin = len(self.contact.body.faces) > 0
        still = np.maximum(fixed, self.contact.pinched) if skin else fixed
        for _ in range(ROUNDS):
            self._move(y, still)
            way = y - start
            far = np.linalg.norm(way, axis=1, keepdims=True)
            y[:] = start + way * np.minimum(1.0, FURTHEST / np.maximum(far, 1e-12))
            if skin:
                self.contact.locate(y)
                inside = (self.contact.distance < floor) & (far[:, 0] > 0)
                y[inside] = start[inside]
            count = self._count(y)
            if count < least:
                x[:], least = y, count
            if not count:
                break
        return before, least

    def _count(self, x: np.ndarray) -> int:
        """Find the crossings of x; how many there are."""
        p = self.pairs
        face_frames(x, p.faces, self.normal, self.centre, self.radius)
        self.crossings.find(x, self.centre, self.radius, p.close, True, p.met_count, p.met)
        return len(self.crossings.edge)

    def _move(self, x: np.ndarray, fixed: np.ndarray) -> None:
        """Move edges and faces of x that cross past each other, in place; each vertex by the mean of its crossings."""
        vertices, way, pace = self.crossings.ways(x)
        half = 0.5 * pace[:, None] * way
        shift, times = np.zeros_like(x), np.zeros(len(x))
        for column, sign in enumerate((1.0, -1.0, -1.0, -1.0)):
            np.add.at(shift, vertices[:, column], sign * half)
            np.add.at(times, vertices[:, column], 1.0)
        x += np.where(fixed[:, None] > 0, 0.0, shift / np.maximum(times, 1.0)[:, None])
