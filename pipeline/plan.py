"""Recipe + stage specs -> tasks with keys, in the order in which data crosses the stages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.catalog import Catalog
from pipeline.errors import PipelineError
from pipeline.items import DATASET_ITEM, Item
from pipeline.recipe import Recipe
from stages.key import canonical, key_document, key_of
from stages.settings import suggestion
from stages.spec import StageSpec, Task, seed_of

TaskName = tuple[str, str]  # stage, item


@dataclass(frozen=True, slots=True)
class PlannedTask:
    """One task to be done or found done.

    Attributes:
        stage, item: Its name.
        kind: "sequence", "static" or "dataset".
        key: Key of its shard.
        seed: Seed of its generator.
        params: What its stage asks about the item; for a dataset's task, "items": item -> its kind and split.
        inputs: Tasks whose shards it reads.
    """

    stage: str
    item: str
    kind: str
    key: str
    seed: int
    params: dict[str, Any]
    inputs: tuple[TaskName, ...]

    @property
    def name(self) -> TaskName:
        """Stage and item."""
        return self.stage, self.item

    def __str__(self) -> str:
        return f"{self.stage}/{self.item}"


@dataclass
class Plan:
    """Every task of a recipe by name; inputs stand before the tasks that read them.

    Attributes:
        recipe: The recipe.
        catalog: The stages.
        items: The dataset's items by id.
        dropped: Items that the dataset's own tasks (training, report) leave out, as they were rejected.
        tasks: Name -> task.
    """

    recipe: Recipe
    catalog: Catalog
    items: dict[str, Item]
    dropped: frozenset[str] = frozenset()
    tasks: dict[TaskName, PlannedTask] = field(default_factory=dict)

    def output(self, task: PlannedTask) -> Path:
        """Where `task` publishes."""
        return self.recipe.output / task.stage / f"{task.item}{self.catalog[task.stage].suffix}"

    def task_file(self, task: PlannedTask) -> Path:
        """Where the runner writes `task` for a worker, or for a person who wants to run it by hand."""
        return self.recipe.output / "tasks" / task.stage / f"{task.item}.json"

    def document(self, task: PlannedTask) -> dict[str, Any]:
        """Key document of `task`."""
        return _document(self, self.catalog[task.stage], task.item, task.params, task.seed, task.inputs)

    def to_task(self, task: PlannedTask) -> Task:
        """All that a worker needs for `task`."""
        inputs: dict[str, dict[str, dict[str, str]]] = {}
        for stage, item in task.inputs:
            made = self.tasks[stage, item]
            inputs.setdefault(stage, {})[item] = {"path": str(self.output(made).absolute()), "key": made.key}
        return Task(
            stage=task.stage,
            item=task.item,
            kind=task.kind,
            key=task.key,
            seed=task.seed,
            config=self.recipe.plain_section(task.stage),
            params=task.params,
            inputs=inputs,
            output=str(self.output(task).absolute()),
        )


def make_plan(recipe: Recipe, catalog: Catalog, items: Iterable[Item], dropped: Iterable[str] = ()) -> Plan:
    """Plan every task of `recipe` on `items`; the dataset's own tasks leave out the items in `dropped`."""
    plan = Plan(recipe, catalog, {item.id: item for item in items}, frozenset(dropped))
    for stage, spec in catalog.specs.items():
        section = recipe.plain_section(stage)
        written = canonical(section)
        for item, kind, params in _subjects(plan, spec):
            inputs = tuple(_inputs(plan, spec, item))
            seed = seed_of(recipe.dataset.seed, stage, item)
            document = _document(plan, spec, item, params, seed, inputs, section)
            plan.tasks[stage, item] = PlannedTask(stage, item, kind, key_of(document, written), seed, params, inputs)
    return plan


def select(plan: Plan, until: str | None = None, only: Iterable[str] = ()) -> list[PlannedTask]:
    """The tasks that a run with `--until` and `--only` is about, in the plan's order.

    Args:
        plan: The plan.
        until: Stage to reach, with all that it needs; None for all stages.
        only: Ids of items; the dataset's own tasks are then left out. Empty for all.

    Raises:
        PipelineError: An unknown stage or item; one line.
    """
    stages = plan.catalog.closure(until) if until else list(plan.catalog.specs)
    chosen = set(only)
    for item in sorted(chosen):
        if item not in plan.items and item != DATASET_ITEM:
            raise PipelineError(f"{plan.recipe.path}: there is no item {item!r}; {suggestion(item, plan.items)}")
    return [t for t in plan.tasks.values() if t.stage in stages and (not chosen or t.item in chosen)]


def _subjects(plan: Plan, spec: StageSpec) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Item, kind and parameters of every task of one stage."""
    if spec.scope == "dataset":
        kept = [item for item in plan.items.values() if item.id not in plan.dropped and item.kind in spec.kinds]
        items = {item.id: {"kind": item.kind, "split": item.params["split"]} for item in kept}
        params: dict[str, Any] = {"items": items} if "items" in spec.params else {}
        yield DATASET_ITEM, "dataset", params
        return
    for item in plan.items.values():
        if item.kind in spec.kinds:
            yield item.id, item.kind, {name: item.params[name] for name in spec.params if name in item.params}


def _inputs(plan: Plan, spec: StageSpec, item: str) -> Iterator[TaskName]:
    for need in spec.needs:
        if plan.catalog[need].scope == "dataset":
            yield need, DATASET_ITEM
        elif spec.scope != "dataset":
            if (need, item) in plan.tasks:  # a static person isn't simulated, for one
                yield need, item
        else:
            for other in plan.items.values():
                if (need, other.id) in plan.tasks and other.id not in plan.dropped and other.kind in spec.kinds:
                    yield need, other.id


def _document(
    plan: Plan,
    spec: StageSpec,
    item: str,
    params: dict[str, Any],
    seed: int,
    names: Iterable[TaskName],
    config: dict[str, Any] | None = None,
) -> dict[str, Any]:
    inputs: dict[str, dict[str, str]] = {}
    for stage, source in names:
        inputs.setdefault(stage, {})[source] = plan.tasks[stage, source].key
    config = plan.recipe.plain_section(spec.name) if config is None else config
    return key_document(spec, config=config, params=params, inputs=inputs, item=item, seed=seed)
