"""Colours of garments."""

from stages.report.palette import FABRICS, OTHER, fabric_colour


def test_layers_of_one_fabric_differ_and_keep_to_the_fabric():
    for fabric, shades in FABRICS.items():
        inner, outer = fabric_colour(fabric, "s0", 0), fabric_colour(fabric, "s0", 1)
        assert inner != outer
        assert {inner, outer} <= set(shades)


def test_people_in_one_fabric_are_told_apart_and_unknown_fabrics_are_neutral():
    assert len({fabric_colour("cotton", f"static_{n}") for n in range(20)}) == len(FABRICS["cotton"])
    assert fabric_colour("chain mail", "s0") in OTHER
