"""Makes yarn."""

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np

import store
from mill.yarn import Config
from stages import settings
from stages.spec import DataError, Progress, Task


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Publish the yarn of one item."""
    config = settings.build(Config, task.config)
    for step in range(10):
        time.sleep(config.sleep_s / 10)
        progress(step, 10, "spinning")
    values = np.random.default_rng(task.seed).uniform(*config.span, config.length)
    if task.item in config.faulty:
        _fail(config.fault, Path(task.output), values)
    print("a library that prints where it must not")
    store.publish(task.output, "train", task.key, {"networks/yarn": values}, {"metrics": {"item": task.item}})
    return {"mean": float(values.mean())}


def _fail(fault: str, output: Path, values: np.ndarray) -> None:
    tries = output.with_suffix(".tries")
    tries.parent.mkdir(parents=True, exist_ok=True)
    with tries.open("a") as file:
        file.write("x")
    if fault == "data":
        raise DataError("twist of the fibre is 7, must be < 5; take another fibre")
    if fault == "error":
        raise RuntimeError("the wheel broke")
    if fault == "nan":
        values[1] = np.nan
    if fault == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if fault == "transient" and tries.stat().st_size < 3:
        raise KeyboardInterrupt
