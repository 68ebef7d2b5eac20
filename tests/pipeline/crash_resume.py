"""kill -9 at random moments, then run again: only what was missing runs, and every byte is as without the kills."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from mill.bench import Mill

SLOW = "length = 5\nsleep_s = 0.15\n\n[weave]\nsleep_s = 0.3"


def _start(mill: Mill, *, group: bool = True) -> "subprocess.Popen[bytes]":
    """The runner as a process of its own, leading a process group of its own."""
    roots = [str(mill.catalog.root()), str(Path(__file__).parents[2])]
    return subprocess.Popen(
        [sys.executable, "-m", "mill", "run", str(mill.recipe), "--output", str(mill.output), "--jobs", "2"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(roots)},
        start_new_session=group,
        # Where the tests themselves are a shell's background job, an interrupt is ignored, and that is inherited.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def _wait_for(condition: "object", limit_s: float = 20.0) -> None:
    end = time.monotonic() + limit_s
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < end
        time.sleep(0.02)


def test_kills_at_random_moments_leave_no_trace(mill: Mill, tmp_path: Path) -> None:
    mill.edit("length = 5", SLOW)
    whole = Mill(tmp_path / "whole", mill.catalog, mill._read)
    whole.recipe.write_text(mill.recipe.read_text())
    assert whole("run")[0] == 0

    chance = random.Random(7)
    kept: dict[str, int] = {}
    killed = 0
    for _ in range(5):
        process = _start(mill)
        time.sleep(chance.uniform(0.3, 2.0))
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        killed += process.returncode == -signal.SIGKILL
        times = {str(path): path.stat().st_mtime_ns for path in mill.output.glob("*/*.h5")}
        assert kept.items() <= times.items(), "a published shard was made again"
        kept = times
    assert killed >= 2, "the kills came too late to test anything"
    assert mill("run")[0] == 0
    after = {str(path): path.stat().st_mtime_ns for path in mill.output.glob("*/*.h5")}
    assert kept.items() <= after.items()
    assert mill.shards() == whole.shards()
    assert not list(mill.output.rglob("*.tmp")) and not (mill.output / ".lock").exists()
    assert mill("run")[1] == "nothing to do: 11 tasks up to date\n"


def test_workers_die_with_a_killed_runner(mill: Mill) -> None:
    mill.edit("length = 5", "length = 5\nsleep_s = 30")
    process = _start(mill)
    runner = psutil.Process(process.pid)
    _wait_for(lambda: len(runner.children()) == 2)
    workers = runner.children()
    time.sleep(1.0)  # they are at work by now
    process.kill()  # the runner alone
    process.communicate()
    _wait_for(lambda: not any(worker.is_running() for worker in workers), 20.0)


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_the_run_in_one_line(mill: Mill, stop: signal.Signals) -> None:
    mill.edit("length = 5", "length = 5\nsleep_s = 120")
    process = _start(mill)
    runner = psutil.Process(process.pid)
    _wait_for(lambda: len(runner.children()) == 2)
    workers = runner.children()
    time.sleep(3.0)  # on a machine with other work, until both are at work
    os.killpg(process.pid, stop) if stop == signal.SIGINT else process.send_signal(stop)
    _, errors = process.communicate(timeout=80)
    assert process.returncode == 130
    assert errors.decode() == "interrupted; what is published stays, run again to go on\n"
    assert not any(worker.is_running() for worker in workers)
    assert not (mill.output / ".lock").exists() and not list(mill.output.rglob("*.tmp"))
