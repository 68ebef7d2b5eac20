"""What an outfit is before any mesh is touched: every choice drawn from the random generator, as plain numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.outfit.config import Config
from stages.outfit.kinds import KINDS, MOST_OWN, UPPER, worn
from stages.outfit.own.settings import OwnGarment

DRAWS = (
    "kind", "upper", "tightness_1", "tightness_2",
    "sleeve_length", "leg_length", "torso_length", "waist_height", "skirt_length", "seam_height",
    "sleeve_narrowing", "sleeve_widening", "sleeve_offset", "leg_narrowing", "leg_widening", "leg_offset",
    "skirt_widening", "upper_fabric", "lower_fabric",
    "sleeve_elastic", "leg_elastic", "waist_elastic", "sleeve_ratio", "leg_ratio", "waist_ratio",
    *(f"own_fabric_{number}" for number in range(MOST_OWN)),
    "neckline", "neck_depth", "neck_width", "vest", "armhole_depth", "strapless", "chest_height",
    "open_front", "opening_width", "collar", "collar_height",
    "placket", "placket_length",
    "fastening_height",
)  # fmt: skip
"""Every random number, in the order drawn. All are drawn always, so that changing one setting changes nothing else; new
ones go to the end, so that outfits stay as they were."""

PARAMETERS = {
    "tshirt": ("sleeve_length", "torso_length", "sleeve_narrowing", "sleeve_widening", "sleeve_offset"),
    "top": ("torso_length",),
    "trousers": ("waist_height", "leg_length", "leg_narrowing", "leg_widening", "leg_offset"),
    "skirt": ("waist_height", "skirt_length", "skirt_widening"),
}
"""Parameters that shape and cut each template."""

OPEN_NECK = 0.1
"""Depth and width of the neckline of an open front, as a share of others', and it is no boat neck: nothing else keeps
it on the shoulders."""

CUTS = {
    "round_neck": ("neck_depth", "neck_width"),
    "v_neck": ("neck_depth", "neck_width"),
    "boat_neck": ("neck_depth", "neck_width"),
    "collar": ("collar_height",),
    "armholes": ("armhole_depth",),
    "strapless": ("chest_height",),
    "front_opening": ("opening_width", "fastening_height"),
    "placket": ("placket_length",),
}
"""Cuts of upper garments, and their parameters. Armholes make a vest of a t-shirt, and take the sleeves' parameters; a
collar stands on the smallest neckline, and with a placket, a short slit in front, makes a polo shirt."""

ELASTIC_ENDS = {"tshirt": "sleeve", "trousers": "leg"}
"""Templates whose ends may carry an elastic, and what it is called."""


@dataclass(frozen=True)
class Piece:
    """A template and its parameters."""

    template: str
    """Name of the template."""
    parameters: Mapping[str, float]
    """Values of `PARAMETERS[template]` and of its cuts; a sewn piece has `seam_height` in place of the border at the
    seam, and a vest has no sleeves."""
    cuts: tuple[str, ...] = ()
    """Names of `CUTS`."""


@dataclass(frozen=True)
class GarmentPlan:
    """One garment: a piece, or two to be sewn at the waist; or one of one's own."""

    name: str
    """Its name in the outfit: its type, or what the recipe calls it."""
    type: str
    """One of `kinds.TYPES`."""
    pieces: tuple[Piece, ...]
    """From top to bottom; none if it is one's own."""
    fabric: str
    """Name of its fabric."""
    elastics: Mapping[str, float]
    """Kind of end (`sleeve`, `leg`, `waist`) -> rest length as a share of the cloth's; those without are left out."""


@dataclass(frozen=True)
class OutfitPlan:
    """One outfit."""

    kind: str
    """One of `KINDS`, or names joined by `+`, the outer garment first."""
    tightness: tuple[float, float]
    """Offsets subtracted from the first two betas."""
    garments: tuple[GarmentPlan, ...]
    """From the inner one to the outer one."""


NO_OWN: Mapping[str, OwnGarment] = {}


