"""Fabrics are complete, ordered as cloth is, cited, and bad files are refused in one line."""

from pathlib import Path

import pytest

from stages.fabrics import CONSTANTS, FABRICS_FILE, LIMITS, load_fabrics
from stages.outfit.config import FABRICS
from stages.spec import DataError


def test_the_four_fabrics_are_there_with_their_sources() -> None:
    fabrics = load_fabrics()
    assert tuple(fabrics) == FABRICS
    assert all(len(fabric.source) > 40 and any(c.isdigit() for c in fabric.source) for fabric in fabrics.values())


def test_they_are_ordered_as_on_a_scale_and_in_the_hand() -> None:
    silk, cotton, denim, leather = (load_fabrics()[name] for name in ("silk", "cotton", "denim", "leather"))
    for constant in ("density", "stretch_stiffness", "shear_stiffness", "bend_stiffness"):
        values = [getattr(fabric, constant) for fabric in (silk, cotton, denim, leather)]
        assert values == sorted(values)
    # A cantilever bends under its own weight over about (B / (rho g))^(1/3): centimetres for cloth.
    for fabric in (silk, cotton, denim, leather):
        assert 0.01 < (fabric.bend_stiffness / (fabric.density * 9.81)) ** (1 / 3) < 0.04


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "density = 0.130",
            "density = -0.130",
            r"mine.toml \[cotton\]: density must be from 0.005 to 5 kg/m\^2 \(mass per area\), got -0.13$",
        ),
        ("density = 0.130", "density = 130", r"5 kg/m\^2 .*, got 130; 130 g/m\^2 would be 0.13 kg/m\^2$"),
        ("thickness = 3.5e-4", "thickness = 0.35", r"0.02 m .*, got 0.35; 0.35 mm would be 0.00035 m$"),
        ("density = 0.130\n", "", r"density is missing; give a number from 0.005 to 5 kg/m\^2 \(mass per area\)$"),
        ("thickness = 3.5e-4", 'thickness = "thin"', r"thickness must be a number from .*, got 'thin'$"),
        ("friction = 0.45", "friction = nan", r"friction must be from 0.01 to 2 1 .*, got nan$"),
        ("damping = 2.0e-3", "damping = true", r"damping must be a number from .* s .*, got True$"),
        ("stiffening = 20.0", "stiffening = 0.5", r"\[denim\]: stiffening must be from 1 to 200 .*, got 0.5$"),
        ("density = 0.130", "density = 0.130\ndensty = 3", r"unknown key 'densty'; did you mean 'density'\?$"),
        ("[cotton]", "[cotton", "cannot be read as fabrics"),
        ("[0.40, 0.75]", "[0.75, 0.40]", r"\[cotton.published\]: drape_coefficient must be \[low, high\]"),
        ("[0.40, 0.75]", "0.5", r"\[cotton.published\]: drape_coefficient must be \[low, high\], both > 0, got 0.5"),
        ("[0.40, 0.75]", "[0.40, 0.75]\nshine = 1", r"\[cotton.published\]: unknown key 'shine'"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(FABRICS_FILE.read_text().replace(old, new))
    with pytest.raises(DataError, match=message):
        load_fabrics(path)


def test_a_fabric_can_be_added(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    numbers = "\n".join(f"{constant} = {LIMITS[constant].high}" for constant in CONSTANTS)
    path.write_text(f"{FABRICS_FILE.read_text()}\n[felt]\n{numbers}\n")
    assert load_fabrics(path)["felt"].friction == LIMITS["friction"].high
    path.write_text(f"[felt]\n{numbers}\n".replace("friction = 2.0", "friction = 0.7"))
    assert load_fabrics(path)["felt"].friction == 0.7, "an edited file is read again"


def test_a_file_without_fabrics_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("# nothing yet\n")
    with pytest.raises(DataError, match=r"mine.toml: has no fabric; give a table of density, thickness"):
        load_fabrics(tmp_path / "mine.toml")
    (tmp_path / "mine.toml").write_bytes(b"\xff\xfe[felt]")
    with pytest.raises(DataError, match=r"mine.toml: cannot be read as fabrics"):
        load_fabrics(tmp_path / "mine.toml")


def test_what_is_published_says_where_and_stays_out_of_the_shards() -> None:
    for fabric in load_fabrics().values():
        assert len(fabric.published.source) > 40
        assert "published" not in fabric.as_attrs()
    assert load_fabrics()["denim"].published.extension == (0.047, 0.057)
