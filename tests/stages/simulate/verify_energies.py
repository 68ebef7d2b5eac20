"""Gradient and Hessian of every energy against finite differences; bending against the cylinder."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import PLAIN, ball, garment, scene, sheet, stepper

from stages.simulate.specimens import strip
from stages.simulate.springs import Springs, bending_rows, face_areas
from stages.simulate.stepper import Stepper

H = 1 / 300
FABRIC = replace(PLAIN, bend_stiffness=1e-4, damping=2e-3, drag=0.1, stretch_limit=0.02)


def _stretched(seed: int = 0) -> Stepper:
    """A sheet with every spring in tension: there the matrix is the exact Hessian, without clamping."""
    vertices, faces = sheet(6, 5, 0.02)
    s = stepper(scene(garment(vertices, faces, FABRIC)), self_collision=False, precision="f64")
    rng = np.random.default_rng(seed)
    s.x[:] = vertices * 1.3 + rng.normal(scale=5e-4, size=vertices.shape)
    s.x_bar[:] = s.x + rng.normal(scale=1e-4, size=vertices.shape)
    s.y[:] = s.x + rng.normal(scale=1e-4, size=vertices.shape)
    s.inertia[:] = s.springs.mass / H**2
    return s


def _residual(s: Stepper, x: np.ndarray) -> np.ndarray:
    s._assemble(x, H)
    return s.residual.copy()


def _energy(s: Stepper, x: np.ndarray) -> float:
    """The incremental potential in plain NumPy, damping and drag included as their potentials."""
    p = s.springs
    i, j = p.edges.T
    d = x[i] - x[j]
    length = np.linalg.norm(d, axis=1)
    beyond = np.maximum(length - p.rest_length * (1 + p.limit), 0)
    stretch = 0.5 * p.stiffness * ((length - p.rest_length) ** 2 + (p.stiffening - 1) * beyond**2)
    u = (x - s.x_bar) / H
    bend = 0.0
    damped = 0.0
    for q, (a, b), beta in _bending(p):
        bend -= 0.5 * q * ((x[a] - x[b]) ** 2).sum()
        damped -= 0.5 * beta * H * q * ((u[a] - u[b]) ** 2).sum()
    inertia = 0.5 / H**2 * (p.mass[:, None] * (x - s.y) ** 2).sum()
    weight = -s.config.gravity * (p.mass * x[:, 2]).sum()
    air = 0.5 * H * (s.drag[:, None] * p.area[:, None] * u**2).sum()
    return float(stretch.sum() + bend + damped + inertia + weight + air)


def _bending(p: Springs) -> list[tuple[float, tuple[int, int], float]]:
    pairs = [(float(q), (int(a), int(b)), float(d)) for q, (a, b), d in zip(p.edge_bend, p.edges, p.damping)]
    for a in range(len(p.mass)):
        for e in range(p.bend_start[a], p.bend_start[a + 1]):
            if p.bend_neighbour[e] > a:
                pairs.append((float(p.bend[e]), (a, int(p.bend_neighbour[e])), float(p.bend_damping[a])))
    return pairs


def test_gradient_is_that_of_the_potential() -> None:
    s = _stretched()
    s.springs.damping[:] = 0.0  # a spring's damping acts along its present direction and has no potential
    x, f = s.x.copy(), _residual(s, s.x)
    assert np.abs(f).max() > 1e-2, "the gradient must not be near zero"
    step = 1e-7
    for vertex, axis in ((0, 0), (7, 2), (13, 1), (17, 0), (29, 2)):
        e = np.zeros_like(x)
        e[vertex, axis] = step
        slope = (_energy(s, x + e) - _energy(s, x - e)) / (2 * step)
        assert -f[vertex, axis] == pytest.approx(slope, rel=2e-4, abs=2e-5 * np.abs(f).max())


def _matrix(s: Stepper) -> np.ndarray:
    """The step's matrix, dense, from the blocks that the solver keeps; call after `_assemble`."""
    n = len(s.x)
    a = np.zeros((n, 3, n, 3))
    for i in range(n):
        xx, xy, xz, yy, yz, zz = s.pcg.diagonal[i]
        a[i, :, i, :] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    for (i, j), block in zip(s.springs.edges, s.block):
        k = block[0] * np.eye(3) + np.outer(block[1:], block[1:])
        a[i, :, j, :] -= k
        a[j, :, i, :] -= k
    scale = 1 + s.springs.bend_damping / H
    for i in range(n):
        for e in range(s.springs.bend_start[i], s.springs.bend_start[i + 1]):
            a[i, :, s.springs.bend_neighbour[e], :] += s.springs.bend[e] * scale[i] * np.eye(3)
    return a.reshape(3 * n, 3 * n)


