"""A whole run: plan, look at what is there, make what is missing, and say how it ended."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console

from pipeline import manifest
from pipeline.catalog import Catalog
from pipeline.errors import PipelineError
from pipeline.execute.display import Display
from pipeline.execute.estimate import Estimate
from pipeline.execute.local import LocalRunner
from pipeline.execute.schedule import Schedule
from pipeline.items import Item
from pipeline.manifest import DONE, FAULT, REJECTED, State
from pipeline.plan import Plan, PlannedTask, TaskName, make_plan, select
from pipeline.recipe import Recipe

Scan = dict[TaskName, State]


@dataclass
class Ending:
    """How a run ended.

    Attributes:
        plan: The last plan.
        published: Number of tasks that ran and published.
        found: Number of tasks found done.
        rejected: Task -> cause: bad data, now or in an earlier run.
        failed: Task -> cause.
        skipped: Task -> the task it waited for in vain.
        no_room: Where the disk is full; empty if it isn't.
        tolerated: Whether the rejections are within the recipe's share.
    """

    plan: Plan
    published: int = 0
    found: int = 0
    rejected: dict[TaskName, str] = field(default_factory=dict)
    failed: dict[TaskName, str] = field(default_factory=dict)
    skipped: dict[TaskName, TaskName] = field(default_factory=dict)
    no_room: str = ""
    tolerated: bool = True

    @property
    def good(self) -> bool:
        """Whether everything asked for is there, but for tolerated rejections."""
        return not self.failed and not self.no_room and self.tolerated


def current_plan(recipe: Recipe, catalog: Catalog, items: Sequence[Item]) -> tuple[Plan, Scan]:
    """The plan and the state of all its tasks; the dataset's own tasks leave out rejected items if these are few enough
    for the recipe."""
    plan = make_plan(recipe, catalog, items)
    states = manifest.scan(plan, plan.tasks.values())
    rejected = rejected_items(states)
    if rejected and _tolerated(recipe, items, rejected):
        plan = make_plan(recipe, catalog, items, rejected)
        states = manifest.scan(plan, plan.tasks.values())
    return plan, states


def rejected_items(states: Scan) -> set[str]:
    """Ids of the items that some stage rejected."""
    return {item for (_, item), state in states.items() if state.status == REJECTED}


def run(
    recipe: Recipe,
    catalog: Catalog,
    items: Sequence[Item],
    *,
    until: str | None,
    only: Sequence[str],
    jobs: int,
    console: Console,
    remedy: Callable[[PlannedTask], str],
) -> Ending:
    """Make what is missing of the tasks that `until` and `only` select.

    Args:
        recipe, catalog, items: What to make.
        until, only: See `pipeline.plan.select`.
        jobs: Tasks at a time.
        console: Where progress goes.
        remedy: Command that clears one task's result.

    Raises:
        PipelineError: A result that is there isn't what was published: nothing is run, nothing is touched.
    """
    plan, states = current_plan(recipe, catalog, items)
    chosen = select(plan, until, only)
    refuse_faults(chosen, states, remedy)
    ending = Ending(plan, found=sum(states[task.name].status == DONE for task in chosen))
    per_item = [task for task in chosen if task.kind != "dataset"]
    over_all = [task for task in chosen if task.kind == "dataset"]
    total = len(chosen) - ending.found
    with Display(console, total, _past_cost(plan, states), jobs) as display, LocalRunner(plan, jobs, display) as runner:
        display.later = [task for task in over_all if states[task.name].status != DONE]
        _run_part(ending, plan, states, per_item, runner)
        if ending.published or ending.rejected:
            # Training leaves out the items that were rejected, and its key says so.
            plan, states = current_plan(recipe, catalog, items)
            over_all = [plan.tasks[task.name] for task in over_all]
        display.later = []
        if not ending.no_room:
            _run_part(ending, plan, states, over_all, runner)
    return ending


def refuse_faults(tasks: Iterable[PlannedTask], states: Scan, remedy: Callable[[PlannedTask], str]) -> None:
    """Raise if a result that one of `tasks` needs isn't what was published.

    Raises:
        PipelineError: The first such, and how many more there are; one line.
    """
    faults = [task for task in tasks if states[task.name].status == FAULT]
    if faults:
        more = f" ({len(faults) - 1} more like it)" if len(faults) > 1 else ""
        raise PipelineError(f"{states[faults[0].name].reason}: {remedy(faults[0])}{more}")


def _run_part(ending: Ending, plan: Plan, states: Scan, tasks: Sequence[PlannedTask], runner: LocalRunner) -> None:
    """Run what is missing of `tasks` and enter the result in `ending`."""
    ending.plan = plan
    for task in tasks:
        if manifest.needs_receipt(plan, task, states[task.name]):
            manifest.adopt(plan, task)
    ending.rejected |= {t.name: states[t.name].reason for t in tasks if states[t.name].status == REJECTED}
    todo = [task for task in tasks if states[task.name].status not in (DONE, REJECTED)]
    asked = {task.name for task in todo}
    lost = {name for task in todo for name in task.inputs if name not in asked and states[name].status != DONE}
    schedule = Schedule(plan.catalog, todo, lost)
    runner.run(plan, schedule)
    ending.published += len(schedule.published)
    ending.rejected |= schedule.rejected
    ending.failed |= schedule.failed
    ending.skipped |= schedule.skipped
    ending.no_room = runner.no_room
    rejected = {item for _, item in ending.rejected}
    ending.tolerated = _tolerated(plan.recipe, list(plan.items.values()), rejected)


def _past_cost(plan: Plan, states: Scan) -> Estimate:
    """What tasks took before, as their receipts say."""
    estimate = Estimate()
    for (stage, item), state in states.items():
        if state.receipt is not None and state.receipt.wall_s:
            estimate.add(stage, plan.tasks[stage, item].kind, state.receipt.wall_s)
    return estimate


def _tolerated(recipe: Recipe, items: Sequence[Item], rejected: set[str]) -> bool:
    """Whether `rejected` is within the recipe's share of each kind of item."""
    for kind in {item.kind for item in items}:
        ids = {item.id for item in items if item.kind == kind}
        if len(ids & rejected) > recipe.dataset.tolerated_rejections * len(ids):
            return False
    return "all" not in rejected


def report_index(plan: Plan) -> Path | None:
    """The report's first page, if the plan has a report and it is there."""
    pages = [plan.output(task) / "index.html" for task in plan.tasks.values() if task.stage == "report"]
    return pages[0] if pages and pages[0].is_file() else None
