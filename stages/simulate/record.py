"""What a run says of itself beside its positions: counts of the solver's work, and the memory it took."""

from __future__ import annotations

import re
import resource
from pathlib import Path

from stages.simulate.stepper import Report

_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def counts(report: Report) -> dict[str, float]:
    """Steps, those halved, those accepted while a vertex still moved by millimetres, iterations; contacts and pairs.

    The same at any number of threads. Contacts and pairs are means over the Newton iterations, each of which looks at
    them once.
    """
    looks = max(report.newton, 1)
    return {
        "steps": report.steps,
        "halvings": report.halvings,
        "unsolved": report.unsolved,
        "newton_iterations": report.newton,
        "linear_iterations": report.linear,
        "contacts": report.contacts / looks,
        "pairs": report.pairs / looks,
    }


def forget_peak() -> None:
    """Let `peak_memory_mb` count from now on, where the system can: a worker does many tasks in one process."""
    try:
        _RESET.write_text("5")  # proc(5): resets the high-water mark of resident memory
    except OSError:
        return


def peak_memory_mb() -> float:
    """Most resident memory of this process so far, or since `forget_peak` [MB]."""
    try:
        found = re.search(r"^VmHWM:\s+(\d+) kB", _STATUS.read_text(), re.MULTILINE)
    except OSError:
        found = None
    # Linux counts kB; the fallback may include what the process that started this one held.
    kilobytes = int(found[1]) if found else resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return kilobytes * 1.024e-3
