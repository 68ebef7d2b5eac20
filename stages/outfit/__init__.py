"""Outfits: template garments shaped, cut, resized to a body and a tightness, sewn and layered."""

from stages.outfit.config import Config
from stages.spec import StageSpec

SPEC = StageSpec(
    name="outfit",
    needs=("body",),
    params=("outfit", "own_garments", "own_files", "own_files_sha256", "fabrics", "fabrics_sha256"),
    config=Config,
    code_version=9,
    schema="outfit",
)
