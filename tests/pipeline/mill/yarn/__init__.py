"""Toy stage: random numbers of the item's seed; takes time, and fails on demand."""

from dataclasses import dataclass, field

from stages.spec import StageSpec


@dataclass(frozen=True, kw_only=True)
class Config:
    """What the toy makes."""

    length: int = field(default=4, metadata={"ge": 1, "le": 1000})
    """Length of the yarn [1]."""
    twist: float = field(default=0.5, metadata={"gt": 0})
    """Turns of the yarn [1/m]."""
    span: tuple[float, float] = (-1.0, 1.0)
    """Range of the numbers [m]."""
    sleep_s: float = field(default=0.0, metadata={"ge": 0})
    """Time that the toy wastes [s]."""
    fault: str = field(default="", metadata={"choices": ("", "data", "error", "nan", "transient", "crash")})
    """How `faulty` items fail."""
    faulty: tuple[str, ...] = ()
    """Items that fail."""


SPEC = StageSpec(
    name="yarn", needs=(), params=("gender", "motion", "motion_sha256"), config=Config, code_version=1, schema="train"
)
