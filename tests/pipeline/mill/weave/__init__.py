"""Toy stage: needs yarn, runs on sequences only."""

from dataclasses import dataclass

from stages.spec import StageSpec


@dataclass(frozen=True, kw_only=True)
class Config:
    """What the toy makes."""

    scale: float = 2.0
    """Factor [1]."""
    sleep_s: float = 0.0
    """Time that the toy wastes [s]."""


SPEC = StageSpec(name="weave", needs=("yarn",), kinds=("sequence",), config=Config, code_version=1, schema="train")
