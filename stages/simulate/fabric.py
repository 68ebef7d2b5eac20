"""The constants of a fabric, in SI units, that the solver's energies are made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from stages.fabrics import load_fabrics, sheet_stiffness
from stages.settings import suggestion
from stages.spec import DataError


@dataclass(frozen=True, kw_only=True)
class Fabric:
    """Constants of one fabric; the same numbers drape alike whatever the mesh."""

    density: float = 0.15
    """Mass per area [kg/m^2]."""
    stretch_stiffness: float = 500.0
    """Tension per width and strain along the threads [N/m]."""
    shear_stiffness: float = 45.0
    """Shear force per width and angle [N/m]."""
    bend_stiffness: float = 1.0e-5
    """Flexural rigidity per width [N m]."""
    stretch_limit: float = 0.04
    """Strain beyond which the fabric stiffens, its crimp pulled straight."""
    stiffening: float = 4.0
    """Stiffness beyond `stretch_limit` over the stiffness before it."""
    damping: float = 2.0e-3
    """Damping of stretch and bend, proportional to stiffness [s]."""
    drag: float = 0.2
    """Air drag per area and speed [kg/(m^2 s)]."""
    friction: float = 0.4
    """Coulomb coefficient against skin and other garments."""

    @classmethod
    def of(cls, constants: Mapping[str, Any], name: str) -> Fabric:
        """A fabric from an outfit's metadata; keys that the solver does not use are left alone.

        Raises:
            DataError: If a constant is not finite and positive (drag, damping, friction: not negative).
        """
        own = {f.name for f in fields(cls)}
        values = {k: float(v) for k, v in constants.items() if k in own}
        fabric = cls(**values)
        for f in fields(cls):
            value = getattr(fabric, f.name)
            low_is_open = f.name in ("density", "stretch_stiffness", "shear_stiffness", "stiffening")
            if not (value > 0 if low_is_open else value >= 0) or value == float("inf"):
                limit = "> 0" if low_is_open else ">= 0"
                raise DataError(f"{name}: fabric constant {f.name} must be finite and {limit}, got {value!r}")
        return fabric

    @property
    def sheet_stiffness(self) -> float:
        """Young's modulus of the isotropic sheet that stands for this fabric [N/m], see `stages.fabrics`."""
        return sheet_stiffness(self.stretch_stiffness, self.shear_stiffness)


def named_fabric(name: str) -> Fabric:
    """The fabric `name` of `stages/fabrics.toml`; or the only one of a file of that form, if `name` ends in `.toml`.

    Raises:
        DataError: If there is no such fabric or file, or the file holds another number of fabrics than one.
    """
    if name.endswith(".toml"):
        own = load_fabrics(Path(name))
        if len(own) != 1:
            raise DataError(f"{name}: holds {len(own)} fabrics, must hold one; part the file")
        (label, chosen), *_ = own.items()
        return Fabric.of(chosen.as_attrs(), label)
    known = load_fabrics()
    if name not in known:
        raise DataError(f"fabric {name!r} is unknown; {suggestion(name, known)}, or give the path of a .toml file")
    return Fabric.of(known[name].as_attrs(), name)
