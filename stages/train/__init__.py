"""Train: the garment models SVAE and DVAE, their baselines and metrics, and garments generated from latent codes.

One task over the whole dataset. `params["items"]` maps each item to its kind, "sequence" or "static", and its split,
"train" or "test"; both are decided by the plan, so that the same item is held out of everything.
"""

from stages.spec import StageSpec
from stages.train.config import TrainConfig

SPEC = StageSpec(
    name="train",
    needs=("encode",),
    scope="dataset",
    params=("items",),
    config=TrainConfig,
    code_version=1,
    schema="train",
)
