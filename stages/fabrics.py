"""The fabrics that garments are made of, in SI units, each with the publication it comes from."""

import dataclasses
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from stages.settings import suggestion
from stages.spec import DataError

FABRICS_FILE = Path(__file__).parent / "fabrics.toml"


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What a constant may be, and what it is.

    Attributes:
        low, high: Smallest and largest value. Whatever is worn lies well inside; a value in another unit does not.
        unit: SI unit.
        meaning: What it is, in a few words.
        often: Units that it is often published in -> their size in `unit`, to tell what may have been meant.
    """

    low: float
    high: float
    unit: str
    meaning: str
    often: tuple[tuple[str, float], ...] = ()


LIMITS = {
    "density": Limits(low=0.005, high=5.0, unit="kg/m^2", meaning="mass per area", often=(("g/m^2", 1e-3),)),
    "thickness": Limits(low=1e-5, high=0.02, unit="m", meaning="at low pressure", often=(("mm", 1e-3),)),
    "stretch_stiffness": Limits(low=1.0, high=1e5, unit="N/m", meaning="tension per width and strain"),
    "shear_stiffness": Limits(low=0.1, high=1e5, unit="N/m", meaning="shear force per width and angle"),
    "bend_stiffness": Limits(
        low=1e-8,
        high=1e-2,
        unit="N m",
        meaning="flexural rigidity per width",
        often=(("gf cm^2/cm", 9.81e-5), ("uN m", 1e-6)),
    ),
    "damping": Limits(low=1e-6, high=0.5, unit="s", meaning="proportional to stiffness", often=(("ms", 1e-3),)),
    "friction": Limits(low=0.01, high=2.0, unit="1", meaning="Coulomb coefficient"),
    "drag": Limits(low=1e-4, high=20.0, unit="kg/(m^2 s)", meaning="air drag per area and speed"),
    "stretch_limit": Limits(low=1e-3, high=1.0, unit="1", meaning="strain at which crimp is straight"),
    "stiffening": Limits(low=1.0, high=200.0, unit="1", meaning="stiffness beyond stretch_limit over that before"),
}
"""The numbers that a fabric has. The ranges are wide: from gauze to carpet, not from one shirting to another."""

OPTIONAL = ("drag", "stretch_limit", "stiffening")
"""Numbers that a fabric may leave out; the simulation has its own then."""

CONSTANTS = tuple(name for name in LIMITS if name not in OPTIONAL)
"""Numbers that every fabric must give."""

FIGURES = ("bending_length", "drape_coefficient", "extension")
"""What may be published of such cloth, from low to high: Peirce's bending length [m], Cusick's drape coefficient [1],
strain at 500 gf/cm, the load of the Kawabata tensile test [1]."""


@dataclass(frozen=True, kw_only=True)
class Published:
    """Figures measured on such cloth, to compare the simulation's with; it does not use them itself.

    Attributes:
        bending_length, drape_coefficient, extension: See `FIGURES`; (low, high), or None if none is known.
        source: Where they come from.
    """

    bending_length: tuple[float, float] | None = None
    drape_coefficient: tuple[float, float] | None = None
    extension: tuple[float, float] | None = None
    source: str = ""


@dataclass(frozen=True, kw_only=True)
class Fabric:
    """One fabric."""

    name: str
    """Name in the file."""
    description: str
    """What a shop would call it."""
    density: float
    """Mass per area [kg/m^2]."""
    thickness: float
    """Thickness at low pressure [m]."""
    stretch_stiffness: float
    """Tension per width and strain, at small strain [N/m]."""
    shear_stiffness: float
    """Shear force per width and angle [N/m]."""
    bend_stiffness: float
    """Flexural rigidity per width [N m]."""
    damping: float
    """Damping of stretch and bend, proportional to their stiffness [s]."""
    friction: float
    """Coulomb coefficient against skin and other cloth [1]."""
    source: str
    """Where the numbers come from."""
    drag: float | None = None
    """Air drag per area and speed [kg/(m^2 s)], if it is not the simulation's own."""
    stretch_limit: float | None = None
    """Strain at which the crimp is pulled straight [1], if it is not the simulation's own."""
    stiffening: float | None = None
    """Stiffness beyond that over the stiffness before [1], if it is not the simulation's own."""
    published: Published = Published()
    """What is published of such cloth."""

    def as_attrs(self) -> dict[str, Any]:
        """The fabric's own values as JSON values, without what is published of others."""
        return {k: v for k, v in dataclasses.asdict(self).items() if k != "published" and v is not None}


