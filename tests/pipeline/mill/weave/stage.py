"""Weaves yarn."""

import time
from typing import Any

import store
from stages.spec import Progress, Task


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Publish the cloth of one item."""
    time.sleep(task.config["sleep_s"])
    path, key = task.input("yarn")
    values = store.read(path, "train", key)["networks/yarn"] * task.config["scale"]
    store.publish(task.output, "train", task.key, {"networks/cloth": values}, {"metrics": {}})
    return {}
