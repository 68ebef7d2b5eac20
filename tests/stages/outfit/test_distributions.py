"""2,000 outfits, drawn with the seeds of a dataset: every choice follows its stated distribution, and none comes twice.

The seeds are fixed, so that the tests always say the same. Each is refused at a chance of one in ten thousand of being
wrong about a right program; `test_the_tests_can_fail` shows how little it takes for them to see a wrong one.
"""

from collections import Counter, defaultdict
from functools import lru_cache

import numpy as np
import pytest
from scipy import stats

from stages.outfit.config import Config
from stages.outfit.kinds import KINDS, NECKLINES, UPPER
from stages.outfit.plan import CUTS, OPEN_NECK, PARAMETERS, GarmentPlan, OutfitPlan, draw_plan
from stages.spec import seed_of

COUNT = 2000
LEAST = 1e-4
"""p-value below which a distribution is taken to be another one."""

CONFIG = Config()


@lru_cache(maxsize=2)
def plans(kind: str = "") -> tuple[OutfitPlan, ...]:
    """2,000 plans as of static items, the kinds in turn as in a dataset, or all of one kind."""
    kinds = [kind or KINDS[number % len(KINDS)] for number in range(COUNT)]
    seeds = [seed_of(2020, "outfit", f"static_{number:05d}") for number in range(COUNT)]
    return tuple(draw_plan(k, CONFIG, np.random.default_rng(seed)) for k, seed in zip(kinds, seeds))


def garments() -> list[GarmentPlan]:
    return [garment for plan in plans() for garment in plan.garments]


@lru_cache(maxsize=1)
def drawn() -> dict[str, list[float]]:
    """Every number that was drawn and is used, by its name."""
    values: dict[str, list[float]] = defaultdict(list)
    for plan in plans():
        for number, value in enumerate(plan.tightness):
            values[f"tightness_{number}"].append(value)
    for garment in garments():
        for piece in garment.pieces:
            share = OPEN_NECK if "front_opening" in piece.cuts else 1.0
            for name, value in piece.parameters.items():
                values[name].append(value / share if name in ("neck_depth", "neck_width") else value)
        for end, ratio in garment.elastics.items():
            values[f"{end}_ratio"].append(ratio)
    return values


def limits(name: str) -> tuple[float, float]:
    """The range that the recipe's section states."""
    if name.startswith("tightness"):
        return CONFIG.tightness_range
    if name.endswith("_ratio"):
        return CONFIG.elastic_ratio
    return CONFIG.widening_offset if name.endswith("_offset") else getattr(CONFIG, name)


def uniform(values: list[float], low: float, high: float) -> float:
    """Chance of such values if they are uniform (Kolmogorov and Smirnov)."""
    return float(stats.kstest(values, "uniform", (low, high - low)).pvalue)


def evenly(counts: Counter[str], shares: dict[str, float]) -> float:
    """Chance of such counts if the choices have these shares (chi-squared)."""
    total = sum(counts.values())
    assert set(counts) <= set(shares)
    return float(stats.chisquare([counts[name] for name in shares], [total * s for s in shares.values()]).pvalue)


def test_every_number_is_uniform_in_its_range() -> None:
    found = {name: uniform(values, *limits(name)) for name, values in drawn().items()}
    shapes = {name for names in (*PARAMETERS.values(), *CUTS.values()) for name in names} | {"seam_height"}
    ends = {"sleeve_ratio", "leg_ratio", "waist_ratio"}
    assert set(found) == shapes | ends | {"tightness_0", "tightness_1"}, "none is forgotten"
    assert min(len(values) for values in drawn().values()) > 90
    assert {name: p for name, p in found.items() if p < LEAST} == {}


def test_the_tests_can_fail() -> None:
    """A range a fortieth too wide, a slight slope, or a mean of two draws in place of one are seen."""
    values = np.array(drawn()["torso_length"])
    low, high = limits("torso_length")
    u = (values - low) / (high - low)
    assert uniform(list(low + (high - low) * u**1.25), low, high) < LEAST
    assert uniform(list(values), low - 0.1 * (high - low), high) < LEAST
    assert uniform(list((u[:-1] + u[1:]) / 2), 0.0, 1.0) < LEAST
    assert evenly(Counter({"cotton": 560, "silk": 440}), {"cotton": 0.5, "silk": 0.5}) < 1e-3


def test_numbers_do_not_depend_on_each_other() -> None:
    """Rank correlation of every two numbers of the same garment."""
    rows: dict[tuple[str, ...], list[dict[str, float]]] = defaultdict(list)
    for plan in plans():
        tightness = {"tightness_1": plan.tightness[0], "tightness_2": plan.tightness[1]}
        for garment in plan.garments:
            for piece in garment.pieces:
                where = (garment.name, piece.template, *sorted(piece.parameters))
                rows[where].append({**piece.parameters, **tightness})
    common = {where: table for where, table in rows.items() if len(table) > 50}
    assert len(common) > 12
    for where, table in common.items():
        names = sorted(table[0])
        correlation, p = stats.spearmanr([[row[name] for name in names] for row in table])
        np.fill_diagonal(p, 1.0)
        # Some 25 pairs a table, fifteen tables.
        assert p.min() > LEAST / 25, (where, names, correlation)


