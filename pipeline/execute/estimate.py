"""What is left of a run, from the mean time that each stage took before."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pipeline.plan import PlannedTask

_TELLING = 0.05  # share of a task's steps from which its own pace tells more than the mean of others


class Estimate:
    """Mean wall time of a stage on a kind of item, learned from receipts and from the run itself."""

    def __init__(self) -> None:
        self._sums: dict[tuple[str, str], tuple[int, float]] = {}

    def add(self, stage: str, kind: str, wall_s: float) -> None:
        """One task of `stage` took `wall_s` [s]."""
        count, total = self._sums.get((stage, kind), (0, 0.0))
        self._sums[stage, kind] = (count + 1, total + wall_s)

    def left(self, tasks: Iterable[PlannedTask], running: Mapping[str, tuple[float, float]], jobs: int) -> str:
        """Time left as text, such as "about 2 min 05 s left".

        Args:
            tasks: Tasks not yet done.
            running: Name of a running task -> time that it has taken [s], share of its steps that is done [1].
            jobs: Tasks at a time.

        Returns:
            The text; "at least" if nothing is known of one of the tasks.
        """
        shared = alone = longest = 0.0
        unknown = False
        for task in tasks:
            cost = self._cost(task, *running.get(str(task), (0.0, 0.0)))
            unknown |= cost is None
            if task.kind == "dataset":
                alone += cost or 0.0
            else:
                shared += cost or 0.0
                longest = max(longest, cost or 0.0)
        seconds = max(shared / jobs, longest) + alone
        return f"{'at least' if unknown else 'about'} {clock(seconds)} left"

    def _cost(self, task: PlannedTask, elapsed_s: float, share: float) -> float | None:
        """Time [s] that `task` still takes, from its own pace if it has shown one; None if nothing is known."""
        if share > _TELLING:
            return elapsed_s * (1.0 - share) / share
        count, total = self._sums.get((task.stage, task.kind), (0, 0.0))
        return max(total / count - elapsed_s, 0.0) if count else None


def clock(seconds: float) -> str:
    """A time span for people: "0.4 s", "12 s", "3 min 05 s", "2 h 10 min"."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
