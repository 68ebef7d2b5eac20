"""Simulation: the outfit on the moving body, by implicit mass-spring cloth with contact.

From the rest body that the outfit was made on, through a transition of shape and pose, to every frame of the sequence.
"""

from stages.simulate.config import SimulateConfig
from stages.spec import StageSpec

SPEC = StageSpec(
    name="simulate",
    needs=("body", "outfit"),
    kinds=("sequence",),
    config=SimulateConfig,
    code_version=7,
    schema="simulate",
)
