"""What is to be simulated: garments as one cloth, their fabrics, the body's frames, what holds the cloth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from stages.simulate.fabric import Fabric
from stages.simulate.springs import unique_edges
from stages.spec import DataError


@dataclass(frozen=True, kw_only=True)
class Garment:
    """One garment.

    Attributes:
        name: Its name, for messages.
        vertices: Rest positions [m], shape [N, 3]; faces: outward, shape [F, 3].
        fabric: Its fabric.
        rest_scale: Rest length over length in `vertices` for each sorted unique edge, shape [E]: elastics, waistbands.
        tied: Vertices of the waistband, which is tied softly to the body, shape [N] bool.
        cords: Pairs of vertices that a fastening keeps no further apart than `cord_length` [m], shapes [C, 2] and [C].
    """

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    fabric: Fabric
    rest_scale: np.ndarray
    tied: np.ndarray
    cords: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int32))
    cord_length: np.ndarray = field(default_factory=lambda: np.zeros(0))


def edge_scale(faces: np.ndarray, marks: np.ndarray, ratios: dict[int, float]) -> np.ndarray:
    """Rest scale of every unique edge (E,): `ratios[id]` where both ends carry the mark `id` (N,), else 1."""
    edges, _ = unique_edges(faces)
    scale = np.ones(len(edges))
    for mark, ratio in ratios.items():
        scale[(marks[edges] == mark).all(1)] *= ratio
    return scale


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A scene of one or more garments, inner to outer, about one moving body.

    Attributes:
        garments: From the inner to the outer.
        start: First positions [m], shape [N, 3], all garments in turn.
        body_faces: Shape [F, 3]; body: body vertices of frame k; body_frames: How many there are.
        frames: Frames to simulate after frame 0; record: First frame whose positions are returned.
        ease_in: Frames in which elastics tighten from their length in the garment to their own, in thick air; if there
            are any, cloth bends more stiffly than its fabric until shortly before the first recorded frame.
        fps: Frames a second.
        pins: Vertices that follow pin_goal(time [s]) -> [K, 3].
        wind: Velocity of the air [m/s].
        velocity: Velocity of cloth and air at the start [m/s]; the air has come to that of the wind after easing in.
    """

    garments: Sequence[Garment]
    start: np.ndarray
    body_faces: np.ndarray
    body: Callable[[int], np.ndarray]
    body_frames: int
    frames: int
    record: int = 0
    ease_in: int = 0
    fps: float = 30.0
    pins: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    pin_goal: Callable[[float], np.ndarray] | None = None
    wind: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def check(self) -> None:
        """Refuse what can't be simulated.

        Raises:
            DataError: Naming the garment, the vertex and the value.
        """
        if not self.garments:
            raise DataError("scene: there is no garment; give at least one")
        offset = 0
        for g in self.garments:
            for what, x in (("rest", g.vertices), ("start", self.start[offset : offset + len(g.vertices)])):
                bad = ~np.isfinite(x).all(1)
                if bad.any():
                    i = int(np.argmax(bad))
                    raise DataError(f"{g.name}: {what} position of vertex {i} is {x[i].tolist()}, must be finite")
            if not len(g.faces) or g.faces.min() < 0 or g.faces.max() >= len(g.vertices):
                raise DataError(f"{g.name}: faces must name vertices 0 to {len(g.vertices) - 1}, and there must be one")
            astray = g.cords[(g.cords < 0) | (g.cords >= len(g.vertices))]
            if len(astray):
                raise DataError(f"{g.name}: cords must join vertices 0 to {len(g.vertices) - 1}, not {astray[0]}")
            if g.cord_length.shape != (len(g.cords),) or not (g.cord_length > 0).all():
                raise DataError(
                    f"{g.name}: each of {len(g.cords)} cords must have a length above 0 m, not {g.cord_length.tolist()}"
                )
            offset += len(g.vertices)
        if offset != len(self.start):
            raise DataError(f"scene: {len(self.start)} start positions for {offset} vertices")
