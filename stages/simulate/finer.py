"""A scene on a finer mesh: every triangle of the cloth cut in four, of the same cloth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stages.simulate.scene import Garment, Scene
from stages.simulate.springs import unique_edges


@dataclass(frozen=True, kw_only=True)
class Finer:
    """A scene on the finer mesh, and where its vertices come from.

    Attributes:
        scene: The scene; each garment has its old vertices first, in their order, then the middles of its edges.
        parents: The two old vertices that each new one lies midway between, the same twice for an old one, [M, 2].
        old: Which of the new vertices are the old ones, in their order, shape [N].
    """

    scene: Scene
    parents: np.ndarray
    old: np.ndarray

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Values (N, ...) of the old vertices at the new ones (M, ...): linear along edges; of flags, the greater."""
        a, b = values[self.parents[:, 0]], values[self.parents[:, 1]]
        return np.maximum(a, b) if values.dtype.kind == "i" else 0.5 * (a + b)


def cut_in_four(scene: Scene) -> Finer:
    """`scene` with every triangle of its cloth cut at the middles of its edges.

    Rest lengths are halved, so that the finer cloth is the old one's shape at rest, elastics and all: under any motion
    of the old vertices that the new ones follow linearly, it stretches with the same energy. A middle is tied or
    pinned if both ends of its edge are, and follows the middle of their goals. The body is as it was.
    """
    garments, parents, old = [], [], []
    before = after = 0
    for coarse in scene.garments:
        garment, ends = _cut(coarse)
        garments.append(garment)
        parents.append(ends + before)
        old.append(np.arange(len(coarse.vertices)) + after)
        before, after = before + len(coarse.vertices), after + len(garment.vertices)
    finer = Finer(scene=scene, parents=np.concatenate(parents), old=np.concatenate(old))
    scene = replace(scene, garments=garments, start=finer.spread(np.asarray(scene.start, np.float64)))
    return replace(finer, scene=_pinned(scene, finer.parents))


def _cut(garment: Garment) -> tuple[Garment, np.ndarray]:
    """The garment cut in four, and the parents (M, 2) of its vertices."""
    edges, opposite = unique_edges(garment.faces)
    n = len(garment.vertices)
    middle = n + opposite
    parents = np.concatenate([np.repeat(np.arange(n)[:, None], 2, axis=1), edges])
    a, b, c = garment.faces.T
    bc, ca, ab = middle.T
    faces = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    # Halves of old edges keep their rest scale; the edge between two middles is parallel to the face's third edge.
    halves = [np.column_stack([edges[:, k], n + np.arange(len(edges))]) for k in range(2)]
    inner = [np.sort(np.column_stack([middle[:, k - 2], middle[:, k - 1]]), axis=1) for k in range(3)]
    rows = np.concatenate(halves + inner)
    scale = np.concatenate([garment.rest_scale] * 2 + [garment.rest_scale[opposite[:, k]] for k in range(3)])
    finer = replace(
        garment,
        vertices=garment.vertices[parents].mean(1),
        faces=faces.astype(np.int32),
        rest_scale=scale[np.lexsort((rows[:, 1], rows[:, 0]))],
        tied=garment.tied[parents].all(1),
    )
    return finer, parents


def _pinned(scene: Scene, parents: np.ndarray) -> Scene:
    """The scene with the pins, and their goals, of the old vertices that are the `parents` of the new ones."""
    if not len(scene.pins):
        return scene
    place = np.full(parents.max() + 1, -1)
    place[scene.pins] = np.arange(len(scene.pins))
    pins = np.flatnonzero((place[parents] >= 0).all(1))
    ends, goal = place[parents[pins]], scene.pin_goal
    if goal is None:
        return replace(scene, pins=pins)
    return replace(scene, pins=pins, pin_goal=lambda time: goal(time)[ends].mean(1))