def draw_plan(
    kind: str, config: Config, rng: np.random.Generator, own: Mapping[str, OwnGarment] = NO_OWN
) -> OutfitPlan:
    """Draws every choice of an outfit.

    Args:
        kind: One of `KINDS`, or `random`, or what else `kinds.worn` knows.
        config: Ranges to draw from.
        rng: Source of the random numbers.
        own: Garments of one's own by name.

    Returns:
        The plan.

    Raises:
        ValueError: There is no such kind.

    Source: CLOTH3D, Garment Generation, Elastics and Variability.
    """
    u = dict(zip(DRAWS, rng.random(len(DRAWS)).tolist()))
    if kind == "random":
        kind = _pick(KINDS, u["kind"])
    # From the inner garment to the outer one.
    names = worn(kind, own)[::-1]
    low, high = config.tightness_range
    tightness = (low + (high - low) * u["tightness_1"], low + (high - low) * u["tightness_2"])
    mine = [name for name in names if name in own]
    garments = tuple(
        _own_garment(own[name], config, u[f"own_fabric_{mine.index(name)}"])
        if name in own
        else _template_garment(name, config, u)
        for name in names
    )
    return OutfitPlan(kind, tightness, garments)


def _own_garment(own: OwnGarment, config: Config, u: float) -> GarmentPlan:
    fabric = _pick(own.fabrics or config.fabrics_of(own.type), u)
    return GarmentPlan(own.name, own.type, (), fabric, dict(own.elastics))


def _template_garment(name: str, config: Config, u: Mapping[str, float]) -> GarmentPlan:
    values = _parameters(config, u)
    fabric = _pick(config.fabrics_of(name), u["upper_fabric" if name in UPPER else "lower_fabric"])
    if name in ("jumpsuit", "dress"):
        templates = (_pick(UPPER, u["upper"]), "trousers" if name == "jumpsuit" else "skirt")
        pieces = tuple(_sewn_piece(template, _cuts(template, config, u), values) for template in templates)
        ends = [*_ends(pieces), "waist"]
    else:
        cuts = _cuts(name, config, u)
        if name == "tshirt" and u["open_front"] < config.open_front_chance:
            cuts = (*("round_neck" if cut == "boat_neck" else cut for cut in cuts if cut != "placket"), "front_opening")
            values |= {name: OPEN_NECK * values[name] for name in ("neck_depth", "neck_width")}
        pieces = (_piece(name, cuts, values),)
        ends = _ends(pieces)
    ratios = {end: _between(config.elastic_ratio, u[f"{end}_ratio"]) for end in ends}
    elastics = {end: ratio for end, ratio in ratios.items() if u[f"{end}_elastic"] < config.elastic_chance}
    return GarmentPlan(name, name, pieces, fabric, elastics)


def _parameters(config: Config, u: Mapping[str, float]) -> dict[str, float]:
    """The shape parameters, each uniform in its range."""
    offset = config.widening_offset
    ranges = {
        name: offset if name.endswith("_offset") else getattr(config, name)
        for names in (*PARAMETERS.values(), *CUTS.values())
        for name in (*names, "seam_height")
    }
    return {name: _between(limits, u[name]) for name, limits in ranges.items()}


def _cuts(template: str, config: Config, u: Mapping[str, float]) -> tuple[str, ...]:
    """The cuts of an upper garment, but for an open front; none of a lower one."""
    if template not in UPPER:
        return ()
    if template == "top" and u["strapless"] < config.strapless_chance:
        return ("strapless",)
    cuts: tuple[str, ...] = (f"{_pick(config.necklines, u['neckline'])}_neck",)
    if template == "tshirt" and u["collar"] < config.collar_chance:
        cuts = ("collar", "placket") if u["placket"] < config.placket_chance else ("collar",)
    return (*cuts, "armholes") if template == "tshirt" and u["vest"] < config.vest_chance else cuts


def _piece(template: str, cuts: tuple[str, ...], values: Mapping[str, float], without: Sequence[str] = ()) -> Piece:
    names = [*PARAMETERS[template], *(name for cut in cuts for name in CUTS[cut])]
    sleeveless = "armholes" in cuts
    kept = [name for name in names if name not in without and not (sleeveless and name.startswith("sleeve"))]
    return Piece(template, {name: values[name] for name in kept}, cuts)


def _sewn_piece(template: str, cuts: tuple[str, ...], values: Mapping[str, float]) -> Piece:
    """A piece that ends at the waist seam instead of at its own hem or waist."""
    piece = _piece(template, cuts, values, without=("torso_length", "waist_height"))
    return replace(piece, parameters={**piece.parameters, "seam_height": values["seam_height"]})


def _ends(pieces: Sequence[Piece]) -> list[str]:
    """Ends of the pieces that may carry an elastic."""
    return [ELASTIC_ENDS[p.template] for p in pieces if p.template in ELASTIC_ENDS and "armholes" not in p.cuts]


def _between(limits: tuple[float, float], u: float) -> float:
    return limits[0] + (limits[1] - limits[0]) * u


def _pick(choices: Sequence[str], u: float) -> str:
    return choices[min(int(u * len(choices)), len(choices) - 1)]
