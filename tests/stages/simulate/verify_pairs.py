"""Contact of cloth with cloth: layers stay apart and in order, momentum is kept, forces are gradients."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import EXACT, PLAIN, garment, scene, sheet, stepper

from stages.simulate.config import SimulateConfig
from stages.simulate.make_stepper import make_stepper
from stages.simulate.scene import Scene
from stages.simulate.solve import solve
from stages.simulate.stepper import Stepper


def _crossings(x: np.ndarray, faces: np.ndarray) -> int:
    """Edges that pass through a face they share no vertex with, by brute force."""
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    a, u, v = x[faces[:, 0]], x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]]
    count = 0
    for e in edges:
        p, d = x[e[0]], x[e[1]] - x[e[0]]
        h = np.cross(d, v)
        det = (u * h).sum(1)
        det = np.where(np.abs(det) < 1e-16, np.inf, det)
        s = p - a
        q = np.cross(s, u)
        b, c, t = (s * h).sum(1) / det, (q @ d) / det, (v * q).sum(1) / det
        hit = (b >= 0) & (c >= 0) & (b + c <= 1) & (t >= 0) & (t <= 1) & np.isfinite(det)
        count += int((hit & ~np.isin(faces, e).any(1)).sum())
    return count


def _two_sheets(height: float, tilt: float) -> tuple[Scene, np.ndarray]:
    """One garment of two sheets, the lower pinned at its corners, the upper above it, turned and tilted."""
    low, f = sheet(13, 13, 0.02)
    up = low * 0.7
    c, s = np.cos(0.4), np.sin(0.4)
    up = (up - up.mean(0)) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T + low.mean(0)
    up[:, 2] += height + tilt * (up[:, 0] - low[:, 0].mean())
    vertices, faces = np.concatenate([low, up]), np.concatenate([f, f + len(low)])
    pins = np.array([0, 12, 156, 168])
    return scene(garment(vertices, faces, replace(PLAIN, damping=2e-3)), pins=pins, frames=14), faces


def test_falling_sheet_is_caught_by_the_other() -> None:
    one, faces = _two_sheets(0.04, 0.2)
    assert _crossings(one.start, faces) == 0
    caught = solve(one, SimulateConfig(threads=1)).x
    assert _crossings(caught[-1], faces) == 0
    assert caught[-1, 169:, 2].mean() > caught[-1, :169, 2].min(), "the upper sheet lies on the lower one"
    through = solve(one, SimulateConfig(threads=1, self_collision=False)).x
    assert through[-1, 169:, 2].max() < through[-1, :169, 2].min(), "without collision it falls through"


def test_cloth_that_leaves_its_course_may_have_missed_pairs() -> None:
    one = scene(garment(*sheet(25, 25, 0.02)))
    pairs, x, dt = make_stepper(one, SimulateConfig(threads=1)).pairs, one.start, 0.01
    assert pairs is not None and pairs.widest_slack == pytest.approx(0.03)
    v = np.random.default_rng(0).normal(size=x.shape)
    reached = x + dt * v
    assert pairs.jerked(x, v, dt, reached) == -1, "as foreseen"
    assert pairs.jerked(x, v, dt, reached + np.array([0.0, 0.0, 1.0])) == -1, "the cloth as a whole"
    reached[40:42, 2] += 0.01
    assert pairs.jerked(x, v, dt, reached) == -1, "by less than is looked for beyond their reach"
    reached[40, 2] += 0.02
    assert pairs.jerked(x, v, dt, reached) == -1, "a single one of 625"
    reached[41, 2] += 0.03
    assert pairs.jerked(x, v, dt, reached) == 41


def test_entangled_garments_are_put_in_order() -> None:
    # The outer sheet starts tilted through the inner one, 3.6 mm deep at its border; no gravity.
    vertices, faces = sheet(13, 13, 0.02)
    outer = vertices + np.array([0.004, 0.003, 0.0])
    outer[:, 2] += 0.03 * (vertices[:, 0] - 0.119)
    one = scene(
        garment(vertices, faces, name="inner"),
        garment(vertices, faces, name="outer"),
        start=np.concatenate([vertices, outer]),
        frames=10,
    )
    both = np.concatenate([faces, faces + len(vertices)])
    assert _crossings(one.start, both) > 0
    x = solve(one, SimulateConfig(threads=1, gravity=0.0)).x[-1]
    assert _crossings(x, both) == 0
    apart = x[169:, 2] - x[:169, 2]
    assert apart.min() > 0
    # Without air or damping what little they push each other with is never lost: 1 m/s for a third of a second.
    assert apart.max() < 0.3, "they must not be flung apart"


def test_a_hem_that_has_flown_over_the_outer_garment_stays_outside() -> None:
    # The inner sheet lies 5 mm above the outer one, as a skirt does that was flung up over a top.
    vertices, faces = sheet(13, 13, 0.02)
    above = vertices + np.array([0.004, 0.003, 0.005])
    one = scene(
        garment(vertices, faces, name="inner"),
        garment(vertices, faces, name="outer"),
        start=np.concatenate([above, vertices]),
        frames=10,
    )
    s = stepper(one, gravity=0.0)
    assert s.pairs is not None
    s.pairs.untangle = 0.0  # they were put in order before
    s.advance_to(0.3, s.config.dt)
    assert _crossings(s.x, np.concatenate([faces, faces + len(vertices)])) == 0
    assert (s.x[:169, 2] - s.x[169:, 2]).min() > 0, "it must not be drawn through"


def test_pair_forces_keep_momentum() -> None:
    # Two free sheets pressed together: whatever the one gains the other loses.
    low, f = sheet(6, 6, 0.02)
    up = low + np.array([0.007, 0.004, 0.001])
    rest = np.concatenate([low, up + np.array([0.0, 0.0, 0.05])])
    one = scene(garment(rest, np.concatenate([f, f + len(low)])), start=np.concatenate([low, up]))
    s = stepper(one, gravity=0.0, **EXACT)
    s.advance_to(1 / 240, 1 / 240)
    moved = s.springs.mass[:, None] * s.v
    assert np.abs(moved[:36].sum(0)).max() > 1e-6, "they must push each other"
    np.testing.assert_allclose(moved.sum(0), 0, atol=1e-9)


def _pressed(kind: str) -> Stepper:
    """Two triangles 0.6 mm apart, far from each other at rest: a corner above a face, or two edges that cross."""
    if kind == "vertex-face":
        low = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.003], [0.02, 0.09, 0.0]])
        up = np.array([[0.035, 0.03, 0.0016], [0.05, 0.04, 0.06], [0.01, 0.05, 0.055]])
    else:
        low = np.array([[0.0, 0.0, 0.0], [0.01, 0.001, 0.0002], [0.005, 0.009, -0.006]])
        up = np.array([[0.004, -0.005, 0.0008], [0.0055, 0.006, 0.0011], [0.005, 0.0, 0.009]])
    rest = np.concatenate([low, up + np.array([0.0, 0.0, 0.2])])
    one = scene(
        garment(rest, np.array([[0, 1, 2], [3, 4, 5]], np.int32), replace(PLAIN, friction=0.0)),
        start=np.concatenate([low, up]),
    )
    s = stepper(one, precision="f64", pair_damping=0.0)
    assert s.pairs is not None
    s.pairs.search(s.x, s.v, 1 / 240)
    return s


def _pair_force(s: Stepper, x: np.ndarray) -> np.ndarray:
    assert s.pairs is not None
    force = np.zeros_like(x)
    s.pairs.evaluate(x, x, 1 / 240, force, np.zeros((len(x), 6)))
    return force


def _pair_energy(s: Stepper, kind: str, x: np.ndarray) -> float:
    """E = k/2 (gap - d)^2, k the stiffness times the mean area of the four vertices, d the distance of the parts."""
    if kind == "vertex-face":
        four, normal, a, b = (3, 0, 1, 2), np.cross(x[1] - x[0], x[2] - x[0]), x[3], x[0]
    else:
        four, normal, a, b = (0, 1, 3, 4), np.cross(x[1] - x[0], x[4] - x[3]), x[3], x[0]
    distance = abs((a - b) @ normal) / np.linalg.norm(normal)
    k = s.config.contact_stiffness * s.springs.area[list(four)].mean()
    return float(0.5 * k * max(0.0, s.config.thickness - distance) ** 2)


@pytest.mark.parametrize("kind", ["vertex-face", "edge-edge"])
def test_pair_force_is_the_gradient_of_its_energy(kind: str) -> None:
    s = _pressed(kind)
    force = _pair_force(s, s.x)
    assert s.pairs is not None
    assert s.pairs.count == 1, "one pair and nothing else"
    assert np.abs(force).max() > 1e-3
    step = 1e-8
    for vertex in range(6):
        for axis in range(3):
            e = np.zeros_like(s.x)
            e[vertex, axis] = step
            slope = (_pair_energy(s, kind, s.x + e) - _pair_energy(s, kind, s.x - e)) / (2 * step)
            assert -force[vertex, axis] == pytest.approx(slope, abs=1e-5 * np.abs(force).max())


@pytest.mark.parametrize("kind", ["vertex-face", "edge-edge"])
def test_pair_stiffness_is_the_derivative_of_its_force(kind: str) -> None:
    # The block is that of Gauss and Newton, k n n^T w_i w_j: the derivative for every motion that doesn't turn the
    # normal. A shift of each part as a whole is such a motion.
    s = _pressed(kind)
    _pair_force(s, s.x)
    assert s.pairs is not None
    corners, w, block = s.pairs.vertices[0], s.pairs.weights[0], s.pairs.block[0]
    k = block[0] * np.eye(3) + np.outer(block[1:], block[1:])
    assert np.linalg.norm(k) > 1.0
    parts = (np.array([3]), np.array([0, 1, 2])) if kind == "vertex-face" else (np.array([0, 1]), np.array([3, 4]))
    rng = np.random.default_rng(0)
    for moved in parts:
        e = np.zeros_like(s.x)
        e[moved] = rng.normal(size=3)
        slope = (_pair_force(s, s.x + 1e-8 * e) - _pair_force(s, s.x - 1e-8 * e)) / 2e-8
        shift = w @ e[corners]
        # Where the shift moves the point of contact along, the parts' shares of the force change, not their sums.
        for part in parts:
            weight = w[np.isin(corners, part)].sum()
            expected = -weight * k @ shift
            np.testing.assert_allclose(slope[part].sum(0), expected, atol=1e-4 * np.linalg.norm(k @ shift))
