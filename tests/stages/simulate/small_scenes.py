"""Meshes and scenes small enough to reason about."""

from collections.abc import Callable
from typing import Any

import numpy as np

from stages.simulate.config import SimulateConfig
from stages.simulate.fabric import Fabric
from stages.simulate.make_stepper import make_stepper
from stages.simulate.scene import Garment, Scene
from stages.simulate.springs import unique_edges
from stages.simulate.stepper import Stepper

EXACT: dict[str, Any] = {"precision": "f64", "tolerance": 1e-10, "newton_iterations": 20, "newton_tolerance": 1e-13}
"""Settings that solve every step to rounding."""

PLAIN = Fabric(density=0.2, stretch_stiffness=100.0, shear_stiffness=37.5, bend_stiffness=1e-5, drag=0.0, damping=0.0)


def sheet(columns: int, rows: int, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """A flat sheet of columns x rows vertices in the plane z = 0, from the origin, faces up; diagonals alternate."""
    x, y = np.meshgrid(np.arange(columns) * edge, np.arange(rows) * edge, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(columns * rows)], axis=1)
    faces = []
    for i in range(columns - 1):
        for j in range(rows - 1):
            a, b, c, d = (p * rows + q for p, q in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
            faces += [[a, b, c], [a, c, d]] if (i + j) % 2 == 0 else [[a, b, d], [b, c, d]]
    return vertices, np.array(faces, np.int32)


QUASI_STATIC: dict[str, Any] = {
    "integrator": "euler", "precision": "f64", "tolerance": 1e-3, "linear_iterations": 1000,
    "newton_iterations": 6, "newton_tolerance": 1e-6, "self_collision": False,
}  # fmt: skip
"""Settings for what is only to come to rest: a damped integrator, each step solved well enough."""


def settle(s: Stepper, speed: float, dt: float = 1 / 60, most: float = 6.0) -> None:
    """Step until no vertex is faster than `speed` [m/s]."""
    while np.linalg.norm(s.v, axis=1).max() > speed or s.time < 0.1:
        assert s.time < most, "it must come to rest"
        s.advance_to(s.time + 0.05, dt)


def ball(radius: float, level: int) -> tuple[np.ndarray, np.ndarray]:
    """A sphere about the origin, from an icosahedron cut `level` times, faces outward."""
    t = (1 + 5**0.5) / 2
    v = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t)]
    v += [(t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    f = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6)]
    f += [(7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10)]
    f += [(8, 6, 7), (9, 8, 1)]
    vertices, faces = np.array(v, float), np.array(f, np.int32)
    for _ in range(level):
        edges, opposite = unique_edges(faces)
        middle = len(vertices) + opposite
        vertices = np.concatenate([vertices, vertices[edges].mean(1)])
        a, b, c = faces.T
        bc, ca, ab = middle.T
        faces = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return radius * vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces.astype(np.int32)


def garment(vertices: np.ndarray, faces: np.ndarray, fabric: Fabric = PLAIN, name: str = "cloth") -> Garment:
    """A garment without elastics or waistband."""
    return Garment(
        name=name,
        vertices=vertices,
        faces=faces,
        fabric=fabric,
        rest_scale=np.ones(len(unique_edges(faces)[0])),
        tied=np.zeros(len(vertices), bool),
    )


def scene(
    *garments: Garment,
    start: np.ndarray | None = None,
    body: tuple[np.ndarray, np.ndarray] | None = None,
    motion: Callable[[int], np.ndarray] | None = None,
    frames: int = 1,
    pins: np.ndarray | None = None,
) -> Scene:
    """A scene; `motion(k)` is the place (3,) of the body at frame k, pinned vertices stay where they start."""
    x = np.concatenate([g.vertices for g in garments]) if start is None else start
    points, faces = body if body is not None else (np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    held = np.zeros(0, np.int64) if pins is None else pins
    return Scene(
        garments=garments,
        start=x,
        body_faces=faces,
        body=(lambda k: points) if motion is None else (lambda k: points + motion(k)),
        body_frames=1 if motion is None else frames + 1,
        frames=frames,
        pins=held,
        pin_goal=None if pins is None else (lambda time: x[held]),
    )


def stepper(scene: Scene, **settings: Any) -> Stepper:
    """A stepper at the start of `scene`, on one thread."""
    return make_stepper(scene, SimulateConfig(**{"threads": 1, **settings}))
