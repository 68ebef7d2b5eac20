"""What static people cost: a recipe of nothing else, run by the pipeline up to the outfits."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

RECIPE = """[dataset]
name = "statics"
seed = {seed}
statics = {count}
test_share = 0.2
tolerated_rejections = 0.9
"""


def statics(count: int, folder: Path, seed: int = 7) -> dict[str, Any]:
    """Makes static people, bodies and outfits, one at a time in one worker a stage.

    Args:
        count: How many.
        folder: Where to; everything that is read, made and published lies in it.
        seed: Of the recipe.

    Returns:
        How many were published and rejected, the CPU time of one, its share of starting the programs included [s], and
        the largest memory of a worker during one task [MB].

    Raises:
        subprocess.CalledProcessError: The run failed.
    """
    recipe = folder / "statics.toml"
    recipe.write_text(RECIPE.format(count=count, seed=seed))
    before = _cpu()
    command = [sys.executable, "-m", "pipeline", "run", str(recipe), "--output", str(folder / "out"), "--jobs", "1"]
    subprocess.run([*command, "--until", "outfit"], check=True, stdout=subprocess.DEVNULL)
    spent = _cpu() - before
    receipts = [json.loads(path.read_text()) for path in sorted(folder.glob("out/*/receipts/*.json"))]
    published = len(list(folder.glob("out/outfit/*.h5")))
    return {
        "published": published,
        "rejected": count - published,
        "seconds": spent / count,
        "memory_mb": max(receipt["peak_bytes"] for receipt in receipts) / 1e6,
    }


def _cpu() -> float:
    """CPU time of all programs started so far that have ended [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
