"""Register: each garment of an outfit gets the body layer's topology, once, in rest pose."""

from stages.register.config import RegisterConfig
from stages.spec import StageSpec

SPEC = StageSpec(
    name="register",
    needs=("body", "outfit"),
    config=RegisterConfig,
    code_version=2,
    schema="register",
)