def test_hessian_is_the_derivative_of_the_residual() -> None:
    s = _stretched()
    s.x_bar[:] = s.x  # at rest: damping then contributes its rate alone
    x = s.x.copy()
    _residual(s, x)
    matrix = _matrix(s)
    rng = np.random.default_rng(1)
    for _ in range(4):
        d = rng.normal(size=x.shape)
        slope = (_residual(s, x + 1e-7 * d) - _residual(s, x - 1e-7 * d)).ravel() / 2e-7
        np.testing.assert_allclose(-matrix @ d.ravel(), slope, rtol=0, atol=2e-4 * np.abs(slope).max())


def test_matrix_is_positive_definite_even_when_compressed() -> None:
    s = _stretched()
    s.x[:] *= 0.5
    _residual(s, s.x)
    matrix = _matrix(s)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-9 * np.abs(matrix).max())
    assert np.linalg.eigvalsh(matrix).min() > 0


def test_solve_meets_the_dense_solution() -> None:
    s = _stretched()
    object.__setattr__(s.config, "tolerance", 1e-9)
    s.bend_scale[:] = 1 + s.springs.bend_damping / H
    residual = _residual(s, s.x)
    s._solve()
    expected = np.linalg.solve(_matrix(s), residual.ravel())
    np.testing.assert_allclose(s.pcg.dx.ravel(), expected, atol=1e-7 * np.abs(expected).max())


def test_contact_force_is_the_gradient_of_its_penalty() -> None:
    # E = sum k A / 2 max(0, margin - d)^2 against a ball, without friction, damping and movement of the body.
    vertices, faces = sheet(5, 5, 0.02)
    cloth = garment(vertices, faces, replace(PLAIN, friction=0.0))
    s = stepper(
        scene(cloth, body=ball(0.3, 4)), self_collision=False, contact_damping=0.0, precision="f64", deepest_start=1.0
    )
    c = s.contact
    x = vertices - [0.043, 0.038, 0.0]
    x[:, 2] = np.sqrt(0.3**2 - x[:, 0] ** 2 - x[:, 1] ** 2) + np.linspace(-0.0008, 0.0008, len(x))
    c.body.move_to(0.0, 1.0)
    c.search(x, np.zeros_like(x), 1.0, x, 0.02)

    def energy(p: np.ndarray) -> float:
        c.locate(p)
        return float((0.5 * c.stiffness * c.area * np.maximum(0, c.margin - c.distance) ** 2).sum())

    c.evaluate(x, x, 1.0)
    force, block = c.force.copy(), c.block.copy()
    assert np.abs(force).max() > 1e-3
    for i in (0, 7, 12, 24):
        for axis in range(3):
            e = np.zeros_like(x)
            e[i, axis] = 1e-7
            slope = (energy(x + e) - energy(x - e)) / 2e-7
            assert -force[i, axis] == pytest.approx(slope, rel=1e-4, abs=1e-4 * np.abs(force).max())
        # The block is k n n^T: along the normal it's the derivative of the force.
        n = force[i] / np.linalg.norm(force[i])
        k = np.array(block[i][[0, 1, 2, 1, 3, 4, 2, 4, 5]]).reshape(3, 3)
        assert n @ k @ n == pytest.approx(c.stiffness * c.area[i], rel=1e-6)


