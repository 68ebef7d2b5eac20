"""The sheet of outfits that a recipe draws."""

from __future__ import annotations

import itertools

import numpy as np

from model.body import GENDERS, load_free_body
from stages.body.config import Config as BodyConfig
from stages.body.sampling import draw_betas
from stages.fabrics import load_fabrics
from stages.outfit.config import Config
from stages.outfit.kinds import KINDS
from stages.outfit.making import make_outfit
from stages.outfit.plan import draw_plan
from stages.outfit.resizing import tight_betas
from stages.outfit.template import rest_body
from stages.report.sheet import Picture, contact_sheet
from stages.spec import DataError, seed_of
from tools.outfit.looks_picture import outfit_picture

SEED = 2020
COLUMNS = 12
"""A row has each kind of outfit for both genders."""
SIZE = 104, 132
ROOM = 1.05
"""Height of a picture by that of the person in it."""


def drawn_sheet(count: int, edge: float) -> Picture:
    """People at rest as the defaults of a recipe draw them: kinds in turn, genders in turn, seeds by their names.

    One whose outfit is rejected is said and passed over, the next person drawn in turn.

    Args:
        count: How many.
        edge: Edge length of the garments [m].
    """
    config, body, fabrics = Config(edge_length=edge), BodyConfig(), load_fabrics()
    pictures: list[Picture] = []
    for index in itertools.count():
        if len(pictures) == count:
            break
        name, gender = f"static_{index:05d}", GENDERS[index // len(KINDS) % len(GENDERS)]
        drawn = draw_betas(body.shape_range, body.betas, np.random.default_rng(seed_of(SEED, "body", name)))
        betas = drawn.astype(np.float64)  # as the stage reads them
        plan = draw_plan(KINDS[index % len(KINDS)], config, np.random.default_rng(seed_of(SEED, "outfit", name)))
        try:
            made = make_outfit(plan, load_free_body(gender), betas, config, fabrics, lambda label: None)
        except DataError as error:
            print(f"{name}: {error}", flush=True)
            continue
        height = rest_body(load_free_body(gender), tight_betas(betas, plan.tightness))[:, 2]
        middle, span = float(height.min() + height.max()) / 2, ROOM * float(np.ptp(height))
        pictures.append(
            outfit_picture(made, gender, betas, who=name, middle=middle, span=span, size=SIZE, tightness=plan.tightness)
        )
    return contact_sheet(pictures, COLUMNS, gap=2)
