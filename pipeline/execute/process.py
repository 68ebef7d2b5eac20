"""One worker process: a stage's program that takes tasks in turn, so that imports and compilation are paid once."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.catalog import Catalog

_THREAD_SETTINGS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "TI_CPU_MAX_NUM_THREADS",
)


class WorkerProcess:
    """A running worker of one stage.

    Attributes:
        stage: Its stage.
        log: File that takes what it prints.
    """

    def __init__(self, catalog: Catalog, stage: str, threads: int, log: Path) -> None:
        self.stage = stage
        self.log = log
        self._rest = b""
        log.parent.mkdir(parents=True, exist_ok=True)
        with log.open("ab") as errors:
            # Never a fork of this process: a child forked from one that runs Taichi hangs.
            self._process = subprocess.Popen(
                [sys.executable, "-m", f"{catalog.package}.{stage}", "--worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                env=_environment(catalog, threads),
            )
        assert self._process.stdin is not None and self._process.stdout is not None
        self._stdin, self._stdout = self._process.stdin, self._process.stdout

    def fileno(self) -> int:
        """Descriptor on which answers arrive."""
        return self._stdout.fileno()

    def start(self, task_file: Path) -> None:
        """Hand over one task; the worker's death shows in `answers`."""
        try:
            self._stdin.write(f"{task_file.absolute()}\n".encode())
            self._stdin.flush()
        except BrokenPipeError:
            return

    def answers(self) -> Iterator[Mapping[str, Any]]:
        """Answers that have arrived; a last one with code None if the worker is gone."""
        content = os.read(self.fileno(), 1 << 16)
        if not content:
            yield {"code": None, "message": self._death()}
            return
        *lines, self._rest = (self._rest + content).split(b"\n")
        for line in lines:
            yield json.loads(line)

    def ask_to_stop(self) -> None:
        """Close its input, on which it ends when idle, and interrupt what it does."""
        try:
            self._stdin.close()
        except BrokenPipeError:
            return
        finally:
            if self._process.poll() is None:
                self._process.terminate()

    def stop(self, patience: float = 3.0) -> None:
        """Stop it; kill it after `patience` [s]."""
        self.ask_to_stop()
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._stdout.close()

    def _death(self) -> str:
        code = self._process.wait()
        if code >= 0:
            return f"its worker ended with exit code {code}; see {self.log}"
        name = signal.Signals(-code).name
        hint = ", perhaps for lack of memory: try fewer --jobs" if name == "SIGKILL" else ""
        return f"its worker was ended by {name}{hint}; see {self.log}"


def _environment(catalog: Catalog, threads: int) -> dict[str, str]:
    environment = dict(os.environ)
    environment |= {name: str(threads) for name in _THREAD_SETTINGS}
    paths = [str(catalog.root()), environment.get("PYTHONPATH", "")]
    environment["PYTHONPATH"] = os.pathsep.join(path for path in paths if path)
    return environment
