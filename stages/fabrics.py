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

    def as_attrs(self) -> dict[str, Any]:
        """The fabric as JSON values."""
        return dataclasses.asdict(self)


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
        unknown = sorted(set(table) - set(CONSTANTS) - {"description", "source"})
        if unknown:
            raise DataError(f"{path.name} [{name}]: unknown key {unknown[0]!r}; a fabric has {', '.join(CONSTANTS)}")
        for constant in CONSTANTS:
            value = table.get(constant)
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < float("inf"):
                raise DataError(f"{path.name} [{name}]: {constant} must be a number > 0, got {value!r}")
        fabrics[name] = Fabric(
            name=name,
            description=str(table.get("description", "")),
            source=str(table.get("source", "")),
            **{constant: float(table[constant]) for constant in CONSTANTS},
        )
    return fabrics
