"""Which task is next: inputs first, then what the end of the run waits for longest."""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterable

from pipeline.catalog import Catalog
from pipeline.plan import PlannedTask, TaskName

_RETRIES = 2  # of a failure that may not come back
_TRANSIENT_RETRIES = 5  # of an interruption


class Schedule:
    """Tasks to run, and what became of them.

    A task is ready once every input among `todo` is published. Sequences go first, since simulation is the long pole,
    and their later stages before the earlier ones, so that the first sequence reaches the simulation soon. Static
    people go stage by stage, which lets workers stay with their stage.

    Attributes:
        running: Tasks handed out and not yet settled.
        published: Tasks that ended well.
        rejected: Task -> cause, for bad data.
        failed: Task -> cause, for everything else.
        skipped: Task -> the task that it waited for in vain.
    """

    def __init__(self, catalog: Catalog, todo: Iterable[PlannedTask], lost: Iterable[TaskName] = ()) -> None:
        self._tasks = {task.name: task for task in todo}
        self._rank = {stage: rank for rank, stage in enumerate(catalog.specs)}
        self._position = {name: position for position, name in enumerate(self._tasks)}
        self._waits: dict[TaskName, int] = {}
        self._readers: dict[TaskName, list[TaskName]] = {}
        self._unsettled = Counter(task.stage for task in self._tasks.values())
        self._ready: list[tuple[tuple[bool, int, int], TaskName]] = []
        self._tries: dict[TaskName, int] = {}
        self.running: set[TaskName] = set()
        self.published: set[TaskName] = set()
        self.rejected: dict[TaskName, str] = {}
        self.failed: dict[TaskName, str] = {}
        self.skipped: dict[TaskName, TaskName] = {}
        for task in self._tasks.values():
            waits = [name for name in task.inputs if name in self._tasks]
            self._waits[task.name] = len(waits)
            for name in waits:
                self._readers.setdefault(name, []).append(task.name)
            if not waits:
                self._push(task.name)
        missing = set(lost)
        for task in self._tasks.values():
            gone = next((name for name in task.inputs if name in missing), None)
            if gone is not None:
                self._skip(task.name, gone)

    @property
    def left(self) -> list[PlannedTask]:
        """Tasks not yet settled, running ones among them."""
        settled = (self.published, self.rejected, self.failed, self.skipped)
        return [task for name, task in self._tasks.items() if not any(name in group for group in settled)]

    @property
    def stages_left(self) -> set[str]:
        """Stages of the tasks not yet settled."""
        return {stage for stage, count in self._unsettled.items() if count}

    def next(self) -> PlannedTask | None:
        """Hand out the most urgent ready task, or None if none is ready."""
        while self._ready:
            _, name = heapq.heappop(self._ready)
            if name not in self.skipped:
                self.running.add(name)
                return self._tasks[name]
        return None

    def publish(self, task: PlannedTask) -> None:
        """`task` is published: its readers may become ready."""
        self.running.discard(task.name)
        self.published.add(task.name)
        self._unsettled[task.stage] -= 1
        for reader in self._readers.get(task.name, ()):
            self._waits[reader] -= 1
            if not self._waits[reader]:
                self._push(reader)

    def reject(self, task: PlannedTask, cause: str) -> None:
        """`task` has bad data: what reads it is skipped."""
        self.rejected[task.name] = cause
        self._drop(task)

    def fail(self, task: PlannedTask, cause: str, *, transient: bool = False, final: bool = False) -> bool:
        """`task` failed; returns whether it will be tried again. What reads it is skipped if not."""
        tries = self._tries[task.name] = self._tries.get(task.name, 0) + 1
        if not final and tries <= (_TRANSIENT_RETRIES if transient else _RETRIES):
            self.running.discard(task.name)
            self._push(task.name)
            return True
        self.failed[task.name] = cause
        self._drop(task)
        return False

    def _push(self, name: TaskName) -> None:
        task = self._tasks[name]
        rank = self._rank[task.stage]
        urgency = (task.kind != "sequence", -rank if task.kind == "sequence" else rank, self._position[name])
        heapq.heappush(self._ready, (urgency, name))

    def _drop(self, task: PlannedTask) -> None:
        self.running.discard(task.name)
        self._unsettled[task.stage] -= 1
        for reader in self._readers.get(task.name, ()):
            self._skip(reader, task.name)

    def _skip(self, name: TaskName, cause: TaskName) -> None:
        stack = [name]
        while stack:
            one = stack.pop()
            if one not in self.skipped:
                self.skipped[one] = cause
                self._unsettled[one[0]] -= 1
                stack += self._readers.get(one, ())
