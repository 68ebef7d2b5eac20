"""What is left of a run, from the mean time that each stage took before."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pipeline.plan import PlannedTask


class Estimate:
    """Mean wall time of a stage on a kind of item, learned from receipts and from the run itself."""

    def __init__(self) -> None:
        self._sums: dict[tuple[str, str], tuple[int, float]] = {}

    def add(self, stage: str, kind: str, wall_s: float) -> None:
        """One task of `stage` took `wall_s` [s]."""
        count, total = self._sums.get((stage, kind), (0, 0.0))
        self._sums[stage, kind] = (count + 1, total + wall_s)

    def left(self, tasks: Iterable[PlannedTask], fractions: Mapping[str, float], jobs: int) -> str:
        """Time left as text, such as "about 2 min left", for `tasks` of which some are done by `fractions` (name ->
        0..1), `jobs` at a time; "at least" if a stage was never seen."""
        shared = alone = longest = 0.0
        unknown = False
        for task in tasks:
            count, total = self._sums.get((task.stage, task.kind), (0, 0.0))
            unknown |= not count
            cost = (total / count if count else 0.0) * (1.0 - fractions.get(str(task), 0.0))
            if task.kind == "dataset":
                alone += cost
            else:
                shared += cost
                longest = max(longest, cost)
        seconds = max(shared / jobs, longest) + alone
        return f"{'at least' if unknown else 'about'} {clock(seconds)} left"


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
