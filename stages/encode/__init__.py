"""Encode: garments as offsets from the layer of their wearer, at rest and in every frame of a sequence."""

from stages.encode.config import EncodeConfig
from stages.spec import StageSpec

SPEC = StageSpec(
    name="encode",
    needs=("body", "outfit", "simulate", "register"),
    config=EncodeConfig,
    code_version=1,
    schema="encode",
)
