"""Where Taichi starts: once a process, on the CPU."""

import contextlib
import os
from pathlib import Path

import taichi as ti

_started: list[int] = []


def start_taichi(threads: int | None = None) -> int:
    """Initialise Taichi unless this process has already done so.

    Args:
        threads: CPU threads; None reads TI_CPU_MAX_NUM_THREADS, else takes every core this process may use.
            The result of a simulation does not depend on it.

    Returns:
        The number of threads in use.
    """
    if not _started:
        before = _threads()
        wanted = threads or int(os.environ.get("TI_CPU_MAX_NUM_THREADS", "0")) or len(os.sched_getaffinity(0))
        ti.init(
            arch=ti.cpu,
            cpu_max_num_threads=wanted,
            default_fp=ti.f64,
            offline_cache=True,
            fast_math=True,
            log_level=ti.ERROR,
            verbose=False,
        )
        _spread(_threads() - before, wanted)
        _started.append(wanted)
    return _started[0]


def _threads() -> set[int]:
    """The threads of this process, where the system tells."""
    tasks = Path("/proc/self/task")
    return {int(task.name) for task in tasks.iterdir()} if tasks.is_dir() else set()


def _spread(workers: set[int], wanted: int) -> None:
    """Give each of Taichi's `workers` a core of its own where it has as many as this process may use.

    Its loops last for tens of microseconds. Where cores share no cache, as on virtual machines, the system leaves both
    workers on the core of the thread that woke them, and two cores are no faster than one.
    """
    cores = sorted(os.sched_getaffinity(0))
    if wanted == len(cores) and len(workers) >= wanted:
        for worker, core in zip(sorted(workers)[-wanted:], cores):
            with contextlib.suppress(OSError):
                os.sched_setaffinity(worker, {core})
