"""What the command line says: the table of status, the reasons, the end of a run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence

from pipeline.execute.estimate import clock
from pipeline.manifest import DONE, FAULT, MISSING, REJECTED, STALE, State
from pipeline.plan import Plan, PlannedTask, TaskName
from pipeline.run import Ending

_LISTED = 20  # tasks of one stage and state that are named before "and N more"


def table(plan: Plan, tasks: Sequence[PlannedTask], states: Mapping[TaskName, State]) -> list[str]:
    """One line a stage: how many tasks are done, missing, out of date, rejected or at fault, and what they took."""
    columns = (DONE, MISSING, STALE, REJECTED, FAULT)
    lines = [f"{plan.recipe.path} -> {plan.recipe.output}  ({_items(plan)})", ""]
    lines.append(f"{'stage':<10}" + "".join(f"{column:>10}" for column in columns) + f"{'time':>14}{'size':>12}")
    for stage in plan.catalog.specs:
        mine = [states[task.name] for task in tasks if task.stage == stage]
        if not mine:
            continue
        count = Counter(state.status for state in mine)
        made = [state.receipt for state in mine if state.status == DONE and state.receipt]
        took = clock(sum(receipt.wall_s for receipt in made)) if made else "-"
        size = f"{sum(receipt.size for receipt in made) / 1e6:.1f} MB" if made else "-"
        lines.append(f"{stage:<10}" + "".join(f"{count[c] or '-':>10}" for c in columns) + f"{took:>14}{size:>12}")
    return lines


def reasons(tasks: Iterable[PlannedTask], states: Mapping[TaskName, State]) -> list[str]:
    """Why each task that isn't done isn't, one line each; of many alike, the first ones."""
    lines: list[str] = []
    seen: Counter[tuple[str, str]] = Counter()
    for task in tasks:
        state = states[task.name]
        if state.status == DONE:
            continue
        group = (task.stage, state.status)
        seen[group] += 1
        if seen[group] <= _LISTED:
            lines.append(f"{task}: " + state.reason.removeprefix(f"{task}: "))
    lines += [f"{stage}: and {n - _LISTED} more {status}" for (stage, status), n in seen.items() if n > _LISTED]
    return ["", *lines] if lines else []


def ending(end: Ending, wall_s: float, clear: Callable[[PlannedTask], str]) -> list[str]:
    """What a run did, and what is at fault with its remedy."""
    if not end.published and end.good and not end.rejected:
        return [f"nothing to do: {_tasks(end.found)} up to date"]
    lines = [f"{_tasks(end.published)} published in {clock(wall_s)}, {end.found} up to date"]
    for name, cause in end.rejected.items():
        lines.append(f"rejected: {cause}")
        if not end.tolerated:
            lines.append(f"  it isn't tried again as it is; after a correction: {clear(end.plan.tasks[name])}")
    lines += [f"failed: {cause}" for cause in end.failed.values()]
    if end.skipped:
        causes = Counter(f"{stage}/{item}" for stage, item in end.skipped.values())
        waited = ", ".join(f"{count} for {cause}" for cause, count in causes.most_common(_LISTED))
        lines.append(f"skipped: {_tasks(len(end.skipped))}, waiting {waited}")
    return lines


def _items(plan: Plan) -> str:
    count = Counter(item.kind for item in plan.items.values())
    return ", ".join(f"{number} {kind}{'' if number == 1 else 's'}" for kind, number in count.items())


def _tasks(number: int) -> str:
    return f"{number} task{'' if number == 1 else 's'}"
