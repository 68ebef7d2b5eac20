"""Toy stage: runs once, over every item, and publishes a folder."""

from dataclasses import dataclass

from stages.spec import StageSpec


@dataclass(frozen=True, kw_only=True)
class Config:
    """What the toy makes."""

    title: str = "bolt"
    """Title."""


SPEC = StageSpec(
    name="bolt",
    needs=("yarn", "weave"),
    scope="dataset",
    params=("items",),
    config=Config,
    code_version=1,
    schema="report",
    suffix="",
)
