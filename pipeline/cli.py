"""Command line of the mill: run, status, verify, clean."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

from rich.console import Console

from pipeline import summary
from pipeline.body_model import add_body_models
from pipeline.catalog import Catalog, load_catalog
from pipeline.clean import clean
from pipeline.errors import PipelineError
from pipeline.items import Item, collect
from pipeline.lock import holder, locked
from pipeline.manifest import FAULT, scan
from pipeline.motion import MotionFiles
from pipeline.outfit import add_outfits
from pipeline.plan import PlannedTask, make_plan, select
from pipeline.recipe import Recipe, load_recipe
from pipeline.run import current_plan, refuse_faults, report_index, run
from stages.runner import NO_ROOM_LEFT
from store import NoSpaceError
from store.atomic import remove_orphans
from store.errors import NO_ROOM

_INTERRUPTED = 130  # as shells report Ctrl-C


def main(arguments: Sequence[str] | None = None, catalog: Catalog | None = None) -> int:
    """Run one command; 0, or 1 with one line on stderr for what is at fault (74 for a full disk, 130 for Ctrl-C)."""
    given = _parser().parse_args(arguments)
    signal.signal(signal.SIGTERM, _terminate)
    try:
        command: Callable[[argparse.Namespace, Catalog], int] = given.command
        return command(given, load_catalog() if catalog is None else catalog)
    except PipelineError as error:
        return _fail(str(error), 1)
    except NoSpaceError as error:
        return _fail(str(error), NO_ROOM_LEFT)
    except KeyboardInterrupt:
        return _fail("interrupted; what is published stays, run again to go on", _INTERRUPTED)
    except OSError as error:
        if error.errno in NO_ROOM:
            return _fail(f"{error.filename}: {error.strerror}; free some space and run again", NO_ROOM_LEFT)
        return _fail(f"{error.filename or 'output'}: {error.strerror or error}; check the path and its rights", 1)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m pipeline", description="Make what a recipe asks for.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, function, text in (
        ("run", _run, "make what is missing or out of date"),
        ("status", _status, "show what is done and what a run would do"),
        ("verify", _verify, "verify every published shard to the last byte"),
        ("clean", _clean, "remove results, so that the next run makes them anew"),
    ):
        command = commands.add_parser(name, help=text, description=text)
        command.set_defaults(command=function)
        command.add_argument("recipe", type=Path)
        command.add_argument("--motion", type=Path, metavar="FILE", help="motion file for every sequence")
        command.add_argument("--frames", type=int, metavar="N", help="frames of every given sequence")
        command.add_argument("--output", type=Path, metavar="DIR", help="folder in place of the recipe's output")
        command.add_argument("--only", nargs="+", default=[], metavar="ID", help="only these items")
        if name == "clean":
            command.add_argument("--stage", nargs="+", default=[], metavar="STAGE", help="only these stages")
        else:
            command.add_argument("--until", metavar="STAGE", help="this stage and what it needs")
        if name == "run":
            command.add_argument("--jobs", type=int, default=0, metavar="N", help="tasks at a time (one a core)")
        if name == "status":
            command.add_argument("--why", action="store_true", help="say for each task why it would run")
    return parser


def _load(given: argparse.Namespace, catalog: Catalog) -> tuple[Recipe, list[Item]]:
    if given.frames is not None and given.frames < 1:
        raise PipelineError(f"--frames must be >= 1, got {given.frames}")
    recipe = load_recipe(given.recipe, catalog)
    output = given.output or recipe.output
    if given.motion is not None and given.output is None:
        output = output.with_name(f"{output.name}-{given.motion.stem}")
    recipe = Recipe(recipe.path, recipe.dataset, recipe.sections, output)
    motion_files = MotionFiles(output / "motions.json", getattr(recipe.sections.get("body"), "rate", 120.0))
    where = f"{recipe.path} [dataset]"
    items = collect(recipe.dataset, where, motion_files, motion=given.motion, frames=given.frames)
    motion_files.save()
    add_body_models(items, recipe.dataset.body_models, where, output / "bodies.json")
    add_outfits(items, recipe.dataset, recipe.sections.get("outfit"), where, output / "garments.json")
    return recipe, items


def _run(given: argparse.Namespace, catalog: Catalog) -> int:
    start = time.monotonic()
    jobs = given.jobs or len(os.sched_getaffinity(0))
    if jobs < 1:
        raise PipelineError(f"--jobs must be >= 1, got {jobs}")
    recipe, items = _load(given, catalog)
    console = Console(soft_wrap=True)
    with locked(recipe.output):
        remove_orphans(recipe.output)
        ending = run(
            recipe,
            catalog,
            items,
            until=given.until,
            only=given.only,
            jobs=jobs,
            console=console,
            remedy=lambda task: _clear_command(given, task),
        )
    for line in summary.ending(ending, time.monotonic() - start, lambda task: _clear_command(given, task)):
        print(line)
    index = report_index(ending.plan)
    if index is not None and not given.until and not given.only and ending.good:
        print(f"report: {index}")
    return NO_ROOM_LEFT if ending.no_room else 0 if ending.good else 1


def _status(given: argparse.Namespace, catalog: Catalog) -> int:
    recipe, items = _load(given, catalog)
    plan, states = current_plan(recipe, catalog, items)
    chosen = select(plan, given.until, given.only)
    for line in summary.table(plan, chosen, states):
        print(line)
    if running := holder(recipe.output):
        print(f"\na runner works on it: {running}")
    if given.why:
        for line in summary.reasons(chosen, states):
            print(line)
    refuse_faults(chosen, states, lambda task: _clear_command(given, task))
    return 0


def _verify(given: argparse.Namespace, catalog: Catalog) -> int:
    recipe, items = _load(given, catalog)
    plan, _ = current_plan(recipe, catalog, items)
    chosen = select(plan, given.until, given.only)
    states = scan(plan, chosen, deep=True)
    faults = [task for task in chosen if states[task.name].status == FAULT]
    for task in faults:
        print(f"{states[task.name].reason}: {_clear_command(given, task)}", file=sys.stderr)
    good = sum(states[task.name].status == "done" for task in chosen)
    print(
        f"{good} of {len(chosen)} shards verified, {len(faults)} at fault, {len(chosen) - good - len(faults)} not there"
    )
    return 1 if faults else 0


def _clean(given: argparse.Namespace, catalog: Catalog) -> int:
    if not given.only and not given.stage:
        raise PipelineError("clean needs --only ID or --stage STAGE: it says what to remove")
    recipe, items = _load(given, catalog)
    for stage in given.stage:
        catalog[stage]
    plan = make_plan(recipe, catalog, items)
    chosen = [task for task in select(plan, None, given.only) if not given.stage or task.stage in given.stage]
    with locked(recipe.output):
        removed = clean(plan, chosen)
    print(f"removed {removed} results; they are made anew by: {_command(given, 'run')}")
    return 0


def _clear_command(given: argparse.Namespace, task: PlannedTask) -> str:
    return f"{_command(given, 'clean')} --stage {task.stage} --only {task.item}"


def _command(given: argparse.Namespace, name: str) -> str:
    motion = f" --motion {given.motion}" if given.motion else ""
    frames = f" --frames {given.frames}" if given.frames else ""
    output = f" --output {given.output}" if given.output else ""
    return f"python -m pipeline {name} {given.recipe}{motion}{frames}{output}"


def _fail(message: str, code: int) -> int:
    print(message, file=sys.stderr)
    return code


def _terminate(_signal: int, _frame: object) -> NoReturn:
    raise KeyboardInterrupt
