"""Scenes of the extreme cases: cloth that hangs, falls on a ball, is hit by a limb, starts where it shouldn't."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stages.simulate.fabric import Fabric
from stages.simulate.scene import Garment, Scene
from stages.simulate.springs import unique_edges
from tools.solver.meshes import Mesh, capsule, sheet, tube

FPS = 30.0
RADIUS = 0.15
"""Of the ball [m]."""
GAP = 0.01
"""Between cloth and body at the start [m]."""


def fabric(stiffness: float = 1.0, density: float = 1.0, friction: float | None = None) -> Fabric:
    """The default fabric, its stiffnesses and density multiplied."""
    plain = Fabric()
    return replace(
        plain,
        density=plain.density * density,
        stretch_stiffness=plain.stretch_stiffness * stiffness,
        shear_stiffness=plain.shear_stiffness * stiffness,
        bend_stiffness=plain.bend_stiffness * stiffness,
        friction=plain.friction if friction is None else friction,
    )


PLAIN = fabric()
"""The default fabric as it is."""


def garment(mesh: Mesh, cloth: Fabric, name: str = "cloth") -> Garment:
    """A garment without elastics or waistband."""
    vertices, faces = mesh
    scale = np.ones(len(unique_edges(faces)[0]))
    return Garment(
        name=name, vertices=vertices, faces=faces, fabric=cloth, rest_scale=scale, tied=np.zeros(len(vertices), bool)
    )


def scene(
    garments: list[Garment],
    start: np.ndarray,
    frames: int,
    body: Mesh | None = None,
    place: Callable[[int], np.ndarray] | None = None,
    pins: np.ndarray | None = None,
    pulled: Callable[[float], np.ndarray] | None = None,
) -> Scene:
    """A scene about a body that stays, or is at `place(k)` (3,) [m] in frame k.

    Args:
        garments: From the inner to the outer; start: first positions [m], shape [N, 3].
        frames: Frames to simulate.
        body: The body about the origin; none if left out.
        place: Where the body is in frame k.
        pins: Vertices that stay where they start, moved by pulled(time [s]) (3,) [m].
        pulled: Their way.
    """
    points, faces = body if body is not None else (np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    held = np.zeros(0, np.int64) if pins is None else pins
    way = (lambda time: np.zeros(3)) if pulled is None else pulled
    return Scene(
        garments=garments,
        start=start,
        body_faces=faces,
        body=(lambda k: points) if place is None else (lambda k: points + place(k)),
        body_frames=1 if place is None else frames + 1,
        frames=frames,
        fps=FPS,
        pins=held,
        pin_goal=None if pins is None else (lambda time: start[held] + way(time)),
    )


def cloth_of(mesh: Mesh | None) -> Mesh:
    """The sheet that most cases use, unless they bring their own: 0.46 m, 2 cm edges."""
    return sheet(24, 0.02) if mesh is None else mesh


def hang(
    mesh: Mesh | None = None,
    cloth: Fabric = PLAIN,
    frames: int = 15,
    pulled: Callable[[float], np.ndarray] | None = None,
) -> Scene:
    """A flat sheet let go at rest, held at the two corners of one side."""
    vertices, faces = cloth_of(mesh)
    pins = np.array([np.argmin(vertices @ [1.0, side, 0.0]) for side in (-1.0, 1.0)])
    return scene([garment((vertices, faces), cloth)], vertices, frames, pins=pins, pulled=pulled)


def drop(
    mesh: Mesh | None = None,
    cloth: Fabric = PLAIN,
    frames: int = 15,
    radius: float = RADIUS,
    height: float = GAP,
    place: Callable[[int], np.ndarray] | None = None,
) -> Scene:
    """A flat sheet let go at rest, `height` [m] above the top of a ball; below 0 it starts through the ball."""
    vertices, faces = cloth_of(mesh)
    # Off centre, so that nothing is balanced by symmetry alone.
    start = vertices + np.array([0.1 * radius, 0.07 * radius, radius + height])
    return scene([garment((vertices, faces), cloth)], start, frames, capsule(radius, 0.0, 32), place)


def moved(change: Callable[[int], float]) -> Callable[[int], np.ndarray]:
    """A way along x: `change(k)` [m] in frame k."""
    return lambda k: np.array([change(k), 0.0, 0.0])


def swing(speed: float, cloth: Fabric = PLAIN, mesh: Mesh | None = None, held: bool = True) -> Scene:
    """A limb that comes at `speed` [m/s] and goes through a curtain, held at the corners of its top or falling."""
    vertices, faces = cloth_of(mesh)
    upright = vertices[:, [2, 0, 1]]
    top = upright[:, 2].max()
    pins = np.array([np.argmax(upright @ [0.0, side, 2.0]) for side in (-1.0, 1.0)])
    limb, limb_faces = capsule(0.05, 0.4)
    lying = limb[:, [1, 2, 0]] + np.array([0.0, 0.0, top - 0.3])
    frames = int(np.ceil(1.1 / speed * FPS)) + 6
    stop = int(np.ceil(0.8 / speed * FPS))

    def place(k: int) -> np.ndarray:
        return np.array([-0.25 - 0.05 - GAP + speed / FPS * min(k, stop), 0.0, 0.0])

    return scene(
        [garment((upright, faces), cloth)], upright, frames, (lying, limb_faces), place, pins if held else None
    )


def sleeve(gap: float, frames: int = 15) -> Scene:
    """A tube about a limb, `gap` [m] wider than it; below 0 it starts inside, all around."""
    mesh = tube(24, 16, 0.05 + gap, 0.015)
    vertices, faces = mesh
    lying = vertices[:, [2, 0, 1]]
    limb, limb_faces = capsule(0.05, 0.6, 32)
    return scene([garment((lying, faces), PLAIN)], lying, frames, (limb[:, [2, 0, 1]], limb_faces))


def crossed_layers(frames: int = 15) -> Scene:
    """Two sheets on a ball that start through each other, at an angle."""
    mesh = sheet(20, 0.02)
    turn = np.radians(3.0)
    tilted = mesh[0] @ np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    start = np.concatenate([mesh[0], tilted]) + np.array([0.0, 0.0, RADIUS + 2 * GAP])
    layers = [garment(mesh, PLAIN, "inner"), garment(mesh, PLAIN, "outer")]
    return scene(layers, start, frames, capsule(RADIUS, 0.0, 32))


def crossed_folds(frames: int = 15) -> Scene:
    """A sheet laid in an S whose folds pass through each other, falling on a ball."""
    vertices, faces = sheet(24, 0.02)
    s = vertices[:, 0] / 0.23
    x = 0.1 * np.sin(2.4 * np.pi * s / 2)
    z = RADIUS + 0.03 + 0.012 * np.sin(4.8 * np.pi * s / 2) + 0.0 * s
    return scene(
        [garment((vertices, faces), PLAIN)],
        np.column_stack([x, vertices[:, 1], z]),
        frames,
        capsule(RADIUS, 0.0, 32),
    )


def crumpled(frames: int = 15) -> Scene:
    """A sheet whose every vertex starts up to one edge from its place, at random."""
    vertices, faces = sheet(20, 0.02)
    noise = np.random.default_rng(3).uniform(-0.02, 0.02, vertices.shape)
    start = vertices + noise + np.array([0.0, 0.0, RADIUS + 0.05])
    return scene([garment((vertices, faces), PLAIN)], start, frames, capsule(RADIUS, 0.0, 32))


def one_triangle(frames: int = 15) -> Scene:
    """A single triangle that falls on a ball."""
    vertices = np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.0, 0.05, 0.0]])
    start = vertices + np.array([0.01, 0.005, RADIUS + GAP])
    return scene([garment((vertices, np.array([[0, 1, 2]], np.int32)), PLAIN)], start, frames, capsule(RADIUS, 0.0, 32))
