"""Bodies: a person's shape and motion, put together into a posed sequence that cloth can be laid on."""

from stages.body.config import Config
from stages.spec import StageSpec

SPEC = StageSpec(
    name="body",
    needs=(),
    params=("gender", "body_model", "body_model_sha256", "motion", "motion_sha256", "action", "start", "frames"),
    config=Config,
    code_version=6,
    schema="body",
)
