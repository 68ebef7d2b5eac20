"""Where Taichi starts: once a process, on the CPU."""

import os

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
        _started.append(wanted)
    return _started[0]