def test_garments_and_their_fabrics_are_balanced() -> None:
    worn = Counter(garment.name for garment in garments())
    # Of six kinds two have each of t-shirt, top, trousers and skirt, and one is a jumpsuit, one a dress.
    assert worn["jumpsuit"] == pytest.approx(COUNT / 6, abs=1) and worn["dress"] == pytest.approx(COUNT / 6, abs=1)
    for name in ("tshirt", "top", "trousers", "skirt"):
        assert worn[name] == pytest.approx(COUNT / 3, abs=2)
    for name in worn:
        fabrics = Counter(garment.fabric for garment in garments() if garment.name == name)
        choices = CONFIG.upper_fabrics if name in ("tshirt", "top") else CONFIG.lower_fabrics
        assert evenly(fabrics, dict.fromkeys(choices, 1 / len(choices))) > LEAST, (name, fabrics)


def test_random_kinds_and_upper_halves_are_balanced() -> None:
    kinds = Counter(plan.kind for plan in plans("random"))
    assert evenly(kinds, dict.fromkeys(KINDS, 1 / len(KINDS))) > LEAST
    uppers = Counter(garment.pieces[0].template for garment in garments() if len(garment.pieces) == 2)
    assert evenly(uppers, {"tshirt": 0.5, "top": 0.5}) > LEAST


def test_cuts_come_as_often_as_the_recipe_says() -> None:
    uppers = [garment.pieces[0] for garment in garments() if garment.pieces[0].template in UPPER]
    closed = [piece for piece in uppers if "front_opening" not in piece.cuts]
    necks = Counter(cut for piece in closed for cut in piece.cuts if cut.endswith("_neck"))
    assert not any("boat_neck" in piece.cuts for piece in uppers if piece not in closed), "it would slide off"
    assert evenly(necks, {f"{name}_neck": 1 / 3 for name in NECKLINES}) > LEAST
    collars = [p for p in uppers if "collar" in p.cuts]
    alone = [p for p in collars if "front_opening" not in p.cuts]
    assert stats.binomtest(sum("placket" in p.cuts for p in alone), len(alone), CONFIG.placket_chance).pvalue > LEAST
    assert not any("placket" in p.cuts for p in uppers if p not in alone)
    for template, cut, chance in (
        ("tshirt", "collar", CONFIG.collar_chance),
        ("tshirt", "armholes", CONFIG.vest_chance),
        ("top", "strapless", CONFIG.strapless_chance),
    ):
        there = [cut in piece.cuts for piece in uppers if piece.template == template]
        assert stats.binomtest(sum(there), len(there), chance).pvalue > LEAST
    shirts = ["front_opening" in g.pieces[0].cuts for g in garments() if g.name == "tshirt"]
    assert stats.binomtest(sum(shirts), len(shirts), CONFIG.open_front_chance).pvalue > LEAST
    assert not any("front_opening" in p.cuts for p in uppers if "seam_height" in p.parameters)
    tops = [[cut for cut in p.cuts if cut in ("strapless", "collar") or cut.endswith("_neck")] for p in uppers]
    assert all(len(names) == 1 for names in tops)


def test_half_of_the_ends_have_an_elastic() -> None:
    """CLOTH3D, Elastics: 50 % each at sleeves, legs, and the waist of full-body garments."""
    ends: dict[str, list[bool]] = defaultdict(list)
    for garment in garments():
        templates = [piece.template for piece in garment.pieces]
        sleeved = templates[0] == "tshirt" and "armholes" not in garment.pieces[0].cuts
        for end, has in (("sleeve", sleeved), ("leg", "trousers" in templates)):
            if has:
                ends[end].append(end in garment.elastics)
        if len(templates) == 2:
            ends["waist"].append("waist" in garment.elastics)
    for end, there in ends.items():
        assert stats.binomtest(sum(there), len(there), 0.5).pvalue > LEAST, end
    both = Counter((a, b) for a, b in zip(ends["sleeve"], ends["sleeve"][1:]))
    assert stats.chisquare(list(both.values())).pvalue > LEAST, "one outfit's elastics must not tell the next one's"


def test_no_two_outfits_are_alike() -> None:
    """Not even when every number is known to a hundredth of its range alone."""
    seen = Counter()
    for plan in plans():
        parts = [
            (
                garment.name,
                garment.fabric,
                tuple(sorted((end, step(f"{end}_ratio", r)) for end, r in garment.elastics.items())),
                tuple(
                    (p.template, *p.cuts, *((n, step(n, v)) for n, v in sorted(p.parameters.items())))
                    for p in garment.pieces
                ),
            )
            for garment in plan.garments
        ]
        tightness = tuple(step("tightness", value) for value in plan.tightness)
        seen[plan.kind, tightness, *parts] += 1
    assert len(seen) == COUNT and seen.most_common(1)[0][1] == 1


def step(name: str, value: float) -> int:
    """The hundredth of its range that a value lies in."""
    low, high = limits(name)
    return int(100 * (value - low) / (high - low))
