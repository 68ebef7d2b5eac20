"""What is drawn stays in its range, follows the paper's rules, and depends on nothing else."""

import dataclasses

import numpy as np
import pytest

from stages.outfit.config import Config
from stages.outfit.plan import KINDS, OutfitPlan, draw_plan

DEFAULT = Config()


def plans(kind: str, count: int, config: Config = DEFAULT) -> list[OutfitPlan]:
    return [draw_plan(kind, config, np.random.default_rng(seed)) for seed in range(count)]


@pytest.mark.parametrize("kind", KINDS)
def test_parameters_fill_their_ranges_and_never_leave_them(kind: str) -> None:
    config = Config()
    seen: dict[str, list[float]] = {}
    for plan in plans(kind, 300):
        for garment in plan.garments:
            for piece in garment.pieces:
                for name, value in piece.parameters.items():
                    seen.setdefault(name, []).append(value)
        for value in plan.tightness:
            seen.setdefault("tightness_range", []).append(value)
    for name, values in seen.items():
        low, high = config.widening_offset if name.endswith("_offset") else getattr(config, name)
        # Cuts of few garments are drawn less often.
        edge = max(0.05, 12 / len(values)) * (high - low)
        assert low <= min(values) < low + edge
        assert high - edge < max(values) <= high
        # Uniform: the mean of n draws is within 4 standard errors of the middle.
        assert abs(np.mean(values) - (low + high) / 2) < 4 * (high - low) / np.sqrt(12 * len(values))


def test_signs_are_those_of_the_paper() -> None:
    for plan in plans("tshirt+trousers", 50):
        for garment in plan.garments:
            for name, value in garment.pieces[0].parameters.items():
                assert not name.endswith("narrowing") or value <= 0
                assert not name.endswith("widening") or value >= 0
    assert all(p.garments[0].pieces[0].parameters["skirt_widening"] > 0 for p in plans("tshirt+skirt", 50))


def test_random_outfits_take_every_kind_about_equally_often() -> None:
    kinds = [plan.kind for plan in plans("random", 1200)]
    for kind in KINDS:
        assert 150 < kinds.count(kind) < 250


def test_uppers_are_cotton_or_silk_and_lowers_any_of_four() -> None:
    drawn = plans("top+skirt", 200)
    assert {p.garments[1].fabric for p in drawn} == {"cotton", "silk"}
    assert {p.garments[0].fabric for p in drawn} == {"cotton", "silk", "denim", "leather"}


def test_layers_go_from_the_lower_garment_to_the_shirt_over_it() -> None:
    assert [g.name for g in plans("tshirt+skirt", 1)[0].garments] == ["skirt", "tshirt"]


def test_half_of_the_ends_carry_an_elastic_and_only_full_body_garments_at_the_waist() -> None:
    jumpsuits = plans("jumpsuit", 600)
    waist = sum("waist" in p.garments[0].elastics for p in jumpsuits)
    legs = sum("leg" in p.garments[0].elastics for p in jumpsuits)
    assert 250 < waist < 350
    assert 250 < legs < 350
    assert all("waist" not in g.elastics for p in plans("tshirt+trousers", 100) for g in p.garments)
    always = Config(elastic_chance=1.0)
    assert set(draw_plan("tshirt+trousers", always, np.random.default_rng(0)).garments[0].elastics) == {"leg"}
    never = Config(elastic_chance=0.0)
    assert all(not p.garments[0].elastics for p in plans("jumpsuit", 50, never))


def test_changing_one_setting_changes_one_value() -> None:
    """Counterfactual pairs: the same seed with another range differs in that parameter alone."""
    base = draw_plan("tshirt+trousers", Config(), np.random.default_rng(5))
    other = draw_plan("tshirt+trousers", Config(sleeve_length=(0.2, 0.3)), np.random.default_rng(5))
    assert base.garments[0] == other.garments[0]
    assert base.tightness == other.tightness
    changed = {
        name
        for name, value in base.garments[1].pieces[0].parameters.items()
        if other.garments[1].pieces[0].parameters[name] != value
    }
    assert changed == {"sleeve_length"}
    dress = draw_plan("dress", Config(), np.random.default_rng(5))
    assert dress.tightness == base.tightness


def test_bad_settings_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"leg_length must run from low to high, got \[0.9, 0.4\]"):
        Config(leg_length=(0.9, 0.4))
    with pytest.raises(ValueError, match="upper_fabrics must name at least one fabric"):
        Config(upper_fabrics=())
    with pytest.raises(ValueError, match=r"outfit must be one of .* got 'toga'"):
        draw_plan("toga", Config(), np.random.default_rng(0))


def test_every_setting_says_what_it_is() -> None:
    from stages.settings import _docstrings  # the parser of recipes reads these for its messages

    told = _docstrings(Config)
    assert {f.name for f in dataclasses.fields(Config)} == set(told)
    assert all("[" in text for text in told.values())
