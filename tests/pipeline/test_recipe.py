"""Recipes: whatever is wrong with one is said in one line, with what to do."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import pytest

from pipeline.catalog import Catalog
from pipeline.errors import PipelineError
from pipeline.recipe import load_recipe
from stages import settings
from stages.settings import SettingsError

GOOD = '[dataset]\nname = "d"\nstatics = 2\n'


def _load(folder: Path, catalog: Catalog, text: str) -> object:
    path = folder / "r.toml"
    path.write_text(text)
    return load_recipe(path, catalog)


def test_what_is_left_out_takes_its_default(tmp_path: Path, catalog: Catalog) -> None:
    path = tmp_path / "r.toml"
    path.write_text(GOOD + "[yarn]\nspan = [0, 2]\n")
    recipe = load_recipe(path, catalog)
    assert recipe.output == Path("build/d")
    assert recipe.sections["yarn"].span == (0.0, 2.0)
    assert recipe.plain_section("yarn")["length"] == 4
    assert recipe.sections["bolt"].title == "bolt"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[yarn]\nlenght = 3", "r.toml [yarn]: unknown key 'lenght'; did you mean 'length'?"),
        ("[yarm]\nlength = 3", "r.toml: unknown section [yarm]; did you mean 'yarn'?"),
        ("[yarn]\ntwist = -1", "r.toml [yarn]: twist must be > 0 1/m, got -1.0 (Turns of the yarn [1/m])"),
        ("[yarn]\nlength = 1001", "r.toml [yarn]: length must be <= 1000 1, got 1001 (Length of the yarn [1])"),
        ("[yarn]\nlength = 2.5", "r.toml [yarn]: length must be a whole number, got 2.5 (Length of the yarn [1])"),
        ("[yarn]\ntwist = '0.1'", "r.toml [yarn]: twist must be a number, got '0.1' (Turns of the yarn [1/m])"),
        ("[yarn]\ntwist = inf", "r.toml [yarn]: twist must be finite, got inf (Turns of the yarn [1/m])"),
        ("[yarn]\ntwist = nan", "r.toml [yarn]: twist must be finite, got nan (Turns of the yarn [1/m])"),
        ("[yarn]\ntwist = true", "r.toml [yarn]: twist must be a number, got True (Turns of the yarn [1/m])"),
        ("[yarn]\nspan = [1.0]", "r.toml [yarn]: span must be a list of 2 (a number, a number), got [1.0] (Range of"),
        ("[yarn]\nfault = 'dat'", "r.toml [yarn]: fault must be one of , data, error"),
        ("[dataset.x]", "r.toml [dataset]: unknown key 'x'; known: "),
        ("yarn = 3", "r.toml [dataset]: unknown key 'yarn'; known: "),
        (
            "[[dataset.sequence]]\nid = 'a'\ngender = 'femal'\nmotion = 'walk'",
            "[dataset]: sequence: gender must be one of ",
        ),
        (
            "[[dataset.sequence]]\nid = 'a'\nmotion = 'walk'",
            "[dataset]: sequence: gender is missing (Gender of the body)",
        ),
        ("[yarn]\nlength = ", "r.toml: not valid TOML: "),
        ("sequences = 3", "r.toml [dataset]: motions is missing: sequences = 3 are drawn from motion files"),
    ],
)
def test_a_bad_recipe_is_refused_in_one_line(tmp_path: Path, catalog: Catalog, text: str, message: str) -> None:
    with pytest.raises(PipelineError) as caught:
        _load(tmp_path, catalog, GOOD + text)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_recipe_must_be_there_and_have_items(tmp_path: Path, catalog: Catalog) -> None:
    with pytest.raises(PipelineError, match="no such recipe"):
        load_recipe(tmp_path / "none.toml", catalog)
    with pytest.raises(PipelineError, match="can't be read"):
        load_recipe(tmp_path, catalog)
    with pytest.raises(PipelineError, match=r"section \[dataset\] is missing"):
        _load(tmp_path, catalog, "")
    with pytest.raises(PipelineError, match="there are no items"):
        _load(tmp_path, catalog, '[dataset]\nname = "d"\n')


@dataclass(frozen=True, kw_only=True)
class Inner:
    """A nested table."""

    depth: int = field(default=1, metadata={"ge": 0})
    """Depth [m]."""


@dataclass(frozen=True, kw_only=True)
class Outer:
    """Every kind of setting."""

    inner: Inner = Inner()
    """A table."""
    mode: Literal["a", "b"] = "a"
    """A mode."""
    limit: float | None = None
    """A limit, or none [s]."""
    scales: tuple[float, ...] = field(default=(), metadata={"gt": 0})
    """Scales [1]."""

    def __post_init__(self) -> None:
        if self.limit == 13:
            raise ValueError("limit must not be 13")


def test_settings_of_every_kind_survive_json() -> None:
    given = {"inner": {"depth": 3}, "mode": "b", "limit": 2, "scales": [1, 2.5]}
    made = settings.build(Outer, given)
    assert made == Outer(inner=Inner(depth=3), mode="b", limit=2.0, scales=(1.0, 2.5))
    assert settings.build(Outer, settings.plain(made)) == made


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"inner": {"deep": 1}}, "inner: unknown key 'deep'; did you mean 'depth'?"),
        ({"inner": {"depth": -1}}, "inner: depth must be >= 0 m, got -1"),
        ({"inner": 3}, "inner: must be a table, got 3"),
        ({"mode": "c"}, "mode must be one of 'a', 'b', got 'c'"),
        ({"limit": "x"}, "limit must be a number, got 'x'"),
        ({"limit": 13.0}, "limit must not be 13"),
        ({"scales": [1.0, 0.0]}, "scales must be > 0 1, got 0.0"),
        ({"scales": 1.0}, "scales must be a list of a number, got 1.0"),
    ],
)
def test_settings_of_every_kind_are_checked(given: dict[str, object], message: str) -> None:
    with pytest.raises(SettingsError) as caught:
        settings.build(Outer, given)
    assert message in str(caught.value)