@pytest.mark.parametrize("edge", [0.01, 0.02])
def test_bending_energy_of_a_cylinder(edge: float) -> None:
    # Rolled to radius R a sheet holds E = B A / (2 R^2), whatever its mesh; on average over the directions to roll it,
    # as one of right-angled triangles bends an eighth more easily along its legs.
    count, radius, rigidity = round(0.4 / edge) + 1, 0.2, 3e-5
    flat, faces = sheet(count, count, edge)
    pairs, q = bending_rows(flat, faces, np.full(len(flat), rigidity))

    def energy(at: np.ndarray) -> float:
        return float(-0.5 * (q * ((at[pairs[:, 0]] - at[pairs[:, 1]]) ** 2).sum(1)).sum())

    def rolled(turn: float) -> np.ndarray:
        along = flat[:, 0] * np.cos(turn) + flat[:, 1] * np.sin(turn)
        across = flat[:, 1] * np.cos(turn) - flat[:, 0] * np.sin(turn)
        return np.stack([radius * np.sin(along / radius), across, radius * (1 - np.cos(along / radius))], axis=1)

    assert abs(energy(flat)) < 1e-12
    exact = 0.5 * rigidity * face_areas(flat, faces).sum() / radius**2
    held = np.array([energy(rolled(turn)) for turn in np.arange(8) * np.pi / 8])
    # What its free borders would hold is missing: hinges are inside.
    assert held.mean() == pytest.approx(exact, rel=0.05)
    assert held.min() > 0.8 * exact and held.max() < 1.2 * exact


def test_bending_force_is_the_gradient_of_its_energy() -> None:
    # A rumpled sheet of no stretch, weight or inertia to speak of: what is left is bending, whose Hessian is constant.
    vertices, faces = sheet(6, 5, 0.02)
    limp = replace(PLAIN, density=1e-9, stretch_stiffness=1e-12, shear_stiffness=1e-12, bend_stiffness=1e-4)
    s = stepper(scene(garment(vertices, faces, limp)), self_collision=False, precision="f64", gravity=0.0)
    rng = np.random.default_rng(2)
    x = vertices + rng.normal(scale=3e-3, size=vertices.shape)
    s.y[:] = s.x_bar[:] = x
    pairs = _bending(s.springs)

    def energy(p: np.ndarray) -> float:
        return -sum(0.5 * q * float(((p[a] - p[b]) ** 2).sum()) for q, (a, b), _ in pairs)

    assert energy(x) > 1e-6
    force = _residual(s, x)
    assert np.abs(force).max() > 1e-4
    for vertex, axis in ((0, 2), (8, 0), (14, 1), (21, 2), (29, 0)):
        e = np.zeros_like(x)
        e[vertex, axis] = 1e-5
        slope = (energy(x + e) - energy(x - e)) / 2e-5
        assert -force[vertex, axis] == pytest.approx(slope, abs=1e-6 * np.abs(force).max())
    matrix, d = _matrix(s), rng.normal(size=x.shape)
    slope = (_residual(s, x + 1e-4 * d) - _residual(s, x - 1e-4 * d)).ravel() / 2e-4
    np.testing.assert_allclose(-matrix @ d.ravel(), slope, atol=1e-6 * np.abs(slope).max())


def test_bending_energy_of_waves_is_of_second_order() -> None:
    # z = a sin(k x) holds B k^4 a^2 / 4 per area, and on a mesh with columns h apart, as every second difference does,
    # (2 (1 - cos k h) / (k h)^2)^2 of it: 1 - (k h)^2 / 6.
    k, rigidity, errors = 2 * np.pi / 0.12, 2e-5, []
    for edge in (0.02, 0.01, 0.005):
        x, faces, step = strip(0.36, 0.2, edge, clamp=0)
        area = face_areas(x, faces).sum()
        x[:, 2] = 1e-5 * np.sin(k * x[:, 0])
        flat = x * np.array([1.0, 1.0, 0.0])
        rows, q = bending_rows(flat, faces, np.full(len(x), rigidity))
        energy = -0.5 * float((q * ((x[rows[:, 0]] - x[rows[:, 1]]) ** 2).sum(1)).sum())
        exact = rigidity * k**4 * 1e-10 / 4 * area
        errors.append(1 - energy / exact)
        assert energy == pytest.approx(exact * (2 * (1 - np.cos(k * step)) / (k * step) ** 2) ** 2, rel=0.03)
    assert 3.5 < errors[0] / errors[1] < 4.5
    assert 3.5 < errors[1] / errors[2] < 4.5
