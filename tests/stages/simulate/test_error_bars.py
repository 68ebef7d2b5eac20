"""Error bars: the windows start where the sequence was, measure what they say, and leave the sequence alone."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import EXACT, PLAIN, ball, garment, scene, sheet

from stages.simulate import error_bars
from stages.simulate.config import SimulateConfig
from stages.simulate.error_bars import Windows, compare, simulate_again
from stages.simulate.finer import cut_in_four
from stages.simulate.make_stepper import make_springs
from stages.simulate.scene import Scene, edge_scale
from stages.simulate.solve import solve
from stages.spec import DataError

FABRIC = replace(PLAIN, damping=2e-3, drag=0.2)
QUICK = {"threads": 1, "error_bar_windows": 2, "error_bar_frames": 2}


def _busy() -> Scene:
    """Two sheets, one above the other, that fall onto a ball on the move: friction, ties, elastics, pairs of cloth."""
    vertices, faces = sheet(9, 9, 0.02)
    marks = (vertices[:, 0] < 0.03).astype(np.int64)
    scale, band = edge_scale(faces, marks, {1: 0.9}), vertices[:, 1] < 0.01
    under = replace(garment(vertices, faces, FABRIC, "under"), rest_scale=scale, tied=band)
    over = garment(vertices * 0.9, faces, FABRIC, "over")
    start = np.concatenate([vertices, vertices * 0.9 + 0.01]) + np.array([-0.08, -0.08, 0.103])
    start[len(vertices) :, 2] -= 0.008
    one = scene(
        under, over, start=start, body=ball(0.1, 3), motion=lambda k: np.array([2e-4 * k**2, 0, 1e-3 * k]), frames=9
    )
    return replace(one, record=2, ease_in=3)


def test_a_window_at_the_sequences_own_step_repeats_its_bits_and_watching_changes_none() -> None:
    # It fails as soon as a step takes anything from the steps before it that a snapshot doesn't hold.
    one, config = _busy(), SimulateConfig(**QUICK, pair_every=50)
    windows = Windows(one, config)
    x = solve(one, config, observe=windows).x
    np.testing.assert_array_equal(x, solve(one, config).x)
    assert windows.starts == [2, 6]
    again = simulate_again(one, config, 1.0)
    assert max(np.abs(state.contact["shear"]).max() for state in windows.states.values()) > 0
    for start in reversed(windows.starts):
        state = windows.states[start]
        assert state.pairs["total"] > 0
        for moved, expected in zip(again(state, start), x[start - 1 :], strict=True):
            np.testing.assert_array_equal(moved, expected)


def test_differences_are_those_from_whole_runs_at_half_the_step_and_on_the_finer_mesh() -> None:
    one = replace(_busy(), record=0, frames=3)
    config = SimulateConfig(threads=1, error_bar_windows=1, error_bar_frames=3)
    windows = Windows(one, config)
    x = solve(one, config, observe=windows).x
    told: list[float] = []
    bars = compare(one, config, windows, x, told.append)
    finer = cut_in_four(one)
    half = solve(one, replace(config, dt=config.dt / 2)).x
    fine = solve(finer.scene, config).x[:, finer.old]
    assert bars.frames.tolist() == [[1, 2, 3]]
    for kind, other in (("step", half), ("mesh", fine)):
        distance = np.linalg.norm(other - x, axis=2)[1:]
        assert distance[-1].max() > 1e-5
        for i, part in enumerate((distance[:, :81], distance[:, 81:])):
            np.testing.assert_allclose(bars.errors[kind][0, :, i, 0], np.sqrt((part**2).mean(1)), rtol=1e-12)
            np.testing.assert_allclose(bars.errors[kind][0, :, i, 1], part.max(1), rtol=1e-12)
    assert told == sorted(set(told))
    assert told[-1] == windows.cost
    arrays, summary = bars.arrays(), bars.summary()
    np.testing.assert_array_equal(arrays["garments/over/mesh_error_max"], bars.errors["mesh"][:, :, 1, 1])
    assert summary["step_error_max_m"] == bars.errors["step"][..., 1].max()
    assert summary["mesh_error_rms_m"] == pytest.approx(np.hypot(*bars.errors["mesh"][0, -1, :, 0]) / 2**0.5)
    assert "error_windows_failed" not in summary


def test_finer_cloth_is_the_same_cloth() -> None:
    # Under any motion that is linear in each old triangle: equal mass, momentum and energy of stretch.
    one = _busy()
    one = replace(one, pins=np.array([4, 5, 90]), pin_goal=lambda time: one.start[[4, 5, 90]] + time)
    finer = cut_in_four(one)
    coarse, fine = make_springs(one), make_springs(finer.scene)
    assert fine.mass.sum() == pytest.approx(coarse.mass.sum(), rel=1e-12)
    moved = one.start + np.random.default_rng(0).normal(0, 0.004, one.start.shape)
    np.testing.assert_allclose(fine.mass @ finer.spread(moved), coarse.mass @ moved, rtol=1e-12)
    energies = []
    for springs, x in ((coarse, moved), (fine, finer.spread(moved))):
        stretch = np.linalg.norm(x[springs.edges[:, 0]] - x[springs.edges[:, 1]], axis=1) - springs.rest_length
        energies.append((0.5 * springs.stiffness * stretch**2).sum())
    assert energies[1] == pytest.approx(energies[0], rel=1e-9)
    assert energies[0] > 1e-3
    np.testing.assert_array_equal(finer.spread(moved)[finer.old], moved)
    flags = np.arange(len(moved)) % 2
    np.testing.assert_array_equal(finer.spread(flags), flags[finer.parents].any(1))
    # Ties and pins hold the middles of what they hold both ends of.
    assert finer.scene.garments[0].tied.sum() == 9 + 8
    assert set(finer.scene.pins) >= set(finer.old[one.pins])
    assert len(finer.scene.pins) == 4
    np.testing.assert_allclose(finer.scene.pin_goal(0.5), finer.scene.start[finer.scene.pins] + 0.5, rtol=1e-12)


def test_differences_shrink_with_the_square_of_the_step() -> None:
    # BDF2: |x(dt) - x(dt/2)| ~ dt^2. A soft sheet that swings from a corner, solved to rounding.
    vertices, faces = sheet(3, 3, 0.1)
    soft = replace(PLAIN, stretch_stiffness=3.0, shear_stiffness=1.125, stretch_limit=10.0)
    one = scene(garment(vertices, faces, soft), pins=np.array([0]), frames=4)
    errors = []
    for dt in (1 / 240, 1 / 480):
        config = SimulateConfig(dt=dt, self_collision=False, **QUICK, **EXACT)
        windows = Windows(one, config)
        x = solve(one, config, observe=windows).x
        errors.append(compare(one, config, windows, x).errors["step"][:, -1, 0, 0])
    ratios = errors[0] / errors[1]
    assert 3.5 < ratios.min() <= ratios.max() < 4.5


@pytest.mark.parametrize(
    "frames, record, count, length, starts",
    [(100, 10, 3, 10, [20, 50, 80]), (9, 2, 3, 10, [2]), (25, 0, 3, 10, [1, 13]), (5, 5, 3, 10, [])],
)
def test_windows_are_spread_apart_over_what_is_recorded(
    frames: int, record: int, count: int, length: int, starts: list[int]
) -> None:
    one = replace(_busy(), frames=frames, record=record)
    windows = Windows(one, SimulateConfig(error_bar_windows=count, error_bar_frames=length))
    assert windows.starts == starts
    ends = [start + windows.length for start in windows.starts]
    assert all(end <= after for end, after in zip(ends, [*windows.starts[1:], frames]))


def test_a_window_that_fails_is_counted_and_the_others_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces = sheet(4, 4, 0.02)
    one = scene(garment(vertices, faces), frames=4)
    config = SimulateConfig(**QUICK)
    windows = Windows(one, config)
    x = solve(one, config, observe=windows).x
    advance = error_bars.advance_frame

    def fails(stepper, frame, share):
        if frame == 2 and share == 1.0:
            raise DataError("simulation failed at frame 2")
        advance(stepper, frame, share)

    monkeypatch.setattr(error_bars, "advance_frame", fails)
    bars = compare(one, config, windows, x)
    assert bars.frames.tolist() == [[3, 4]]
    assert bars.summary()["error_windows_failed"] == 1
    monkeypatch.setattr(error_bars, "advance_frame", lambda *_: fails(None, 2, 1.0))
    nothing = compare(one, config, windows, x)
    assert nothing.arrays() == {}
    assert nothing.summary() == {"error_windows_failed": 2}


def test_cloth_in_free_fall_has_no_error_of_the_mesh() -> None:
    vertices, faces = sheet(5, 5, 0.02)
    one = scene(garment(vertices, faces), frames=4)
    config = SimulateConfig(**QUICK, **EXACT)
    windows = Windows(one, config)
    bars = compare(one, config, windows, solve(one, config, observe=windows).x)
    assert bars.errors["mesh"].max() < 1e-12
