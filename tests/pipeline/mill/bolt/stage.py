"""Rolls all cloth up."""

from pathlib import Path
from typing import Any

import store
from stages.spec import Progress, Task


def run(task: Task, progress: Progress) -> dict[str, Any]:
    """Publish one line an item."""
    lines = [f"{task.config['title']}"]
    for stage, items in task.inputs.items():
        for item, entry in items.items():
            shard = store.read(entry["path"], "train", entry["key"])
            lines.append(f"{stage}/{item} {task.params['items'][item]['split']} {shard[next(iter(shard))].sum():.6f}")

    def build(folder: Path) -> None:
        (folder / "index.html").write_text("\n".join(lines))

    store.publish_folder(task.output, task.key, build)
    return {"lines": len(lines)}
