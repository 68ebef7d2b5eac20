"""Settings of the stage register."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class RegisterConfig:
    """How the layer is fitted to a garment, and when the result counts."""

    reach: float = field(default=0.12, metadata={"gt": 0.0, "le": 1.0})
    """Largest distance between the layer and a matched point of a garment that follows the body [m]."""

    skirt_reach: float = field(default=0.3, metadata={"gt": 0.0, "le": 1.0})
    """The same for skirts and dresses, which stand off the legs [m]."""

    turn: float = field(default=1.05, metadata={"gt": 0.0, "lt": 1.58})
    """Largest angle between the normals of layer and garment at a match [rad]."""

    normal_scale: float = field(default=0.1, metadata={"ge": 0.0})
    """Distance that a difference of 1 between unit normals counts for in the coarse matching [m]."""

    coarse: tuple[float, ...] = field(default=(30.0, 10.0, 3.0, 1.0), metadata={"gt": 0.0})
    """Falling stiffness, 1, of the rounds that match by position and normal; smooths over sqrt(stiffness) edges."""

    fine: tuple[float, ...] = field(default=(0.3, 0.1), metadata={"gt": 0.0})
    """Falling stiffness, 1, of the rounds that match by the closest point."""

    flange: float = field(default=0.03, metadata={"gt": 0.0, "le": 0.2})
    """How far a garment is continued beyond its borders while it is fitted [m]."""

    tolerance: float = field(default=0.02, metadata={"gt": 0.0})
    """Largest distance from the garment of a fitted vertex that counts as covered [m]."""

    min_coverage: float = field(default=0.95, metadata={"ge": 0.0, "le": 1.0})
    """Share of a garment's area that the registered surface must cover; below it the outfit is rejected."""

    samples: int = field(default=10_000, metadata={"ge": 100})
    """Points on the garment at which the error is measured."""
