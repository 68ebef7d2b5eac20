"""Virtual experiments: the fabrics show the stiffness, drape and stretch of their constants and of published cloth."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import QUASI_STATIC, garment, scene, settle, stepper

from stages.fabrics import load_fabrics
from stages.simulate.fabric import named_fabric
from stages.simulate.fabrics_program import KAWABATA_LOAD
from stages.simulate.specimens import disc, strip
from stages.simulate.springs import bending_rows, hinges, unique_edges
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
    assert measured[:2] / theoretical_bending_length(fabric) == pytest.approx(1.0, abs=0.015)
    assert measured / theoretical_bending_length(fabric) == pytest.approx(1.0, abs=0.03)


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


@pytest.mark.parametrize("name", ["cotton", "leather"])
def test_drape_does_not_depend_on_the_mesh(name: str) -> None:
    # Edges of 20 mm are longer than the bending length, and a fold has seven of them. Starts that keep their folds:
    # with another number of folds the coefficient differs by more than it does from mesh to mesh.
    fabric = named_fabric(name)
    coarse, fine = (drape_coefficient(fabric, edge, folds=(6, 7), threads=1).mean() for edge in (0.02, 0.01))
    assert coarse == pytest.approx(fine, rel=0.03)


def test_coarse_hinges_are_stiffer_and_uneven_ones_are_not() -> None:
    # Rolled to a large radius a sheet holds B A / (2 R^2), in all directions, also where rings of unlike counts of
    # vertices meet: a tenth more without what evens hinges out. With a bending length of twice the hinges' distance
    # s = 1/4, and they are stiffer by 0.78 s / (1 + 0.2 s).
    flat, faces, _ = disc(0.15, 0.09, 0.005)
    inside = np.hypot(*flat[hinges(faces)].mean(1)[:, :2].T) < 0.13
    whole = 0.5 * np.pi * 0.13**2
    for turn in (0.0, 0.5, 1.0, 1.5):
        z = 0.5 * (flat @ [np.cos(turn), np.sin(turn), 0.0]) ** 2
        rows, q = bending_rows(flat, faces, np.ones(len(flat)), share=inside.astype(float))
        assert -0.5 * (q * (z[rows[:, 0]] - z[rows[:, 1]]) ** 2).sum() == pytest.approx(whole, rel=0.03)
    x, even, step = strip(0.2, 0.2, 0.01, clamp=0)
    each = np.ones(len(x))
    (_, q), (_, stiffer) = (bending_rows(x, even, each, length) for length in (None, 2 * step * each))
    assert np.median(stiffer / q) == pytest.approx(1 + 0.78 * 0.25 / 1.05, rel=0.01)


@pytest.mark.parametrize("name", ["cotton", "leather"])
def test_extension_is_that_of_the_constants(name: str) -> None:
    # Tension k e, and s times as stiff beyond the limit.
    fabric = named_fabric(name)
    k, limit, s = fabric.sheet_stiffness, fabric.stretch_limit, fabric.stiffening
    assert extension(fabric, 0.5 * limit * k, threads=1) == pytest.approx(0.5 * limit, rel=0.01)
    assert extension(fabric, 3 * limit * k, threads=1) == pytest.approx(limit + 2 * limit / s, rel=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_extension_is_that_of_published_cloth(name: str) -> None:
    published = load_fabrics()[name].published.extension
    if published is None:
        pytest.skip("none is published")
    fabric = named_fabric(name)
    assert published[0] < extension(fabric, KAWABATA_LOAD, threads=1) < published[1]
    # It is the crimp's end that holds it: without, it would stretch by a third.
    assert extension(replace(fabric, stretch_limit=1.0), KAWABATA_LOAD, threads=1) > 3 * published[1]


def test_elastics_do_not_stiffen() -> None:
    # Denim gathered on an elastic of half its length: put on, the elastic is as far beyond its rest as the cloth is
    # long, and pulls with k e; stiffened it would pull almost twenty times as hard.
    vertices, faces, _ = strip(0.1, 0.04, 0.01, clamp=0)
    denim = named_fabric("denim")
    edges = unique_edges(faces)[0]
    elastic = (vertices[edges, 0] < 1e-9).all(1)
    cloth = replace(garment(vertices, faces, denim), rest_scale=np.where(elastic, 0.5, 1.0))
    s = stepper(scene(cloth, start=vertices), self_collision=False, precision="f64", gravity=0.0)
    s.x_bar[:] = s.x
    s._assemble(s.x, 1 / 100)
    pull = np.linalg.norm(s.pull, axis=1)
    p = s.springs
    np.testing.assert_allclose(pull[elastic], (p.stiffness * 0.5 * p.length)[elastic], rtol=0.02)
    assert (p.stiffening[~elastic] == denim.stiffening).all()


def test_an_elastic_pulls_as_its_shard_says() -> None:
    # All of a strip is an elastic of 0.9 of its length, held at the cloth's: Y width (1 - 0.9), free to get narrower;
    # and some more as its slanted springs turn.
    length, width, ratio = 0.3, 0.1, 0.9
    vertices, faces, _ = strip(length, width, 0.01, clamp=0)
    ends = np.flatnonzero((vertices[:, 0] < 1e-9) | (vertices[:, 0] > length - 1e-9))
    fabric = replace(named_fabric("cotton"), drag=2.0)
    cloth = replace(garment(vertices, faces, fabric), rest_scale=np.full(len(unique_edges(faces)[0]), ratio))
    s = stepper(scene(cloth, pins=ends), **QUASI_STATIC, gravity=0.0)
    settle(s, 1e-3)
    middle = 0.5 * length + 1e-4
    d = s.x[s.springs.edges[:, 1]] - s.x[s.springs.edges[:, 0]]
    across = (s.x[s.springs.edges, 0] < middle).sum(1) == 1
    pull = s.springs.stiffness * (np.linalg.norm(d, axis=1) - s.springs.rest_length)
    force = (pull * np.abs(d[:, 0]) / np.linalg.norm(d, axis=1))[across].sum()
    assert force == pytest.approx(fabric.sheet_stiffness * width * (1 - ratio), rel=0.15)
