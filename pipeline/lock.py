"""One runner per output folder: a lock file that names its holder, and that a dead holder loses.

No flock: on network file systems it can hang or lie. The file appears by a hard link, with its whole content, or not.
"""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil

from pipeline.errors import PipelineError

_NAME = ".lock"
_START_TOLERANCE = 1.0  # [s] between two readings of one process's start


@contextmanager
def locked(output: Path) -> Iterator[None]:
    """Hold `output` for this process.

    Raises:
        PipelineError: Another runner holds it; names its pid and host.
    """
    output.mkdir(parents=True, exist_ok=True)
    lock = output / _NAME
    mine = _identity()
    _acquire(lock, mine)
    try:
        yield
    finally:
        if _read(lock) == mine:
            lock.unlink()


def holder(output: Path) -> str:
    """Who holds `output`, as "pid 12 on host"; empty if none that lives."""
    found = _read(output / _NAME)
    return "" if found is None or _is_dead(found) else _named(found)


def _acquire(lock: Path, mine: dict[str, Any]) -> None:
    fresh = lock.with_name(f"{_NAME}.{mine['host']}.{mine['pid']}.new")
    fresh.write_text(json.dumps(mine))
    try:
        while True:
            try:
                os.link(fresh, lock)
                return
            except FileExistsError:
                _remove_dead(lock, mine)
    finally:
        fresh.unlink()


def _remove_dead(lock: Path, mine: dict[str, Any]) -> None:
    """Move the lock away if its holder is dead; refuse otherwise."""
    found = _read(lock)
    if found is None:
        if lock.exists():
            raise PipelineError(f"{lock}: not a runner's lock; remove it if no runner works on {lock.parent}")
        return
    if not _is_dead(found):
        remedy = "wait for it, or stop it"
        if found["host"] != mine["host"]:
            remedy += f"; if it is dead, remove {lock}"
        raise PipelineError(f"{lock.parent}: another runner works on it, {_named(found)}; {remedy}")
    moved = lock.with_name(f"{_NAME}.{mine['host']}.{mine['pid']}.dead")
    try:
        lock.rename(moved)
    except FileNotFoundError:
        return  # a third runner was faster; look again
    taken = _read(moved)
    if taken != found and taken is not None:
        # Between the reading and the renaming a living runner took it over: give it back.
        os.link(moved, lock)
    moved.unlink()


def _identity() -> dict[str, Any]:
    process = psutil.Process()
    return {"pid": process.pid, "host": socket.gethostname(), "start": process.create_time()}


def _read(lock: Path) -> dict[str, Any] | None:
    try:
        found = json.loads(lock.read_text())
        return {"pid": int(found["pid"]), "host": str(found["host"]), "start": float(found["start"])}
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _is_dead(found: dict[str, Any]) -> bool:
    if found["host"] != socket.gethostname():
        return False  # can't be known from here
    try:
        process = psutil.Process(found["pid"])
        # A pid is used again after a while; the start tells the processes apart.
        same = abs(process.create_time() - found["start"]) < _START_TOLERANCE
        return not same or process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def _named(found: dict[str, Any]) -> str:
    return f"pid {found['pid']} on {found['host']}"
