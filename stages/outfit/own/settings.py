"""What a recipe says of an own garment; light, since the pipeline reads it, too."""

import re
from dataclasses import dataclass, field

from stages.outfit.kinds import LOWER, TYPES

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Units of length -> metres."""

UPS = ("z", "y")
"""Axes that may point up: z as here, the person facing -y; or y, the person facing z, as in most modelling programs."""

ORIGINS = ("root", "floor")
"""Where the file's origin may lie: in the body's root joint, as here, or on the floor below it."""


@dataclass(frozen=True, kw_only=True)
class OwnGarment:
    """One `[[dataset.garment]]` of the recipe: a garment of one's own, placed on a body in the rest pose.

    `python -m stages.outfit body OUT.obj` writes the body to place it on.
    """

    name: str
    """What outfits call it: letters, digits, `_` and `-`."""
    file: str
    """Path of its OBJ file."""
    type: str = field(metadata={"choices": TYPES})
    """The type that it is most like: which topology it is registered to, and what it counts as in training."""
    gender: str = field(metadata={"choices": ("female", "male")})
    """Gender of the body that it is placed on in the file; women and men may wear it."""
    betas: tuple[float, ...] = field(default=(), metadata={"ge": -5.0, "le": 5.0})
    """Shape of that body; those left out are 0 [standard deviations]."""
    unit: str = field(default="m", metadata={"choices": tuple(UNITS)})
    """Unit of length of the file."""
    up: str = field(default="z", metadata={"choices": UPS})
    """Axis of the file that points up."""
    origin: str = field(default="root", metadata={"choices": ORIGINS})
    """Where the file's origin is: in the root joint of the body or on the floor under its feet."""
    fabrics: tuple[str, ...] = ()
    """Fabrics to choose from; those of its type if left out [names]."""
    elastics: dict[str, float] = field(default_factory=dict)
    """Border, such as left_sleeve, hem or neck (sleeve: both) -> rest length of its elastic over the cloth's [1]."""
    waistband: bool = True
    """Whether trousers and skirts are held up by a band of the wearer's girth at their highest border."""

    def __post_init__(self) -> None:
        """Checks what a range cannot tell.

        Raises:
            ValueError: Which setting is wrong, and how.
        """
        if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_\-]*", self.name) or self.name in (*TYPES, "random"):
            raise ValueError(
                f"name must be of letters, digits, '_' and '-', and not that of an embedded garment, got {self.name!r}"
            )
        if not self.file.lower().endswith(".obj"):
            raise ValueError(f"file must be an OBJ file (.obj), got {self.file!r}")
        if len(self.betas) > 10:
            raise ValueError(f"betas must have at most 10 values, got {len(self.betas)}")
        for border, ratio in self.elastics.items():
            if not 0.3 < ratio <= 1.0:
                raise ValueError(f"elastics.{border} must be > 0.3 and <= 1 of the cloth's length, got {ratio:g}")

    @property
    def banded(self) -> bool:
        """Whether it is held up by a waistband."""
        return self.waistband and self.type in LOWER
