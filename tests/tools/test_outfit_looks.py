"""The strips vary one parameter at a time, and forget none."""

import numpy as np
import pytest

from stages.outfit.config import Config
from stages.outfit.plan import CUTS, PARAMETERS, OutfitPlan
from tools.outfit.looks import page
from tools.outfit.looks_strips import STRIPS, Row, plan_of

CONFIG = Config()


def numbers(plan: OutfitPlan) -> dict[str, float]:
    found = {f"tightness_{number}": value for number, value in enumerate(plan.tightness)}
    for piece in plan.garments[0].pieces:
        found |= dict(piece.parameters)
    return found


@pytest.mark.parametrize(("name", "row"), [(name, row) for name, rows in STRIPS.items() for row in rows])
def test_a_row_goes_through_the_range_of_one_parameter(name: str, row: Row) -> None:
    low, middle, high = (numbers(plan_of(name, row, share, CONFIG)) for share in (0.0, 0.5, 1.0))
    varied = {key for key in low if not low[key] == middle[key] == high[key]}
    assert varied == ({"tightness_0", "tightness_1"} if row.parameter == "tightness" else {row.parameter})
    names = {"tightness": "tightness_range", "sleeve_offset": "widening_offset", "leg_offset": "widening_offset"}
    limits = getattr(CONFIG, names.get(row.parameter, row.parameter))
    assert [(low[key], high[key]) for key in varied] == [pytest.approx(limits)] * len(varied)
    assert all(np.isfinite(list(low.values())))


def test_every_parameter_of_every_template_and_cut_has_its_row() -> None:
    shown = {(name, row.parameter) for name, rows in STRIPS.items() for row in rows}
    assert {(name, parameter) for name, parameters in PARAMETERS.items() for parameter in parameters} <= shown
    assert {parameter for parameters in CUTS.values() for parameter in parameters} <= {p for _, p in shown}
    used = {cut for rows in STRIPS.values() for row in rows for cut in row.cuts}
    assert used == set(CUTS)


def test_the_page_shows_the_pictures_that_there_are() -> None:
    every = [*STRIPS, "drawn"]
    for there in (every, ["top", "skirt"], ["drawn"]):
        text = page(there, 100, 0.014)
        assert {name for name in every if f"({name}.jpg)" in text} == set(there)
