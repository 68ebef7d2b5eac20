"""What an outfit is before any mesh is touched: every choice drawn from the random generator, as plain numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stages.outfit.config import Config

KINDS = ("tshirt+trousers", "top+trousers", "tshirt+skirt", "top+skirt", "jumpsuit", "dress")
"""Kinds of outfit; `random` stands for any of them."""

UPPER, LOWER = ("tshirt", "top"), ("trousers", "skirt")
"""Templates above and below the waist."""

DRAWS = (
    "kind", "upper", "tightness_1", "tightness_2",
    "sleeve_length", "leg_length", "torso_length", "waist_height", "skirt_length", "seam_height",
    "sleeve_narrowing", "sleeve_widening", "sleeve_offset", "leg_narrowing", "leg_widening", "leg_offset",
    "skirt_widening", "upper_fabric", "lower_fabric",
    "sleeve_elastic", "leg_elastic", "waist_elastic", "sleeve_ratio", "leg_ratio", "waist_ratio",
)  # fmt: skip
"""Every random number, in the order drawn. All are drawn always, so that changing one setting changes nothing else."""

PARAMETERS = {
    "tshirt": ("sleeve_length", "torso_length", "sleeve_narrowing", "sleeve_widening", "sleeve_offset"),
    "top": ("torso_length",),
    "trousers": ("waist_height", "leg_length", "leg_narrowing", "leg_widening", "leg_offset"),
    "skirt": ("waist_height", "skirt_length", "skirt_widening"),
}
"""Parameters that shape and cut each template."""

ELASTIC_ENDS = {"tshirt": "sleeve", "trousers": "leg"}
"""Templates whose ends may carry an elastic, and what it is called."""


@dataclass(frozen=True)
class Piece:
    """A template and its parameters."""

    template: str
    """Name of the template."""
    parameters: Mapping[str, float]
    """Values of `PARAMETERS[template]`; a sewn piece has `seam_height` in place of the border at the seam."""


@dataclass(frozen=True)
class GarmentPlan:
    """One garment: a piece, or two to be sewn at the waist."""

    name: str
    """Type of the garment, and its name in the outfit."""
    pieces: tuple[Piece, ...]
    """From top to bottom."""
    fabric: str
    """Name of its fabric."""
    elastics: Mapping[str, float]
    """Kind of end (`sleeve`, `leg`, `waist`) -> rest length as a share of the cloth's; those without are left out."""


@dataclass(frozen=True)
class OutfitPlan:
    """One outfit."""

    kind: str
    """One of `KINDS`."""
    tightness: tuple[float, float]
    """Offsets subtracted from the first two betas."""
    garments: tuple[GarmentPlan, ...]
    """From the inner one to the outer one."""


def draw_plan(kind: str, config: Config, rng: np.random.Generator) -> OutfitPlan:
    """Draws every choice of an outfit.

    Args:
        kind: One of `KINDS`, or `random`.
        config: Ranges to draw from.
        rng: Source of the random numbers.

    Returns:
        The plan.

    Raises:
        ValueError: There is no such kind.

    Source: CLOTH3D, Garment Generation, Elastics and Variability.
    """
    if kind not in (*KINDS, "random"):
        raise ValueError(f"outfit must be one of {', '.join(KINDS)} or random, got {kind!r}")
    u = dict(zip(DRAWS, rng.random(len(DRAWS)).tolist()))
    if kind == "random":
        kind = _pick(KINDS, u["kind"])
    values = _parameters(config, u)
    low, high = config.tightness_range
    tightness = (low + (high - low) * u["tightness_1"], low + (high - low) * u["tightness_2"])
    upper_fabric = _pick(config.upper_fabrics, u["upper_fabric"])
    lower_fabric = _pick(config.lower_fabrics, u["lower_fabric"])

    def elastics(*ends: str) -> dict[str, float]:
        share = {end: _between(config.elastic_ratio, u[f"{end}_ratio"]) for end in ends}
        return {end: share[end] for end in ends if u[f"{end}_elastic"] < config.elastic_chance}

    if kind in ("jumpsuit", "dress"):
        names = (_pick(UPPER, u["upper"]), "trousers" if kind == "jumpsuit" else "skirt")
        pieces = tuple(_sewn_piece(name, values) for name in names)
        ends = [ELASTIC_ENDS[name] for name in names if name in ELASTIC_ENDS]
        return OutfitPlan(kind, tightness, (GarmentPlan(kind, pieces, lower_fabric, elastics(*ends, "waist")),))
    above, below = kind.split("+")
    garments = tuple(
        GarmentPlan(name, (_piece(name, values),), fabric, elastics(*[e for t, e in ELASTIC_ENDS.items() if t == name]))
        for name, fabric in ((below, lower_fabric), (above, upper_fabric))
    )
    return OutfitPlan(kind, tightness, garments)


def _parameters(config: Config, u: Mapping[str, float]) -> dict[str, float]:
    """The shape parameters, each uniform in its range."""
    offset = config.widening_offset
    ranges = {
        name: offset if name.endswith("_offset") else getattr(config, name)
        for names in PARAMETERS.values()
        for name in (*names, "seam_height")
    }
    return {name: _between(limits, u[name]) for name, limits in ranges.items()}


def _piece(template: str, values: Mapping[str, float]) -> Piece:
    return Piece(template, {name: values[name] for name in PARAMETERS[template]})


def _sewn_piece(template: str, values: Mapping[str, float]) -> Piece:
    """A piece that ends at the waist seam instead of at its own hem or waist."""
    names = [name for name in PARAMETERS[template] if name not in ("torso_length", "waist_height")]
    return Piece(template, {name: values[name] for name in (*names, "seam_height")})


def _between(limits: tuple[float, float], u: float) -> float:
    return limits[0] + (limits[1] - limits[0]) * u


def _pick(choices: Sequence[str], u: float) -> str:
    return choices[min(int(u * len(choices)), len(choices) - 1)]
