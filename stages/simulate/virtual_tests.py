"""Virtual experiments: a textile laboratory's tests of stiffness, drape and stretch, made on simulated cloth.

They measure what the solver's fabric does, on a mesh, beside what the constants promise and what is published of such
cloth. Everything comes to rest in thick air with a damped integrator; only the place of rest counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from stages.simulate.config import SimulateConfig
from stages.simulate.fabric import Fabric
from stages.simulate.make_stepper import make_stepper
from stages.simulate.scene import Garment, Scene
from stages.simulate.specimens import disc, strip
from stages.simulate.springs import GRAVITY, bending_rows, face_areas, hinges, unique_edges
from stages.simulate.springs import bending_length as peirce_length
from stages.simulate.stepper import Stepper
from stages.spec import DataError

STRIP_WIDTH = 0.025
"""Width of the strip of the cantilever test, ISO 4604 and ASTM D1388 [m]."""

CLOTH, SUPPORT = 0.15, 0.09
"""Radii of cloth and support of Cusick's drape test, BS 5058 and ISO 9073-9 [m]."""


def theoretical_bending_length(fabric: Fabric) -> float:
    """Peirce's bending length c = (B / w)^(1/3) [m], w the weight per area [N/m^2].

    Peirce 1930, "The handle of cloth as a measurable quantity".
    """
    return float(peirce_length(np.array(fabric.bend_stiffness), np.array(fabric.density)))


def elastica_angle(length: float, bending_length: float) -> float:
    """Angle below the horizon [rad] of the line from clamp to tip of an overhanging, inextensible strip.

    theta'' = -s / c^3 cos(theta) with s the distance from the tip, theta' = 0 at the tip and theta = 0 at the clamp. It
    is 41.5 degrees at a length of 2 c, which is how the standards measure c.
    """

    def shape(tip: float) -> np.ndarray:
        solved = solve_ivp(
            lambda s, q: [q[1], -s / bending_length**3 * np.cos(q[0]), np.cos(q[0]), np.sin(q[0])],
            (0.0, length),
            [tip, 0.0, 0.0, 0.0],
            rtol=1e-8,
            atol=1e-10,
        )
        end: np.ndarray = solved.y[:, -1]
        return end

    tip = brentq(lambda angle: shape(angle)[0], 0.0, np.pi / 2 - 1e-6, xtol=1e-8)
    _, _, along, down = shape(tip)
    return float(np.arctan2(down, along))


def bending_length(fabric: Fabric, edge: float = 0.005, threads: int = 0) -> float:
    """Bending length [m] by the cantilever test, on a mesh of edges of `edge` [m].

    A strip overhangs by 2 c; c is measured from the angle at which its tip comes to rest. It is as wide as whole edges
    are, about `STRIP_WIDTH`.
    """
    length = 2 * theoretical_bending_length(fabric)
    vertices, faces, _ = strip(length, max(1, round(STRIP_WIDTH / edge)) * edge, edge)
    held = np.flatnonzero(vertices[:, 0] < 1e-9)
    s = _stepper(fabric, vertices, faces, held, 40.0, threads)
    _clamp(s, fabric, vertices, faces, vertices[:, 0])
    _rest(s, 1e-3)
    tip = s.x[vertices[:, 0] > length - 1e-9].mean(0)
    angle = float(np.arctan2(-tip[2], tip[0]))
    return float(brentq(lambda c: elastica_angle(length, c) - angle, 0.2 * length, 2.0 * length, xtol=1e-6))


def drape_coefficient(
    fabric: Fabric,
    edge: float = 0.0125,
    folds: Sequence[int] = (5, 6, 7),
    threads: int = 0,
    turns: Sequence[float] = (0.05,),
) -> np.ndarray:
    """Drape coefficient by Cusick's test from each of several starts, shape [len(folds) len(turns)].

    (shadow - support) / (cloth - support), of a disc of 30 cm held flat on one of 18 cm. Draped cloth has many shapes
    to rest in: the coefficient scatters by several per cent from trial to trial, in the laboratory too (Kenkare et al.
    2008, "Enhancing accuracy of drape simulation, part I"), and rises with the number of folds. So the mean of several
    starts is what to compare, each with folds so high that most of them last; left to fall flat, cloth crumples into
    small folds that depend on its mesh.

    Args:
        fabric: The fabric; edge: of the mesh [m].
        folds: Numbers of folds that the cloth starts with, 3 cm high at its border; it may come to rest with others.
        threads: See `SimulateConfig`.
        turns: Where they start on the mesh [folds].
    """
    vertices, faces, held = disc(CLOTH, SUPPORT, edge)
    radius, turn = np.hypot(vertices[:, 0], vertices[:, 1]), np.arctan2(vertices[:, 1], vertices[:, 0])
    reach = np.clip((radius - SUPPORT) / (CLOTH - SUPPORT), 0.0, None)
    areas = face_areas(vertices, faces)
    flat, support = areas.sum(), areas[(radius[faces] < SUPPORT + 1e-9).all(1)].sum()
    found = []
    for count, by in product(folds, turns):
        start = vertices.copy()
        start[:, 2] = 0.03 * reach**2 * np.cos(count * turn + 2 * np.pi * by)
        s = _stepper(fabric, vertices, faces, held, 8.0, threads, start)
        _clamp(s, fabric, vertices, faces, radius - SUPPORT)
        _rest(s, 1e-3)
        found.append((shadow(s.x, faces) - support) / (flat - support))
    return np.array(found)


