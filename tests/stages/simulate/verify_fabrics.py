"""Virtual experiments: the fabrics show the stiffness, drape and stretch of their constants and of published cloth."""

from dataclasses import replace

import numpy as np
import pytest

from stages.fabrics import load_fabrics
from stages.simulate.fabric import Fabric, named_fabric
from stages.simulate.fabrics_program import KAWABATA_LOAD
from stages.simulate.virtual_tests import (
    bending_length,
    drape_coefficient,
    elastica_angle,
    extension,
    shadow,
    theoretical_bending_length,
)

NAMES = ("cotton", "silk", "denim", "leather")


def test_cantilever_of_the_standards() -> None:
    # A strip twice its bending length droops by the 41.5 degrees of the standard tester; short ones as plates do:
    # tan = w L^3 / (8 B).
    assert np.degrees(elastica_angle(2.0, 1.0)) == pytest.approx(41.5, abs=0.1)
    assert np.tan(elastica_angle(0.3, 1.0)) == pytest.approx(0.3**3 / 8, rel=1e-3)


def test_shadow_counts_what_overlaps_once() -> None:
    x = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0], [0, 0, 0.02], [0.2, 0, 0.02], [0, 0.2, 0.02]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]])
    assert shadow(x, faces[:2]) == pytest.approx(0.01, rel=0.01)
    # The third triangle, half of 0.2 x 0.2 m, covers the square.
    assert shadow(x, faces) == pytest.approx(0.02, rel=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_bending_length_is_that_of_theory_on_every_mesh(name: str) -> None:
    # c = (B / w)^(1/3), at edges of 5, 10 and 20 mm: the last are longer than c itself.
    fabric = named_fabric(name)
    measured = np.array([bending_length(fabric, edge, threads=1) for edge in (0.005, 0.01, 0.02)])
    assert measured / theoretical_bending_length(fabric) == pytest.approx(1.0, abs=0.03)
    assert np.ptp(measured) < 0.03 * measured.mean()


@pytest.mark.parametrize("name", NAMES)
def test_bending_length_is_that_of_published_cloth(name: str) -> None:
    published = load_fabrics()[name].published.bending_length
    if published is None:
        pytest.skip("none is published")
    assert published[0] < theoretical_bending_length(named_fabric(name)) < published[1]


@pytest.mark.parametrize("name", NAMES)
def test_drape_coefficient_is_that_of_published_cloth(name: str) -> None:
    published = load_fabrics()[name].published.drape_coefficient
    assert published is not None
    (measured,) = drape_coefficient(named_fabric(name), 0.018, folds=[6], threads=1)
    assert published[0] < measured < published[1]


def test_drape_does_not_depend_on_the_mesh() -> None:
    # Of a cloth that is stiff enough for 20 mm edges to show its folds; mean of two drapes.
    stiff = Fabric(density=0.55, stretch_stiffness=1500.0, shear_stiffness=400.0, bend_stiffness=1e-4)
    coarse, fine = (drape_coefficient(stiff, edge, folds=(5, 6), threads=1).mean() for edge in (0.02, 0.014))
    assert 0.6 < fine < 0.95
    assert coarse == pytest.approx(fine, rel=0.03)


@pytest.mark.parametrize("name", ["cotton", "leather"])
def test_extension_is_that_of_the_constants(name: str) -> None:
    # Tension k e, and s times as stiff beyond the limit.
    fabric = named_fabric(name)
    k, limit, s = fabric.sheet_stiffness, fabric.stretch_limit, fabric.stiffening
    assert extension(fabric, 0.5 * limit * k, threads=1) == pytest.approx(0.5 * limit, rel=0.01)
    assert extension(fabric, 3 * limit * k, threads=1) == pytest.approx(limit + 2 * limit / s, rel=0.01)


def test_extension_is_that_of_published_denim_once_its_crimp_is_short() -> None:
    # The table's denim takes the simulation's own limit, which is kinder to long steps, and stretches four times as far
    # at 500 gf/cm as denim does. With a crimp of 1.5 % and 20 times the stiffness beyond, it is denim.
    published = load_fabrics()["denim"].published.extension
    assert published is not None
    denim = named_fabric("denim")
    assert extension(denim, KAWABATA_LOAD, threads=1) > 3 * published[1]
    assert (
        published[0]
        < extension(replace(denim, stretch_limit=0.015, stiffening=20.0), KAWABATA_LOAD, threads=1)
        < published[1]
    )
