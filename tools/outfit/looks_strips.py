"""Strips of pictures that vary one parameter of a garment at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.body import load_free_body
from stages.fabrics import load_fabrics
from stages.outfit.config import Config
from stages.outfit.kinds import UPPER
from stages.outfit.making import make_outfit
from stages.outfit.plan import CUTS, PARAMETERS, GarmentPlan, OutfitPlan, Piece
from stages.report.sheet import Picture, contact_sheet
from tools.outfit.looks_picture import BACK, FRONT, SIDE, labelled, outfit_picture

NECK, NECK_SPAN = 0.44, 0.62
"""Height in the middle of pictures around the neck, and what their height covers [m]."""

STEPS = 5
CELL = 120
"""Width of a picture [px]."""


@dataclass(frozen=True)
class Row:
    """What one row varies."""

    parameter: str
    """Name of the parameter, or `tightness`."""
    cuts: tuple[str, ...] = ()
    """Cuts of the upper piece in this row; those of the strip if left out."""
    azimuth: float = FRONT
    """Direction to the camera [rad]."""

    @property
    def close(self) -> bool:
        """Whether it is seen from near, around the neck."""
        return self.parameter.startswith(("neck", "collar", "placket"))

    @property
    def label(self) -> str:
        """What is written above the row."""
        seen = {BACK: ["back"], SIDE: ["side"]}.get(self.azimuth, [])
        return ", ".join([self.parameter.replace("_", " "), *(cut.replace("_", " ") for cut in self.cuts), *seen])


@dataclass(frozen=True)
class Wear:
    """How a type of garment is shown."""

    gender: str
    templates: tuple[str, ...]
    fabric: str
    middle: float
    """Height in the middle of its pictures [m]."""
    span: float
    """What their height covers [m]."""
    height: int
    """Of its pictures [px]."""


WEARS = {
    "tshirt": Wear("male", ("tshirt",), "cotton", 0.20, 1.32, 104),
    "top": Wear("female", ("top",), "silk", 0.24, 1.05, 104),
    "trousers": Wear("male", ("trousers",), "denim", -0.36, 1.35, 150),
    "skirt": Wear("female", ("skirt",), "cotton", -0.36, 1.35, 150),
    "jumpsuit": Wear("male", ("tshirt", "trousers"), "denim", -0.08, 1.72, 170),
    "dress": Wear("female", ("top", "skirt"), "silk", -0.08, 1.72, 170),
}

STRIPS: dict[str, tuple[Row, ...]] = {
    "tshirt": (
        Row("sleeve_length"),
        Row("sleeve_narrowing"),
        Row("sleeve_widening"),
        Row("sleeve_offset"),
        Row("torso_length"),
        Row("neck_depth", ("round_neck",)),
        Row("neck_width", ("round_neck",)),
        Row("neck_depth", ("v_neck",)),
        Row("neck_width", ("boat_neck",)),
        Row("neck_depth", ("round_neck",), BACK),
        Row("collar_height", ("collar",)),
        Row("collar_height", ("collar",), SIDE),
        Row("collar_height", ("collar", "front_opening")),
        Row("placket_length", ("collar", "placket")),
        Row("armhole_depth", ("round_neck", "armholes")),
        Row("armhole_depth", ("round_neck", "armholes"), SIDE),
        Row("opening_width", ("v_neck", "front_opening")),
        Row("opening_width", ("round_neck", "armholes", "front_opening")),
        Row("fastening_height", ("round_neck", "front_opening")),
        Row("tightness"),
    ),
    "top": (
        Row("torso_length"),
        Row("neck_depth", ("round_neck",)),
        Row("neck_depth", ("v_neck",)),
        Row("neck_depth", ("boat_neck",)),
        Row("chest_height", ("strapless",)),
        Row("tightness"),
    ),
    "trousers": (
        Row("waist_height"),
        Row("leg_length"),
        Row("leg_narrowing"),
        Row("leg_widening"),
        Row("leg_offset"),
        Row("tightness"),
    ),
    "skirt": (Row("waist_height"), Row("skirt_length"), Row("skirt_widening"), Row("tightness")),
    "jumpsuit": (
        Row("sleeve_length"),
        Row("leg_length"),
        Row("seam_height"),
        Row("neck_depth", ("v_neck", "armholes")),
        Row("tightness"),
    ),
    "dress": (
        Row("skirt_length"),
        Row("skirt_widening"),
        Row("seam_height"),
        Row("neck_depth", ("v_neck",)),
        Row("chest_height", ("strapless",)),
        Row("tightness"),
    ),
}
"""What is varied, by type of garment."""


def strip(name: str, edge: float) -> Picture:
    """All rows of one type of garment, each with its label.

    Args:
        name: Type of the garment.
        edge: Edge length [m].
    """
    rows = [labelled(_row(name, row, edge), row.label) for row in STRIPS[name]]
    return contact_sheet(rows, columns=2 if len(rows) > 4 else 1, gap=6)


def _row(name: str, row: Row, edge: float) -> Picture:
    wear, config = WEARS[name], Config(edge_length=edge)
    betas = np.zeros(10)
    pictures: list[Picture] = []
    for share in np.linspace(0.0, 1.0, STEPS):
        plan = plan_of(name, row, float(share), config)
        made = make_outfit(plan, load_free_body(wear.gender), betas, config, load_fabrics(), lambda label: None)
        picture = outfit_picture(
            made, wear.gender, betas, who=name, size=(CELL, wear.height),
            middle=NECK if row.close else wear.middle, span=NECK_SPAN if row.close else wear.span,
            azimuth=row.azimuth, tightness=None if row.parameter == "tightness" else plan.tightness,
        )  # fmt: skip
        pictures.append(picture)
    return contact_sheet(pictures, STEPS, gap=2)


def plan_of(name: str, row: Row, share: float, config: Config) -> OutfitPlan:
    """An outfit of one garment with one parameter at a share of its range and all others in the middle.

    Args:
        name: Type of the garment.
        row: What is varied.
        share: 0 for the lowest value, 1 for the highest.
        config: The ranges.
    """
    wear = WEARS[name]
    pieces = []
    for template in wear.templates:
        cuts = (row.cuts or ("round_neck",)) if template in UPPER else ()
        own = [p for p in PARAMETERS[template] if not (p.startswith("sleeve") and "armholes" in cuts)]
        if len(wear.templates) == 2:
            own = [p for p in own if p not in ("torso_length", "waist_height")] + ["seam_height"]
        names = [*own, *(parameter for cut in cuts for parameter in CUTS[cut])]
        shares = {p: share if p == row.parameter else _middle(p, row.parameter) for p in names}
        pieces.append(Piece(template, {p: _value(p, s, config) for p, s in shares.items()}, cuts))
    low, high = config.tightness_range
    tightness = low + share * (high - low) if row.parameter == "tightness" else 0.0
    garment = GarmentPlan(name, name, tuple(pieces), wear.fabric, {})
    return OutfitPlan(name, (tightness, tightness), (garment,))


def _middle(parameter: str, varied: str) -> float:
    """Share at which a parameter stays: the middle, but what widens towards the end of a limb is shown whole."""
    limb = varied.split("_")[0]
    return 1.0 if limb in ("sleeve", "leg") and parameter == f"{limb}_length" else 0.5


def _value(parameter: str, share: float, config: Config) -> float:
    low, high = config.widening_offset if parameter.endswith("_offset") else getattr(config, parameter)
    return float(low + share * (high - low))
