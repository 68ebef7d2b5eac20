"""Contact with the body: friction by Coulomb's law, no penetration, no tunnelling."""

from dataclasses import replace

import igl
import numpy as np
import pytest
from small_scenes import PLAIN, ball, garment, scene, sheet, stepper

from stages.simulate.config import SimulateConfig
from stages.simulate.contact_forces import SKIN_YIELD
from stages.simulate.solve import solve

SLOPE = np.array([[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [5.0, 5.0, 0.0], [-5.0, 5.0, 0.0]])
SLOPE_FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def _slide(
    angle: float,
    friction: float,
    newton_iterations: int = 2,
    density: float = PLAIN.density,
    contact_stiffness: float = SimulateConfig().contact_stiffness,
) -> tuple[float, float]:
    """Travel down a slope in 0.1 s and in the next 0.4 s [m] of a patch laid on it at the resting distance."""
    vertices, faces = sheet(4, 4, 0.02)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    # Where the penalty carries the weight: k A gap = m g cos(angle).
    gap = density * 9.81 * np.cos(angle) / contact_stiffness
    start = (vertices + np.array([0, 0, 0.002 - gap])) @ turn.T
    cloth = garment(vertices, faces, replace(PLAIN, friction=friction, density=density))
    s = stepper(
        scene(cloth, start=start, body=(SLOPE @ turn.T, SLOPE_FACES)),
        self_collision=False,
        contact_stiffness=contact_stiffness,
        tolerance=1e-4,
        newton_iterations=newton_iterations,
        newton_tolerance=1e-9,
    )
    down = turn[:, 0]
    x0 = (s.x @ down).mean()
    s.advance_to(0.1, 1 / 240)
    x1 = (s.x @ down).mean()
    s.advance_to(0.5, 1 / 240)
    return float(x1 - x0), float((s.x @ down).mean() - x1)


@pytest.mark.parametrize(("degrees", "friction"), [(20, 0.5), (10, 0.2), (40, 0.9)])
def test_sticks_below_the_friction_angle(degrees: float, friction: float) -> None:
    # tan 20 degrees = 0.364 < 0.5. The grip gives elastically, by m g sin / (k_t A) ~ 1e-6 m, and then nothing moves.
    assert 0.7 * friction < np.tan(np.radians(degrees)) < friction
    _, crept = _slide(np.radians(degrees), friction)
    assert abs(crept) < 1e-5


@pytest.mark.parametrize(("degrees", "friction"), [(35, 0.0), (35, 0.3), (12, 0.1), (50, 0.9)])
def test_slides_above_it_as_coulomb_says(degrees: float, friction: float) -> None:
    angle = np.radians(degrees)
    acceleration = 9.81 * (np.sin(angle) - friction * np.cos(angle))
    # With the usual two iterations cloth starts to slide a step or so late; here the onset is to be exact too.
    first, rest = _slide(angle, friction, 12)
    assert first + rest == pytest.approx(0.5 * acceleration * 0.5**2, rel=0.02)


def test_skin_yields_to_what_pulls_too_hard() -> None:
    # Two tonnes a square metre on 20 degrees: friction of 0.9 would hold them, but skin bears no more than its yield.
    angle, density = np.radians(20), 2000.0
    acceleration = 9.81 * np.sin(angle) - SKIN_YIELD / density
    first, rest = _slide(angle, 0.9, 12, density, 1e8)
    assert first + rest == pytest.approx(0.5 * acceleration * 0.5**2, rel=0.02)


def test_sheet_on_a_ball_stays_out() -> None:
    vertices, faces = sheet(24, 24, 0.02)
    body, body_faces = ball(0.15, 3)
    start = vertices + np.array([-0.23, -0.23, 0.16])
    one = scene(garment(vertices, faces, replace(PLAIN, friction=0.4)), start=start, body=(body, body_faces), frames=15)
    x = solve(one, SimulateConfig(threads=1, dt=1 / 120)).x
    assert x[-1, :, 2].min() < -0.02, "the sheet must have draped"
    assert x[-1, :, 2].max() > 0.14, "and not have slid off"
    for frame in x:
        distance = igl.signed_distance(frame, body, body_faces.astype(np.int64))[0]
        assert distance.min() > 0.9e-3


def test_fast_limb_does_not_tunnel() -> None:
    # A ball of 4 cm radius flies at 10 m/s into a hanging sheet: 33 cm a frame. The sheet must be carried along.
    vertices, faces = sheet(15, 15, 0.02)
    start = vertices[:, [0, 2, 1]] - [0.14, 0.0, 0.14]
    body, body_faces = ball(0.04, 2)
    one = scene(
        garment(vertices, faces), start=start, body=(body, body_faces), frames=3,
        motion=lambda k: np.array([0.0, -0.4 + k / 3, 0.0]),
    )  # fmt: skip
    solution = solve(one, SimulateConfig(threads=1))
    for k, frame in enumerate(solution.x):
        place = body + np.array([0.0, -0.4 + k / 3, 0.0])
        assert igl.signed_distance(frame, place, body_faces.astype(np.int64))[0].min() > 0.9e-3
    middle = solution.x[3][np.argmin(np.linalg.norm(start, axis=1))]
    assert middle[1] > 0.6, "the middle of the sheet must be in front of the ball at y = 0.6"
    assert solution.report.steps > 60, "so fast a limb needs short steps"


def test_cloth_between_overlapping_bodies_is_laid_on_the_skin() -> None:
    # Two balls that come to overlap with a strip between them: nowhere deeper than 1 mm, and nothing flies off.
    one_ball, f = ball(0.1, 3)
    faces2 = np.concatenate([f, f + len(one_ball)])
    vertices, faces = sheet(12, 12, 0.02)
    start = vertices[:, [2, 0, 1]] - [0.0, 0.11, 0.11]

    def at(k: int) -> np.ndarray:
        half = 0.105 - 0.002 * min(k, 12)
        return np.concatenate([one_ball + np.array([half, 0, 0]), one_ball - np.array([half, 0, 0])])

    one = scene(garment(vertices, faces), start=start, body=(at(0), faces2), frames=16)
    one = replace(one, body=at, body_frames=17)
    x = solve(one, SimulateConfig(threads=1)).x
    for k, frame in enumerate(x):
        assert igl.signed_distance(frame, at(k), faces2.astype(np.int64))[0].min() > -1e-3
    # Free fall would reach 0.16 m a frame.
    assert np.linalg.norm(np.diff(x, axis=0), axis=2).max() < 0.08
