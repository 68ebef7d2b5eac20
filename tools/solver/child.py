"""Runs a program and waits for it, up to a limit, so that what never ends is seen as such."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, sleep
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
"""The checkout, where `stages` and `tools` are."""
POLL = 0.05
"""Between looks at whether a program has ended [s]."""


@dataclass(frozen=True)
class Ended:
    """How a program ended.

    Attributes:
        code: Exit code; None if it was stopped at the limit.
        line: Its last line of output as JSON, empty if that is none.
        message: Its last line of errors.
        peak_mb: Its greatest memory [MB]; wall_s: how long it ran [s].
    """

    code: int | None
    line: dict[str, Any]
    message: str
    peak_mb: float
    wall_s: float

    @property
    def fault(self) -> str:
        """What went wrong, "" if nothing did."""
        if self.code is None:
            return f"still running after {self.wall_s:.0f} s, stopped"
        if self.code:
            return f"exit code {self.code}: {self.message}"
        return "" if self.line else "printed no result"


def run(command: Sequence[str | Path], limit: float, folder: Path = ROOT) -> Ended:
    """Run `command` in `folder` for at most `limit` [s]."""
    clock = perf_counter()
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        process = subprocess.Popen([str(part) for part in command], cwd=folder, stdout=out, stderr=err, text=True)
        code, peak = _wait(process, clock + limit)
        out.seek(0)
        err.seek(0)
        return Ended(code, _last_json(out.read()), _last_line(err.read()), peak, perf_counter() - clock)


def _wait(process: subprocess.Popen[str], until: float) -> tuple[int | None, float]:
    """Exit code, None if it had to be killed, and peak memory [MB] of a process."""
    stopped = False
    try:
        while True:
            done, status, usage = os.wait4(process.pid, os.WNOHANG)
            if done:
                process.returncode = os.waitstatus_to_exitcode(status)
                return None if stopped else process.returncode, usage.ru_maxrss / 1024
            if perf_counter() > until and not stopped:
                process.kill()
                stopped = True
            sleep(POLL)
    except BaseException:
        process.kill()
        raise


def _last_line(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[-1].strip() if lines else ""


def _last_json(text: str) -> dict[str, Any]:
    try:
        line = json.loads(_last_line(text))
    except ValueError:
        return {}
    return line if isinstance(line, dict) else {}