def extension(fabric: Fabric, load: float, edge: float = 0.01, threads: int = 0) -> float:
    """Strain of a strip that carries a weight of `load` [N] per metre of its width, hung along a row of edges.

    Along edges the mesh is as stiff as the constants say, as cloth is along its threads; across them what stiffens
    beyond `stretch_limit` stretches further, as cloth does on the bias.
    """
    width, length = 0.05, 0.1
    vertices, faces, _ = strip(width, length, edge, clamp=0)
    hung = np.stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]], axis=1)
    top, last = vertices[:, 1] < 1e-9, vertices[:, 1] > length - 1e-9
    s = _stepper(fabric, hung, faces, np.flatnonzero(top), 0.0, threads)
    # The two outer columns carry half of what is between two columns.
    share = np.where((vertices[:, 0] < 1e-9) | (vertices[:, 0] > width - 1e-9), 0.5, 1.0) * last
    s.springs.mass += load * width / GRAVITY * share / share.sum()
    _rest(s, 1e-3, step=1 / 30)
    return float((-s.x[last, 2] * share[last]).sum() / share.sum() / length - 1.0)


def shadow(x: np.ndarray, faces: np.ndarray, pixel: float = 2.5e-4) -> float:
    """Area [m^2] of what the triangles of `x` (N, 3) cover seen from above, in squares of `pixel` [m]."""
    low = x[:, :2].min(0)
    covered = np.zeros(np.ceil((x[:, :2].max(0) - low) / pixel).astype(int) + 1, bool)
    for corners in (x[faces][:, :, :2] - low) / pixel - 0.5:
        i, j = np.floor(corners.min(0)).astype(int).clip(0), np.ceil(corners.max(0)).astype(int)
        px, py = np.meshgrid(np.arange(i[0], j[0] + 1), np.arange(i[1], j[1] + 1), indexing="ij")
        sides = []
        for a, b in zip(corners, np.roll(corners, -1, axis=0)):
            sides.append((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0]))
        inside = (np.min(sides, axis=0) >= 0) | (np.max(sides, axis=0) <= 0)
        covered[i[0] : j[0] + 1, i[1] : j[1] + 1] |= inside[: covered.shape[0] - i[0], : covered.shape[1] - i[1]]
    return float(covered.sum()) * pixel**2


def _stepper(
    fabric: Fabric,
    vertices: np.ndarray,
    faces: np.ndarray,
    held: np.ndarray,
    air: float,
    threads: int,
    start: np.ndarray | None = None,
) -> Stepper:
    """A stepper of one specimen, `held` where it starts, in air that slows it at the rate `air` [1/s]."""
    x = vertices if start is None else start
    still = np.zeros((0, 3))
    specimen = Garment(
        name="specimen",
        vertices=vertices,
        faces=faces,
        fabric=replace(fabric, drag=air * fabric.density),
        rest_scale=np.ones(len(unique_edges(faces)[0])),
        tied=np.zeros(len(vertices), bool),
    )
    scene = Scene(
        garments=[specimen],
        start=x,
        body_faces=np.zeros((0, 3), np.int32),
        body=lambda k: still,
        body_frames=1,
        frames=1,
        pins=held,
        pin_goal=lambda time: x[held],
    )
    config = SimulateConfig(
        integrator="euler",
        precision="f64",
        tolerance=1e-3,
        linear_iterations=1000,
        newton_iterations=6,
        newton_tolerance=1e-6,
        self_collision=False,
        gravity=-GRAVITY,
        threads=threads,
    )
    return make_stepper(scene, config)


def _clamp(s: Stepper, fabric: Fabric, vertices: np.ndarray, faces: np.ndarray, beyond: np.ndarray) -> None:
    """Clamp cloth at its line of edges where `beyond` (N,) is 0: it is held there and where that is negative.

    A hinge on that line stands for cloth on either side, of which one half can't bend: it takes twice the moment.
    """
    opposite = beyond[hinges(faces)[:, 2:]]
    share = np.where((opposite.min(1) < -1e-9) & (opposite.max(1) > 1e-9), 2.0, 1.0)
    rigidity = np.full(len(vertices), fabric.bend_stiffness)
    length = np.full(len(vertices), theoretical_bending_length(fabric))
    s.springs.set_bending(*bending_rows(vertices, faces, rigidity, length, share))
    s.bend = s.springs.bend.astype(s.bend.dtype)


def _rest(s: Stepper, speed: float, step: float = 1 / 60, longest: float = 10.0) -> None:
    """Step until no vertex is faster than `speed` [m/s] at three times 0.1 s apart."""
    calm = 0
    while calm < 3:
        s.advance_to(s.time + 0.1, step)
        calm = calm + 1 if np.linalg.norm(s.v, axis=1).max() < speed else 0
        if s.time > longest:
            raise DataError(f"virtual test: the cloth has not come to rest within {longest:g} s; damp it more")
