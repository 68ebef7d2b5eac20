"""A page that shows what a run made: videos, pictures, figures measured again, and the trained model's scores."""

from stages.report.config import ReportConfig
from stages.spec import StageSpec

SPEC = StageSpec(
    name="report",
    needs=("body", "outfit", "simulate", "train"),
    scope="dataset",
    config=ReportConfig,
    code_version=1,
    schema="report",
    suffix="",
)
