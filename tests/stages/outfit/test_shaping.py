"""Widths follow the paper's equation, and nothing else moves."""

import numpy as np
import pytest

from stages.outfit.shaping import shape, width
from stages.outfit.template import load_template

EDGE = 0.014
STRAIGHT = {"sleeve_narrowing": 0.0, "sleeve_widening": 0.0, "sleeve_offset": 0.5}


def test_width_is_equation_1() -> None:
    x = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
    # W(x) / W_0 = 1 - 0.4 x + 0.8 max(0, x - 0.5), by hand.
    assert width(x, -0.4, 0.8, 0.5) == pytest.approx([1.0, 0.9, 0.8, 0.9, 1.0])


@pytest.mark.parametrize("gender", ["female", "male"])
def test_sleeves_are_scaled_around_the_arm_and_the_torso_stays(gender: str) -> None:
    template = load_template("tshirt", gender, EDGE)
    assert shape(template, STRAIGHT) == pytest.approx(template.vertices)
    narrow = shape(template, STRAIGHT | {"sleeve_narrowing": -0.3})
    along = template.axes.along_arm(template.vertices)
    # A long sleeve's last centimetre: x is near 1, so the share is near 1 - 0.3.
    end = along > 0.98
    centre = template.axes.arm_centre(template.vertices)
    before = np.linalg.norm(template.vertices - centre, axis=1)[end]
    after = np.linalg.norm(narrow - centre, axis=1)[end]
    assert after / before == pytest.approx(1.0 - 0.3 * along[end].clip(0, 1), abs=1e-6)
    torso = np.abs(template.vertices[:, 0]) < template.axes.shoulder[0]
    assert narrow[torso] == pytest.approx(template.vertices[torso], abs=1e-9)


def test_trouser_legs_flare_beyond_the_offset_only() -> None:
    template = load_template("trousers", "male", EDGE)
    flared = shape(template, {"leg_narrowing": 0.0, "leg_widening": 0.6, "leg_offset": 0.6})
    x = (template.axes.along_leg(template.vertices) - template.crotch_along_leg) / (1 - template.crotch_along_leg)
    moved = np.linalg.norm(flared - template.vertices, axis=1)
    assert moved[x < 0.6].max() < 1e-9
    assert moved[x > 0.9].min() > 0.005


def test_a_skirt_has_the_width_asked_for_at_the_hem() -> None:
    template = load_template("skirt", "female", EDGE)
    points = template.vertices
    waist = np.abs(points[points[:, 2] > template.top - 0.01, 0]).max()
    hem = points[:, 2] < template.bottom + 0.01
    for growth in (1.0, 1.5):
        shaped = shape(template, {"skirt_widening": growth})
        own = np.abs(points[hem, 0]).max() * (1 + growth) / (1 + template.flare)
        assert np.abs(shaped[hem, 0]).max() == pytest.approx(own, rel=0.01)
        assert np.abs(shaped[points[:, 2] > template.top - 0.01, 0]).max() == pytest.approx(waist, rel=0.02)
        assert shaped[:, 2] == pytest.approx(points[:, 2])
