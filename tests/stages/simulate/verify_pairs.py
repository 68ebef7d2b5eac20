"""Contact of cloth with cloth: layers stay apart and in order, momentum is kept."""

from dataclasses import replace

import numpy as np
from small_scenes import EXACT, PLAIN, garment, scene, sheet, stepper

from stages.simulate.config import SimulateConfig
from stages.simulate.scene import Scene
from stages.simulate.solve import solve


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
