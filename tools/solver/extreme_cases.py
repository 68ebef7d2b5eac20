"""The matrix of extremes, as data: every case a scene, its settings and what may be asked of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from stages.simulate.scene import Scene
from tools.solver import meshes
from tools.solver.people import person
from tools.solver.scenes import (
    FPS,
    GAP,
    crossed_folds,
    crossed_layers,
    crumpled,
    drop,
    fabric,
    hang,
    moved,
    one_triangle,
    sleeve,
    swing,
)


@dataclass(frozen=True, kw_only=True)
class Case:
    """One case.

    Attributes:
        name: Its name, which no other has; group: the extreme that it is part of.
        build: Makes the scene.
        settings: Knobs that aren't at their defaults.
        still: Whether nothing moves but the cloth: its energy can't grow then.
        push: Speed [m/s] that a start inside a body or tangled may give the cloth, beyond motion and fall.
        limit: Time after which it counts as endless [s].
    """

    name: str
    group: str
    build: Callable[[], Scene]
    settings: dict[str, Any] = field(default_factory=dict)
    still: bool = False
    push: float = 0.0
    limit: float = 180.0


def _both(group: str, label: str, cloth: Any = None, mesh: Any = None, **settings: Any) -> list[Case]:
    """A sheet that hangs and one that falls on a ball."""
    given = {key: value for key, value in (("cloth", cloth), ("mesh", mesh)) if value is not None}
    return [
        Case(name=f"{label}, hangs", group=group, build=partial(hang, **given), settings=settings, still=True),
        Case(
            name=f"{label}, falls on a ball", group=group, build=partial(drop, **given), settings=settings, still=True
        ),
    ]


def _sized(edge: float, count: int) -> list[Case]:
    """Sheets of one edge length [m], on a ball of a third of their width."""
    mesh, label = meshes.sheet(count, edge), f"edges {edge * 1e3:g} mm"
    ball = partial(drop, mesh, radius=edge * count / 3)
    return [
        Case(name=f"{label}, hangs", group="edges", build=partial(hang, mesh), still=True),
        Case(name=f"{label}, falls on a ball", group="edges", build=ball, still=True),
    ]


def _corners() -> list[Case]:
    """Thin and fat, small and large people in the tightest and the loosest of every kind of outfit."""
    kinds = ("tshirt+trousers", "dress", "top+skirt", "jumpsuit", "tshirt+skirt", "top+trousers")
    corners = [(a, b, t) for a in (-3.0, 3.0) for b in (-3.0, 3.0) for t in (-1.5, 0.5)]
    return [
        Case(
            name=f"betas {a:+g} {b:+g}, tightness {t:+g}, {kinds[k % len(kinds)]}",
            group="shape and tightness",
            build=partial(
                person, ("female", "male")[k % 2], kinds[k % len(kinds)], (a, b), (t, t), frames=4, edge=0.014
            ),
            limit=300.0,
        )
        for k, (a, b, t) in enumerate(corners)
    ]


_CASES = [
    *[c for s in (1e-3, 0.1, 10, 1e3, 1e4) for c in _both("stiffness", f"stiffness x {s:g}", fabric(stiffness=s))],
    *[c for d in (0.01, 0.1, 10, 100) for c in _both("density", f"density x {d:g}", fabric(density=d))],
    *[c for n in (30, 60, 240, 2000) for c in _both("step", f"step 1/{n} s", dt=1 / n)],
    *[c for edge, count in ((0.002, 50), (0.005, 50), (0.02, 30), (0.05, 16)) for c in _sized(edge, count)],
    *_both("edges", "edges 2 to 40 mm", mesh=meshes.graded(0.002, 0.04, 0.3)),
    *_both("slivers", "needles 1:100", mesh=meshes.needles(20, 0.02, 0.01)),
    *_both("slivers", "caps 1:100", mesh=meshes.caps(20, 0.02, 0.01)),
    *[Case(name=f"limb at {v:g} m/s", group="limb", build=partial(swing, v)) for v in (5.0, 10.0, 15.0)],
    Case(
        name="limb at 15 m/s, light and soft",
        group="limb",
        build=partial(swing, 15.0, fabric(stiffness=0.1, density=0.1)),
    ),
    Case(name="frozen body", group="body", build=partial(drop, place=moved(lambda k: 0.0), frames=30), still=True),
    Case(
        name="ball jumps 0.1 m in a frame",
        group="body",
        build=partial(drop, place=moved(lambda k: 0.1 * (k > 12)), frames=24),
    ),
    Case(
        name="ball jumps 1 m in a frame",
        group="body",
        build=partial(drop, place=moved(lambda k: 1.0 * (k > 12)), frames=24),
    ),
    Case(
        name="pins jump 0.2 m in a frame",
        group="body",
        build=partial(hang, pulled=lambda t: moved(lambda k: -0.2 * min(max(t * FPS - 5, 0), 1))(0)),
    ),
    *[
        Case(
            name=f"starts {depth * 1e3:g} mm inside the ball",
            group="starts inside",
            build=partial(drop, height=-depth),
            push=1.0,
        )
        for depth in (0.005, 0.03, 0.14)
    ],
    Case(name="sleeve 5 mm tighter than the limb", group="starts inside", build=partial(sleeve, -0.005), push=1.0),
    Case(name="sleeve 20 mm tighter than the limb", group="starts inside", build=partial(sleeve, -0.02), push=1.0),
    Case(name="layers start crossed", group="starts tangled", build=crossed_layers, push=1.0),
    Case(name="folds start crossed", group="starts tangled", build=crossed_folds, push=1.0),
    Case(name="every vertex an edge off", group="starts tangled", build=crumpled, push=5.0),
    *_both("gravity", "zero gravity", gravity=0.0),
    Case(name="zero gravity, limb at 5 m/s", group="gravity", build=partial(swing, 5.0), settings={"gravity": 0.0}),
    *[
        Case(
            name=f"friction {mu:g}, falls on a ball",
            group="friction",
            build=partial(drop, cloth=fabric(friction=mu), frames=30),
            still=True,
        )
        for mu in (0.0, 5.0)
    ],
    *[
        Case(
            name=f"friction {mu:g}, limb at 5 m/s",
            group="friction",
            # A curtain that is held and can't slip would be torn.
            build=partial(swing, 5.0, fabric(friction=mu), held=False),
        )
        for mu in (0.0, 5.0)
    ],
    Case(name="1 triangle", group="size", build=one_triangle, still=True),
    Case(
        name="200 k vertices",
        group="size",
        build=lambda: hang(meshes.sheet(448, 0.003), frames=2),
        still=True,
        limit=300.0,
    ),
    Case(name="1 frame", group="size", build=partial(drop, frames=1, height=GAP), still=True),
    Case(
        name="3,000 frames",
        group="size",
        build=lambda: hang(meshes.sheet(8, 0.03), frames=3000),
        still=True,
        limit=300.0,
    ),
    *_corners(),
    *_both("accuracy", "preview", accuracy="preview"),
    *_both("accuracy", "reference", accuracy="reference", mesh=meshes.sheet(12, 0.04)),
]

CASES = {case.name: case for case in _CASES}
"""The cases by name, in the order of the table."""
