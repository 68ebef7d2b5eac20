"""Shows a run: bars with what is left on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn

from pipeline.execute.estimate import Estimate, clock
from pipeline.execute.schedule import Schedule
from pipeline.plan import PlannedTask

_LINE_EVERY = 10.0  # [s] between plain lines
_TERMINAL_EVERY = 1.0  # [s] between new estimates


class Display:
    """Progress of one run on `console`.

    Args:
        console: Where to write.
        total: Number of tasks to run.
        estimate: What tasks cost.
        jobs: Tasks at a time.

    Attributes:
        later: Tasks that the run comes to after the present schedule.
    """

    def __init__(self, console: Console, total: int, estimate: Estimate, jobs: int) -> None:
        self._console = console
        self._total = total
        self._estimate = estimate
        self._jobs = jobs
        self._done = 0
        self.later: Sequence[PlannedTask] = ()
        self._shown = time.monotonic()
        self._running: dict[str, tuple[float, float]] = {}  # start on the monotonic clock [s], share done
        self._bars: dict[str, TaskID] = {}
        columns = (
            TextColumn("{task.description:<32}", markup=False),
            BarColumn(bar_width=30),
            TextColumn("{task.fields[note]}", style="dim", markup=False),
        )
        self._progress = Progress(
            *columns, console=console, transient=True, disable=not (console.is_terminal and total)
        )
        self._overall = self._progress.add_task("all tasks", total=total, note="")

    def __enter__(self) -> Display:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def started(self, task: PlannedTask) -> None:
        """A worker took `task`."""
        self._running[str(task)] = (time.monotonic(), 0.0)
        self._bars[str(task)] = self._progress.add_task(f"  {task}", total=1.0, note="starts")

    def progress(self, task: PlannedTask, done: float, total: float, label: str = "") -> None:
        """`task` is at step `done` of `total`."""
        total = max(total, 1e-9)
        self._running[str(task)] = (self._running[str(task)][0], done / total)
        self._progress.update(self._bars[str(task)], completed=done, total=total, note=f"{done:g}/{total:g} {label}")

    def ended(self, task: PlannedTask, wall_s: float, fault: str, again: bool) -> None:
        """`task` ended after `wall_s` [s]; `fault` says how if it isn't published."""
        self._running.pop(str(task), None)
        self._progress.remove_task(self._bars.pop(str(task)))
        if not again:
            self._done += 1
            self._progress.update(self._overall, completed=self._done)
        if not fault:
            self._estimate.add(task.stage, task.kind, wall_s)
            if task.kind != "static":
                self._console.print(f"{task} published in {clock(wall_s)}", highlight=False)
            return
        end = "tried again" if again else "given up"
        self._console.print(f"[red]{end}[/red] ", end="")
        self._console.print(fault, markup=False, highlight=False, soft_wrap=True)

    def tick(self, schedule: Schedule) -> None:
        """Say what is left, now and then."""
        now = time.monotonic()
        if now - self._shown < (_TERMINAL_EVERY if self._console.is_terminal else _LINE_EVERY):
            return
        self._shown = now
        left = self._left([*schedule.left, *self.later])
        self._progress.update(self._overall, note=f"{self._done}/{self._total} {left}")
        if not self._console.is_terminal:
            running = ", ".join(f"{name} {share:.0%}" if share else name for name, (_, share) in self._running.items())
            self._console.print(f"{self._done}/{self._total} tasks; {left}; {running}", highlight=False)

    def _left(self, tasks: Iterable[PlannedTask]) -> str:
        now = time.monotonic()
        running = {name: (now - start, share) for name, (start, share) in self._running.items()}
        return self._estimate.left(tasks, running, self._jobs)
