"""Where Taichi starts: once a process, on the CPU or on a GPU."""

import contextlib
import os
from pathlib import Path

import taichi as ti
from taichi.lang import impl

from stages.simulate.kernels import light
from stages.spec import DataError

_started: list[tuple[int, str]] = []


def start_taichi(threads: int | None = None, device: str | None = None) -> int:
    """Initialise Taichi unless this process has already done so.

    Args:
        threads: CPU threads; None reads TI_CPU_MAX_NUM_THREADS, else takes every core this process may use.
            The result of a simulation does not depend on it.
        device: "cpu" or "gpu"; None is whichever runs, or the CPU.

    Returns:
        The number of threads in use.

    Raises:
        DataError: There is no GPU, or the process has started on the other device.
    """
    if not _started:
        before = _threads()
        wanted = threads or int(os.environ.get("TI_CPU_MAX_NUM_THREADS", "0")) or len(os.sched_getaffinity(0))
        ti.init(
            arch=ti.cuda if device == "gpu" else ti.cpu,
            cpu_max_num_threads=wanted,
            default_fp=ti.f64,
            offline_cache=True,
            fast_math=True,
            log_level=ti.ERROR,
            verbose=False,
        )
        found = "gpu" if impl.current_cfg().arch == ti.cuda else "cpu"
        light.serial = found == "cpu"
        if found == "cpu":
            _spread(_threads() - before, wanted)
        _started.append((wanted, found))
    running = _started[0][1]
    if device not in (None, running):
        none = device == "gpu" and not ti.lang.misc.is_arch_supported(ti.cuda)
        cause = "there is no GPU of CUDA here" if none else f"this process runs on the {running}"
        raise DataError(f'simulate.device is "{device}", but {cause}; set it to "{running}"')
    return _started[0][0]


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
