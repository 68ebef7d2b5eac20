"""The body between its frames: positions, normals and bounds of its triangles at any time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stages.simulate.body_kernels import between_frames, face_frames
from stages.simulate.patches import Patches
from stages.spec import DataError

Frames = Callable[[int], np.ndarray]
"""Body vertices [m], shape [V, 3], of frame k."""

SOME = 8
"""One in so many vertices tells how fast skin goes past cloth: neighbours move alike."""


class BodyMotion:
    """A triangle mesh that moves through given frames, its velocity continuous.

    Between frames k and k + 1 every vertex follows the cubic through both with the central differences as slopes
    (Catmull and Rom 1974): exact at the frames, and no jump of velocity there to shake the cloth 30 times a second.

    Attributes:
        x: Vertices [m] at `time` [s], the last asked for, shape [V, 3]; x_old those a step before.
        faces: Shape [F, 3]; across [F, 3] is the face beyond the edge opposite to each corner, itself at a border.
        start [V + 1], incident [3 F]: Corners about each vertex.
        followed_vertices: One in SOME of the vertices of `faces`.
        face_normal, centre [F, 3], radius [F]: Of the triangles at that time.
        cut: The whole surface in patches, None if there is none; patch_start [P + 1]: where those in `faces` begin.
        whole: All faces of the body, closed, shape [G, 3], of which `faces` are the first; whole_start: its patches'.
        followed: The patches in `faces`, in turn; watched: those left out, as cloth isn't expected to reach them.
    """

    def __init__(
        self, faces: np.ndarray, frames: Frames, count: int, fps: float, left_out: np.ndarray | None = None
    ) -> None:
        """Cut the surface into patches, and leave out those of `left_out` [P] (bool), until `take_in`."""
        faces = np.ascontiguousarray(faces, np.int32)
        self.frames, self.count, self.fps = frames, count, float(fps)
        first = np.asarray(frames(0), np.float64)
        if len(faces) and faces.max() >= len(first):
            raise DataError(f"body: a face names vertex {faces.max()}, but there are {len(first)} vertices")
        self.x, self.x_old = first.copy(), first.copy()
        self.time = np.nan
        self._cache: dict[int, np.ndarray] = {}
        self.cut = Patches(first, faces) if len(faces) else None
        patches = 0 if self.cut is None else len(self.cut.layer)
        out = np.zeros(patches, bool) if left_out is None else left_out
        self.follow(np.flatnonzero(~out))

    def follow(self, patches: np.ndarray) -> None:
        """Let `faces` be those of these patches, one after the other; the rest are `watched`, and last in `whole`."""
        count = 0 if self.cut is None else len(self.cut.layer)
        self.followed, self.watched = patches, np.setdiff1d(np.arange(count), patches)
        self.whole, self.whole_start = np.zeros((0, 3), np.int32), np.zeros(1, np.int32)
        if self.cut is not None:
            cut, order = self.cut, np.concatenate([patches, self.watched])
            self.whole = np.concatenate([cut.faces[cut.start[p] : cut.start[p + 1]] for p in order])
            self.whole_start = np.append(0, np.cumsum(np.diff(cut.start)[order])).astype(np.int32)
        self.patch_start = self.whole_start[: len(patches) + 1].copy()
        self.faces = self.whole[: self.patch_start[-1]].copy()
        used = np.unique(self.faces)
        self.followed_vertices = used[used % SOME == 0]
        self.across = _faces_across(self.faces)
        self.start, self.incident = incident_corners(self.faces, len(self.x))
        self.face_normal, self.centre = np.zeros((len(self.faces), 3)), np.zeros((len(self.faces), 3))
        self.radius = np.zeros(len(self.faces))
        self.refresh()

    def take_in(self, patches: np.ndarray) -> None:
        """Follow these of the `watched` patches too from now on; faces that were there keep their numbers."""
        self.follow(np.concatenate([self.followed, patches]))

    def frame(self, k: int) -> np.ndarray:
        """Vertices of frame k, clamped to the sequence, f64; the last few frames are kept."""
        k = min(max(k, 0), self.count - 1)
        if k not in self._cache:
            x = np.ascontiguousarray(self.frames(k), np.float64)
            if not np.isfinite(x).all():
                bad = int(np.argmax(~np.isfinite(x).all(1)))
                raise DataError(f"body: frame {k}, vertex {bad} is not finite; repair or drop the sequence")
            furthest = max(self._cache, key=lambda j: abs(j - k), default=k)
            old = self._cache.pop(furthest) if len(self._cache) > 6 else None
            # Arrays are used again: kernels are launched faster on those that they know.
            self._cache[k] = x.copy() if old is None else old
            np.copyto(self._cache[k], x)
        return self._cache[k]

    def move_to(self, time: float, dt: float) -> None:
        """Place x_old at `time` [s] and x a step of `dt` [s] later."""
        self.x, self.x_old = self.x_old, self.x
        if self.time != time:
            self.place(time, self.x_old)
        self.place(time + dt, self.x)
        self.time = time + dt
        self.refresh()

    def place(self, time: float, out: np.ndarray) -> None:
        """out = vertices at `time` [s]."""
        if not len(self.faces):
            return
        t = min(max(time * self.fps, 0.0), self.count - 1.0)
        k = min(int(t), max(self.count - 2, 0))
        between_frames(self.frame(k - 1), self.frame(k), self.frame(k + 1), self.frame(k + 2), t - k, out)

    def refresh(self) -> None:
        """Normals and bounds of the triangles at x."""
        if len(self.faces):
            face_frames(self.x, self.faces, self.face_normal, self.centre, self.radius)


def _faces_across(faces: np.ndarray) -> np.ndarray:
    """Face beyond the edge opposite to each corner, shape [F, 3]; the face itself at a border."""
    across = np.repeat(np.arange(len(faces), dtype=np.int32)[:, None], 3, axis=1)
    edges = np.sort(faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    e = edges[order]
    twin = np.flatnonzero((e[1:] == e[:-1]).all(1))
    flat = across.reshape(-1)
    a, b = order[twin], order[twin + 1]
    flat[a], flat[b] = b // 3, a // 3
    return flat.reshape(-1, 3)


def incident_corners(faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """start [V + 1], corners [3 F]: vertex i is corner c % 3 of face c // 3 for c in corners[start[i]:start[i + 1]]."""
    order = np.argsort(faces.ravel(), kind="stable").astype(np.int32)
    start = np.searchsorted(faces.ravel()[order], np.arange(count + 1)).astype(np.int32)
    return start, order
