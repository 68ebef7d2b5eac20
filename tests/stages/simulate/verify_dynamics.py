"""The integrator and the springs against closed forms and conservation laws."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import EXACT, PLAIN, garment, scene, sheet, stepper

DT = 1 / 240


@pytest.mark.parametrize(("integrator", "error"), [("euler", 0.5 * 9.81 * DT * 0.5), ("bdf2", 9.81 * DT**2)])
def test_free_fall(integrator: str, error: float) -> None:
    # z = g t^2 / 2. Implicit Euler is g h t / 2 too far down, exactly; BDF2 differs by its first, Euler step alone.
    s = stepper(scene(garment(*sheet(4, 4, 0.02))), integrator=integrator, self_collision=False, **EXACT)
    s.advance_to(0.5, DT)
    z = s.x[:, 2]
    assert np.ptp(z) < 1e-9
    assert abs(z.mean() + 0.5 * 9.81 * 0.25) <= error * 1.01
    assert abs(s.v[:, 2].mean() + 9.81 * 0.5) < 1e-6


def test_momentum_is_kept_without_outer_forces() -> None:
    vertices, faces = sheet(7, 6, 0.02)
    cloth = garment(vertices, faces, replace(PLAIN, damping=1e-3))
    s = stepper(scene(cloth), gravity=0.0, self_collision=False, **EXACT)
    s.v[:] = np.random.default_rng(3).normal(size=vertices.shape)
    mass = s.springs.mass[:, None]
    linear, angular = (mass * s.v).sum(0), np.cross(s.x, mass * s.v).sum(0)
    energy = 0.5 * (mass * s.v**2).sum()
    s.advance_to(0.05, 1 / 2000)
    assert np.linalg.norm(linear) > 1e-4
    np.testing.assert_allclose((mass * s.v).sum(0), linear, rtol=0, atol=1e-9 * np.abs(mass).sum())
    # Angular momentum isn't kept exactly by an implicit step, but it must stay near.
    np.testing.assert_allclose(np.cross(s.x, mass * s.v).sum(0), angular, atol=0.05 * np.linalg.norm(angular))
    assert 0.5 * (mass * s.v**2).sum() < energy


def _oscillator(steps: int, integrator: str) -> float:
    """Displacement over amplitude, after 5/8 of a period in `steps` steps, of a vertex between two fixed ones."""
    vertices = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.05, 0.05, 0.0]])
    s = stepper(
        scene(garment(vertices, np.array([[0, 1, 2]], np.int32)), pins=np.array([0, 1])),
        gravity=0.0, self_collision=False, integrator=integrator, **EXACT,
    )  # fmt: skip
    # Two springs at +-45 degrees: K_yy = 2 k sin^2 45 = k, so that omega^2 = k / m.
    k, m = s.springs.stiffness, s.springs.mass[2]
    np.testing.assert_allclose(k[1], k[2])
    time = 1.25 * np.pi / float(np.sqrt(k[1] / m))
    amplitude = 1e-8
    s.x[2, 1] += amplitude
    s.advance_to(time, time / steps)
    return float(s.x[2, 1] - 0.05) / amplitude


def test_spring_frequency_and_order() -> None:
    # y = cos(omega t); the error of BDF2 falls with h^2, that of implicit Euler with h.
    for integrator, order in (("bdf2", 2), ("euler", 1)):
        errors = [abs(_oscillator(steps, integrator) - np.cos(1.25 * np.pi)) for steps in (50, 100, 200)]
        measured = np.log2(errors[0] / errors[1]), np.log2(errors[1] / errors[2])
        assert 1e-5 < errors[2] < 0.05
        assert all(abs(m - order) < 0.3 for m in measured), (integrator, errors)


def test_pinned_pendulum_keeps_its_energy() -> None:
    # A strip hung by one edge, let go level: kinetic plus potential energy doesn't rise, and little is lost to BDF2.
    vertices, faces = sheet(8, 3, 0.02)
    s = stepper(scene(garment(vertices, faces), pins=np.arange(3)), self_collision=False, **EXACT)
    m = s.springs.mass

    def energy() -> float:
        return float((0.5 * m[:, None] * s.v**2).sum() + 9.81 * (m * s.x[:, 2]).sum())

    start, seen = energy(), []
    for k in range(1, 31):
        s.advance_to(k / 120, DT)
        seen.append(energy())
    swing = 9.81 * (m * 0.07).sum()
    assert max(seen) < start + 0.02 * swing
    assert s.x[:, 2].min() < -0.07
