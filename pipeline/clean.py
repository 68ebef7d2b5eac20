"""Removes results and their receipts."""

from __future__ import annotations

import shutil
from collections.abc import Iterable

from pipeline.plan import Plan, PlannedTask
from stages.receipt import receipt_path


def clean(plan: Plan, tasks: Iterable[PlannedTask]) -> int:
    """Remove what `tasks` published, receipts first, and return how many had something to remove."""
    removed = 0
    for task in tasks:
        output = plan.output(task)
        receipt = receipt_path(output, task.item)
        removed += receipt.exists() or output.exists()
        receipt.unlink(missing_ok=True)
        if output.is_dir():
            shutil.rmtree(output)
        else:
            output.unlink(missing_ok=True)
    return removed
