"""What is done: receipts against the plan, and shards against their receipts.

The receipts are the only memory of a run, and they can be made again from the shards: there is no database to lose.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from pipeline.plan import Plan, PlannedTask, TaskName
from pipeline.reason import first_difference
from stages import receipt
from stages.receipt import Receipt
from stages.runner import write_receipt
from store import ShardError
from store.check import check, peek

DONE = "done"
STALE = "stale"  # there is a result, and it is out of date
MISSING = "missing"
REJECTED = "rejected"
FAULT = "fault"  # what is there isn't what was published: a person must look


@dataclass(frozen=True, slots=True)
class State:
    """What is known of one task.

    Attributes:
        status: DONE, STALE, MISSING, REJECTED or FAULT.
        reason: Why it isn't done, one line.
        receipt: Its last receipt.
    """

    status: str
    reason: str = ""
    receipt: Receipt | None = None


_UNMADE = State(MISSING, "not made yet")


def scan(plan: Plan, tasks: Iterable[PlannedTask], deep: bool = False) -> dict[TaskName, State]:
    """State of every task in `tasks`.

    Size and time of change of each shard are held against its receipt; a shard that differs is read and its checksums
    verified. With `deep`, every shard is.
    """
    states: dict[TaskName, State] = {}
    names: dict[str, tuple[frozenset[str], frozenset[str]]] = {}
    for task in tasks:
        if task.stage not in names:
            # Two listings a stage instead of a look for every task: there may be 150,000.
            folder = plan.recipe.output / task.stage
            names[task.stage] = (_names(folder), _names(folder / "receipts"))
        shards, receipts = names[task.stage]
        exists = f"{task.item}{plan.catalog[task.stage].suffix}" in shards
        noted = f"{task.item}.json" in receipts
        if not exists and not noted:
            states[task.name] = _UNMADE
            continue
        output = plan.output(task)
        made = receipt.load(receipt.receipt_path(output, task.item)) if noted else None
        states[task.name] = _state(plan, task, output, made, exists, deep)
    return states


def adopt(plan: Plan, task: PlannedTask) -> None:
    """Write the receipt that a shard lacks, or that doesn't know of its last copy or touch.

    Raises:
        ShardError: The shard isn't what the plan expects.
    """
    output = plan.output(task)
    check(output, plan.catalog[task.stage].schema, task.key)
    about = {"stage": task.stage, "item": task.item, "key": task.key, "document": plan.document(task)}
    old = receipt.load(receipt.receipt_path(output, task.item))
    kept = old if old is not None and old.key == task.key and old.status == receipt.PUBLISHED else None
    cost = {"wall_s": kept.wall_s, "peak_bytes": kept.peak_bytes} if kept else {}
    write_receipt(output, about, cost, kept.figures if kept else {})


def needs_receipt(plan: Plan, task: PlannedTask, state: State) -> bool:
    """Whether a task that is done lacks a receipt of its shard as it is now."""
    if state.status != DONE:
        return False
    made = state.receipt
    return made is None or made.key != task.key or (made.size, made.mtime_ns) != receipt.fingerprint(plan.output(task))


def _names(folder: Path) -> frozenset[str]:
    return frozenset(path.name for path in folder.iterdir()) if folder.is_dir() else frozenset()


def _state(plan: Plan, task: PlannedTask, output: Path, made: Receipt | None, exists: bool, deep: bool) -> State:
    schema = plan.catalog[task.stage].schema
    if made is None or made.key != task.key:
        return _without_receipt(plan, task, output, made, exists)
    if made.status == receipt.REJECTED:
        return State(REJECTED, made.cause, made)
    if not exists:
        return State(MISSING, "its shard is gone", made)
    try:
        touched = receipt.fingerprint(output) != (made.size, made.mtime_ns)
        if deep or (touched and receipt.file_sha256(output) != made.sha256):
            check(output, schema, task.key)
        elif output.is_dir():
            peek(output, schema, task.key)
    except (ShardError, OSError) as error:
        return State(FAULT, str(error), made)
    return State(DONE, "", made)


def _without_receipt(plan: Plan, task: PlannedTask, output: Path, made: Receipt | None, exists: bool) -> State:
    """A kill between a shard and its receipt leaves the shard alone: it counts if it is whole and has the key."""
    if not exists:
        return State(STALE, _why(plan, task, made), made)
    schema = plan.catalog[task.stage].schema
    try:
        header = peek(output)
        if header.schema == schema and header.key == task.key:
            check(output, schema, task.key)
            return State(DONE, "", made)
    except ShardError as error:
        # Under another schema version a shard is out of date as under any other change: the receipt knows which.
        return State(STALE, _why(plan, task, made), made) if made else State(FAULT, str(error), made)
    return State(STALE, _why(plan, task, made), made)


def _why(plan: Plan, task: PlannedTask, made: Receipt | None) -> str:
    if made is None:
        return "made under another key, and its receipt is gone"
    return first_difference(made.document, plan.document(task)) or "made under another key"
