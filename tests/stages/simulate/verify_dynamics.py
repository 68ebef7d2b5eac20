"""The integrator and the springs against closed forms and conservation laws."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from small_scenes import EXACT, PLAIN, garment, scene, sheet, stepper

from stages.simulate.specimens import strip

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


@pytest.mark.parametrize(("integrator", "order"), [("bdf2", 2), ("euler", 1)])
def test_pendulum_and_order(integrator: str, order: int) -> None:
    # The third corner of a triangle swings about the fixed first side, let go level: phi'' = -g / L cos(phi), phi below
    # the horizon. The springs are stiff enough to count as rods: m g / k is a millionth of the length.
    length = 0.05 * 3**0.5 / 2
    vertices = np.array([[0.0, 0.0, 0.0], [0.0, 0.05, 0.0], [length, 0.025, 0.0]])
    rods = replace(PLAIN, stretch_stiffness=1e5, shear_stiffness=3.75e4)
    one = scene(garment(vertices, np.array([[0, 1, 2]], np.int32), rods), pins=np.array([0, 1]))
    time = 0.1
    exact = solve_ivp(lambda t, q: [q[1], 9.81 / length * np.cos(q[0])], (0, time), [0, 0], rtol=1e-11, atol=1e-13)
    angle = exact.y[0, -1]
    assert angle > 1.0, "it must have swung far"
    errors = []
    for steps in (20, 40, 80):
        s = stepper(one, integrator=integrator, self_collision=False, **EXACT)
        s.advance_to(time, time / steps)
        errors.append(abs(np.arctan2(-s.x[2, 2], s.x[2, 0]) - angle))
    assert errors[2] > 1e-5, "there must be an error whose order can be seen"
    measured = np.log2(errors[0] / errors[1]), np.log2(errors[1] / errors[2])
    assert all(abs(m - order) < 0.3 for m in measured), errors


def test_flight_keeps_momentum() -> None:
    # A sheet thrown tumbling through empty space at 2 m/s, 10 rad/s: linear momentum is exact; of the angular one
    # BDF2 loses 0.2 % in that quarter of a second at 1/240 s, and a quarter of that with half the step.
    vertices, faces = sheet(5, 4, 0.02)
    spin, throw, time = np.array([6.0, -8.0, 0.0]), np.array([1.0, 0.5, 1.7]), 0.25
    lost = []
    for dt in (1 / 240, 1 / 480):
        s = stepper(scene(garment(vertices, faces)), gravity=0.0, self_collision=False, **EXACT)
        m = s.springs.mass[:, None]
        centre = (m * s.x).sum(0) / m.sum()
        s.v[:] = throw + np.cross(spin, s.x - centre)
        before = np.cross(s.x - centre, m * (s.v - throw)).sum(0)
        s.advance_to(time, dt)
        np.testing.assert_allclose((m * s.v).sum(0), m.sum() * throw, atol=1e-9)
        np.testing.assert_allclose((m * s.x).sum(0) / m.sum(), centre + time * throw, atol=1e-6)
        after = np.cross(s.x - centre - time * throw, m * (s.v - throw)).sum(0)
        lost.append(np.linalg.norm(after - before) / np.linalg.norm(before))
    assert 1e-5 < lost[0] < 0.004
    assert lost[1] < 0.3 * lost[0]


def test_terminal_velocity_and_wind() -> None:
    # rho v' = rho g - c v: v = g rho / c (1 - exp(-c t / rho)) whatever the step; alike, wind carries cloth along.
    cloth = garment(*sheet(4, 4, 0.02), replace(PLAIN, drag=2.0))
    rate = 2.0 / PLAIN.density
    s = stepper(scene(cloth), self_collision=False, **EXACT)
    for time in (0.1, 0.2, 1.0):
        s.advance_to(time, 1 / 240)
        assert s.v[:, 2].mean() == pytest.approx(-9.81 / rate * (1 - np.exp(-rate * time)), rel=2e-3)
    s = stepper(replace(scene(cloth), wind=(3.0, -1.0, 0.0)), gravity=0.0, self_collision=False, **EXACT)
    s.advance_to(0.1, 1 / 240)
    np.testing.assert_allclose(s.v, np.array([[3.0, -1.0, 0.0]]) * (1 - np.exp(-rate * 0.1)) + 0 * s.v, atol=5e-3)


def test_damping_of_a_spring_is_that_of_its_closed_form() -> None:
    # y'' + beta omega^2 y' + omega^2 y = 0 with beta the fabric's damping [s]: the share of energy lost per second is
    # beta omega^2, at any step.
    vertices = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.05, 0.05, 0.0]])
    beta = 2e-4
    one = scene(garment(vertices, np.array([[0, 1, 2]], np.int32), replace(PLAIN, damping=beta)), pins=np.array([0, 1]))
    ends = []
    for steps in (200, 400):
        s = stepper(one, gravity=0.0, self_collision=False, **EXACT)
        omega = float(np.sqrt(s.springs.stiffness[1] / s.springs.mass[2]))
        slow, fast = 0.5 * beta * omega**2, omega * np.sqrt(1 - (0.5 * beta * omega) ** 2)
        time = 4 * np.pi / fast
        s.x[2, 1] += 1e-8
        s.advance_to(time, time / steps)
        ends.append(float(s.x[2, 1] - 0.05) / 1e-8)
    expected = np.exp(-slow * time)
    assert 0.1 < expected < 0.9
    assert ends == pytest.approx([expected, expected], rel=0.005)


def test_damping_of_a_swaying_strip_does_not_depend_on_the_step() -> None:
    # A held strip bent down a little and let go, without gravity: its bending damps it, not the size of the step.
    vertices, faces, step = strip(0.06, 0.02, 0.01)
    cloth = garment(vertices, faces, replace(PLAIN, bend_stiffness=2e-4, damping=8e-3))
    left = []
    for dt in (1 / 300, 1 / 600):
        s = stepper(
            scene(cloth, pins=np.flatnonzero(vertices[:, 0] < step)), gravity=0.0, self_collision=False, **EXACT
        )
        reach = np.maximum(vertices[:, 0], 0)
        s.x[:, 2] = np.where(s.fixed == 1, 0.0, -0.001 * (reach / 0.06) ** 2)
        tip = np.argmax(vertices[:, 0])
        seen = []
        while s.time < 0.2 - 1e-9:
            s.advance_to(s.time + 1 / 300, dt)
            seen.append(s.x[tip, 2])
        swing = np.abs(seen)
        left.append(swing[-30:].max() / swing[:30].max())
    assert 0.02 < left[0] < 0.75, "it must sway, and be damped"
    assert left[0] == pytest.approx(left[1], rel=0.01)
