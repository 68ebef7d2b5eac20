"""The program that every stage is: `python -m stages.<name> --task T.json`, or `--worker` for many tasks in turn.

A worker reads one task file's path per line on standard input, and answers on standard output in JSON lines:
`{"progress": [done, total, label]}` while it works, then `{"code": exit code, "message": one line}`. Whatever else is
printed in it goes to standard error. It ends with its input, or with the process that started it.
"""

from __future__ import annotations

import argparse
import ctypes
import importlib
import json
import logging
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn, TextIO

from stages.runner import FAILED, NO_ROOM_LEFT, Interrupted, Outcome, RunFunction, run_task
from stages.spec import Progress, StageSpec, Task
from store import NoSpaceError

_REPORT_EVERY = 0.25  # [s] between progress reports
_SHOW_EVERY = 2.0  # [s] between lines of progress to a person
_PR_SET_PDEATHSIG = 1  # linux/prctl.h


def main(name: str, package: str = "stages") -> NoReturn:
    """Run stage `name` of `package` as a program; exits with the task's code, see `stages.runner`."""
    parser = argparse.ArgumentParser(prog=f"python -m {package}.{name}", description=f"Stage {name} of the mill.")
    mode = parser.add_mutually_exclusive_group(required=True)
    mode.add_argument("--task", type=Path, help="run the task in this JSON file, as written under OUTPUT/tasks")
    mode.add_argument("--worker", action="store_true", help="run the tasks whose files are named on standard input")
    given = parser.parse_args()
    logging.basicConfig(stream=sys.stderr, level=logging.INFO, format=f"%(asctime)s {name} %(levelname)s %(message)s")
    signal.signal(signal.SIGTERM, _interrupt)
    spec: StageSpec = importlib.import_module(f"{package}.{name}").SPEC

    def load() -> RunFunction:
        run: RunFunction = importlib.import_module(f"{package}.{name}.stage").run
        return run

    if given.worker:
        sys.exit(_serve(spec, load))
    outcome = _run_file(spec, load, given.task, _throttled(_show, _SHOW_EVERY))
    if outcome.message:
        print(outcome.message, file=sys.stderr)
    sys.exit(outcome.code)


def _serve(spec: StageSpec, load: Callable[[], RunFunction]) -> int:
    _die_with_parent()
    # Ctrl-C reaches the whole process group; the runner decides what becomes of its workers.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = _claim_stdout()

    def answer(message: dict[str, Any]) -> None:
        print(json.dumps(message), file=answers, flush=True)

    def report(done: float, total: float, label: str = "") -> None:
        answer({"progress": [float(done), float(total), label]})

    try:
        for line in sys.stdin:
            outcome = _run_file(spec, load, Path(line.rstrip("\n")), _throttled(report, _REPORT_EVERY))
            answer({"code": outcome.code, "message": outcome.message})
    except (Interrupted, BrokenPipeError):
        return 0
    return 0


def _run_file(spec: StageSpec, load: Callable[[], RunFunction], path: Path, progress: Progress) -> Outcome:
    try:
        task = Task.from_json(path.read_text())
    except (OSError, ValueError, TypeError) as error:
        return Outcome(FAILED, f"{path}: can't be read as a task ({error}); plan again to write it anew")
    try:
        return run_task(spec, load, task, progress)
    except NoSpaceError as error:  # of the receipt: the shard itself is there, and will be found
        return Outcome(NO_ROOM_LEFT, str(error))
    except OSError as error:
        return Outcome(FAILED, f"{task.stage}/{task.item}: {error}")


def _throttled(report: Progress, every: float) -> Progress:
    last = 0.0

    def progress(done: float, total: float, label: str = "") -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= every:
            last = now
            report(done, total, label)

    return progress


def _show(done: float, total: float, label: str = "") -> None:
    print(f"{done:g} of {total:g} {label}".rstrip(), file=sys.stderr)


def _interrupt(_signal: int, _frame: object) -> NoReturn:
    raise Interrupted


def _die_with_parent() -> None:
    """Have the kernel kill this process when the runner is killed, even by kill -9."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _claim_stdout() -> TextIO:
    """Keep standard output for answers; libraries that print there print to standard error instead."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return answers
