"""The fabrics that garments are made of, in SI units, each with the publication it comes from."""

import dataclasses
import tomllib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from stages.spec import DataError

FABRICS_FILE = Path(__file__).parent / "fabrics.toml"

CONSTANTS = (
    "density",
    "thickness",
    "stretch_stiffness",
    "shear_stiffness",
    "bend_stiffness",
    "damping",
    "friction",
)
"""Numbers that every fabric must give; all are positive."""

OPTIONAL = ("drag", "stretch_limit", "stiffening")
"""Numbers that a fabric may give; the simulation has its own where one does not. All are positive."""

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


@lru_cache(maxsize=4)
def load_fabrics(path: Path = FABRICS_FILE) -> dict[str, Fabric]:
    """Reads fabrics from a TOML file.

    Args:
        path: The file: one table per fabric, see `fabrics.toml` for the units.

    Returns:
        The fabrics by name.

    Raises:
        DataError: A value is missing, unknown, or not a positive number.
    """
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise DataError(f"{path.name}: cannot be read as fabrics ({error}); give a TOML file of tables") from error
    fabrics = {}
    for name, table in tables.items():
        if not isinstance(table, dict):
            raise DataError(f"{path.name}: {name!r} must be a table of a fabric, got {table!r}")
        unknown = sorted(set(table) - set(CONSTANTS) - set(OPTIONAL) - {"description", "source", "published"})
        if unknown:
            raise DataError(f"{path.name} [{name}]: unknown key {unknown[0]!r}; a fabric has {', '.join(CONSTANTS)}")
        given = [*CONSTANTS, *(constant for constant in OPTIONAL if constant in table)]
        for constant in given:
            value = table.get(constant)
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < float("inf"):
                raise DataError(f"{path.name} [{name}]: {constant} must be a number > 0, got {value!r}")
        fabrics[name] = Fabric(
            name=name,
            description=str(table.get("description", "")),
            source=str(table.get("source", "")),
            published=_published(table.get("published", {}), f"{path.name} [{name}.published]"),
            **{constant: float(table[constant]) for constant in given},
        )
    return fabrics


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