def sheet_stiffness(stretch: float, shear: float) -> float:
    """Young's modulus [N/m] of the isotropic sheet that stands for a fabric of stiffness `stretch` and `shear` [N/m].

    Woven cloth shears easily, while edge springs tie the shear modulus to 3/8 of Young's. The geometric mean of the
    modulus that fits the threads and the one that fits shear keeps drape soft without letting it stretch; beyond
    `stretch_limit` the stiffening takes over.
    """
    return float((stretch * shear * 8 / 3) ** 0.5)


def load_fabrics(path: Path = FABRICS_FILE) -> dict[str, Fabric]:
    """Reads fabrics from a TOML file.

    Args:
        path: The file: one table per fabric, see `fabrics.toml` for the units.

    Returns:
        The fabrics by name.

    Raises:
        DataError: A value is missing, unknown, no number, or out of the range of `LIMITS`; or there is no fabric.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise DataError(f"{path.name}: cannot be read as fabrics ({error}); give a TOML file of tables") from error
    return dict(parse_fabrics(content, path.name))


@lru_cache(maxsize=4)
def parse_fabrics(content: bytes, file: str) -> Mapping[str, Fabric]:
    """The fabrics in a file's content; `file` is its name, for messages. See `load_fabrics`."""
    try:
        tables = tomllib.loads(content.decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise DataError(f"{file}: cannot be read as fabrics ({error}); give a TOML file of tables") from error
    fabrics = {}
    for name, table in tables.items():
        where = f"{file} [{name}]"
        if not isinstance(table, dict):
            raise DataError(f"{file}: {name!r} must be a table of a fabric, got {table!r}")
        known = (*LIMITS, "description", "source", "published")
        for key in sorted(set(table) - set(known)):
            raise DataError(f"{where}: unknown key {key!r}; {suggestion(key, known)}")
        numbers = {key: _number(key, table.get(key), where) for key in LIMITS if key in table or key in CONSTANTS}
        fabrics[name] = Fabric(
            name=name,
            description=str(table.get("description", "")),
            source=str(table.get("source", "")),
            published=_published(table.get("published", {}), f"{file} [{name}.published]"),
            **numbers,
        )
    if not fabrics:
        raise DataError(f"{file}: has no fabric; give a table of {', '.join(CONSTANTS)} by the fabric's name")
    return fabrics


def _number(name: str, value: Any, where: str) -> float:
    """A fabric's constant, checked."""
    about = LIMITS[name]
    limits = f"from {about.low:g} to {about.high:g} {about.unit} ({about.meaning})"
    if value is None:
        raise DataError(f"{where}: {name} is missing; give a number {limits}")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{where}: {name} must be a number {limits}, got {value!r}")
    if not about.low <= value <= about.high:
        others = [(unit, value * size) for unit, size in about.often if about.low <= value * size <= about.high]
        hints = [f"; {value:g} {unit} would be {meant:g} {about.unit}" for unit, meant in others]
        raise DataError(f"{where}: {name} must be {limits}, got {value:g}{''.join(hints)}")
    return float(value)


def _published(table: Any, where: str) -> Published:
    if not isinstance(table, dict):
        raise DataError(f"{where}: must be a table of figures, got {table!r}")
    unknown = sorted(set(table) - set(FIGURES) - {"source"})
    if unknown:
        raise DataError(f"{where}: unknown key {unknown[0]!r}; it may have {', '.join(FIGURES)} and source")
    ranges = {}
    for figure in set(FIGURES) & set(table):
        value = table[figure]
        numbers = isinstance(value, list) and len(value) == 2 and all(isinstance(v, int | float) for v in value)
        if not numbers or not 0 < value[0] <= value[1] < float("inf"):
            raise DataError(f"{where}: {figure} must be [low, high], both > 0, got {value!r}")
        ranges[figure] = (float(value[0]), float(value[1]))
    return Published(source=str(table.get("source", "")), **ranges)
