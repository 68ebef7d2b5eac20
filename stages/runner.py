"""Runs one task: calls the stage, checks what it published, leaves a receipt, and maps every failure to one line."""

from __future__ import annotations

import logging
import resource
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stages import receipt
from stages.key import document_of, key_of
from stages.receipt import Receipt
from stages.spec import DataError, Progress, StageSpec, Task
from store import NoSpaceError, ShardError
from store.check import peek
from store.errors import NO_ROOM

# Exit codes of a task, after sysexits.h where it has a name for the case.
PUBLISHED = 0
FAILED = 1  # a fault of the program: tried again twice
BAD_DATA = 65  # the item is at fault: quarantined, never tried again under this key
BAD_INPUT = 66  # a shard that the task reads can't be used: the user must see to it
NO_ROOM_LEFT = 74  # full disk: no other task will do better
TRANSIENT = 75  # interrupted or out of luck: tried again

RunFunction = Callable[[Task, Progress], dict[str, Any]]


@dataclass(frozen=True)
class Outcome:
    """How a task ended.

    Attributes:
        code: One of the exit codes above.
        message: One line; empty if it was published.
    """

    code: int
    message: str = ""


class Interrupted(BaseException):
    """The process was asked to stop."""


def run_task(spec: StageSpec, run: Callable[[], RunFunction], task: Task, progress: Progress) -> Outcome:
    """Run `task` with the stage's function, which `run` imports."""
    output = Path(task.output)
    document = document_of(spec, task)
    if task.stage != spec.name or key_of(document) != task.key:
        wanted = f"{spec.name} code_version {spec.code_version}, {document['schema']}"
        return Outcome(
            FAILED, f"{task.stage}/{task.item}: the task was planned for other code than {wanted}; plan again"
        )
    about: dict[str, Any] = {"stage": spec.name, "item": task.item, "key": task.key, "document": document}
    _forget_peak()
    start = time.monotonic()
    try:
        figures = run()(task, progress) or {}
        peek(output, spec.schema, task.key)
    except Exception as error:
        outcome = _outcome(task, output, error)
        if outcome.code == BAD_DATA:
            receipt.write(output, Receipt(**about, status=receipt.REJECTED, cause=outcome.message))
        return outcome
    except (Interrupted, KeyboardInterrupt):
        return Outcome(TRANSIENT, f"{task.stage}/{task.item}: interrupted")
    cost = {"wall_s": round(time.monotonic() - start, 3), "peak_bytes": _peak()}
    write_receipt(output, about, cost, figures)
    return Outcome(PUBLISHED)


def write_receipt(output: Path, about: dict[str, Any], cost: dict[str, Any], figures: dict[str, Any]) -> None:
    """Leave the receipt of what was published at `output`."""
    size, mtime_ns = receipt.fingerprint(output)
    digest = receipt.file_sha256(output)
    made = Receipt(
        **about, **cost, status=receipt.PUBLISHED, size=size, mtime_ns=mtime_ns, sha256=digest, figures=figures
    )
    receipt.write(output, made)


def _outcome(task: Task, output: Path, error: Exception) -> Outcome:
    name = f"{task.stage}/{task.item}"
    line = " ".join(str(error).split())
    if isinstance(error, NoSpaceError):
        return Outcome(NO_ROOM_LEFT, line)
    if isinstance(error, OSError) and error.errno in NO_ROOM:
        return Outcome(NO_ROOM_LEFT, f"{output}: no room to write it ({error.strerror}); free some space and run again")
    if isinstance(error, DataError):
        return Outcome(BAD_DATA, f"{name}: {line}")
    if isinstance(error, ShardError):
        # A result that its schema refuses (NaN, out of range) is the item's fault; any other shard is an input.
        return Outcome(BAD_DATA if error.path == output else BAD_INPUT, f"{name}: {line}")
    where = _log_traceback(output, task.item)
    return Outcome(FAILED, f"{name}: {type(error).__name__}: {line}{where}")


def _log_traceback(output: Path, item: str) -> str:
    """Append the traceback to a log beside the shard; returns "; see PATH"."""
    path = output.parent / "logs" / f"{item}.log"
    text = traceback.format_exc()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a") as log:
            log.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')}\n{text}\n")
    except OSError:
        logging.getLogger(__name__).error("%s", text)
        return ""
    return f"; see {path}"


def _forget_peak() -> None:
    """Start the peak of this process's memory anew, where the system can: workers run many tasks."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        logging.getLogger(__name__).debug("peak memory counts from the start of the process")


def _peak() -> int:
    """Peak resident memory [bytes] since `_forget_peak`."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    except OSError:
        logging.getLogger(__name__).debug("no /proc: peak memory is that of the whole process")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
