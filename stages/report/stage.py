"""Stage report: reads what every stage made, draws it, measures it again and publishes a folder with a page."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import store
from stages.report import exhibits
from stages.report.charts import loss_curves
from stages.report.config import ReportConfig
from stages.report.facts import loss_series, metric_tables
from stages.report.gather import read_person, read_training, spread
from stages.report.page import page
from stages.settings import build
from stages.spec import Progress, Task

# A sequence costs about as much as this many outfits at rest.
SEQUENCE_COST = 60


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Publishes the report's folder; returns how many sequences it shows and how many of them are good."""
    config = build(ReportConfig, task.config)
    moving = sorted(task.inputs["simulate"])
    still = sorted(set(task.inputs["body"]) - set(moving))
    shown, posed = spread(moving, config.sequences), spread(still, config.statics)
    training, made = read_training(task)
    total = SEQUENCE_COST * len(shown) + len(posed) + len(made)
    figures: dict[str, Any] = {}

    def fill(folder: Path) -> None:
        sequences, statics, garments = [], [], []
        for n, item in enumerate(shown):
            seen = partial(_seen, progress, total, n, item)
            sequences.append(exhibits.sequence(folder, read_person(task, item), config, seen))
        done = SEQUENCE_COST * len(shown)
        for n, item in enumerate(posed, start=1):
            statics.append(exhibits.still(folder, read_person(task, item)))
            progress(done + n, total, f"outfit {item}")
        for n, garment in enumerate(made, start=1 + len(posed)):
            garments.append(exhibits.generated(folder, garment))
            progress(done + n, total, f"generated {garment.name}")
        content = {
            "sequences": sequences,
            "statics": statics,
            "generated": garments,
            "tables": metric_tables(training["metrics"]),
            "losses": loss_curves(loss_series(training.get("losses", {}))),
            "counts": {"sequences": len(moving), "statics": len(still)},
        }
        (folder / "index.html").write_text(page(content), encoding="utf-8")
        figures.update(sequences=len(sequences), good=sum(one["good"] for one in sequences))

    store.publish_folder(task.output, task.key, fill)
    return figures


def _seen(progress: Progress, total: int, before: int, item: str, share: float) -> None:
    progress(SEQUENCE_COST * (before + share), total, f"filming {item}")
