"""Outfits: template garments shaped, cut, resized to a body and a tightness, sewn and layered."""

from stages.outfit.config import Config
from stages.spec import StageSpec

SPEC = StageSpec(
    name="outfit",
    needs=("body",),
    params=("outfit",),
    config=Config,
    code_version=2,
    schema="outfit",
)
