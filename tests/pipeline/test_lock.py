"""One runner per output: the living keep it, the dead lose it."""

import json
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.errors import PipelineError
from pipeline.lock import holder, locked

_HOLD = """
import sys, time
from pathlib import Path
from pipeline.lock import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def other(tmp_path: Path) -> "subprocess.Popen[str]":
    """Another process that holds `tmp_path`."""
    process = subprocess.Popen([sys.executable, "-c", _HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.wait()


def test_a_second_runner_is_refused_in_one_line(tmp_path: Path, other: "subprocess.Popen[str]") -> None:
    with pytest.raises(PipelineError) as caught, locked(tmp_path):
        pass
    line = f"{tmp_path}: another runner works on it, pid {other.pid} on {socket.gethostname()}; wait for it, or stop it"
    assert str(caught.value) == line
    assert holder(tmp_path) == f"pid {other.pid} on {socket.gethostname()}"


def test_a_killed_runner_loses_the_lock(tmp_path: Path, other: "subprocess.Popen[str]") -> None:
    other.send_signal(signal.SIGKILL)
    other.wait()
    assert (tmp_path / ".lock").exists() and holder(tmp_path) == ""
    with locked(tmp_path):
        assert holder(tmp_path).startswith(f"pid {os.getpid()} ")
    assert list(tmp_path.iterdir()) == []


def test_a_pid_used_again_is_not_the_holder(tmp_path: Path) -> None:
    said = {"pid": os.getpid(), "host": socket.gethostname(), "start": 1.0}
    (tmp_path / ".lock").write_text(json.dumps(said))
    with locked(tmp_path):
        pass


def test_a_holder_on_another_host_is_believed(tmp_path: Path) -> None:
    (tmp_path / ".lock").write_text(json.dumps({"pid": 1, "host": "node7", "start": 1.0}))
    with pytest.raises(PipelineError, match=r"pid 1 on node7; wait for it, or stop it; if it is dead, remove .*\.lock"):
        locked(tmp_path).__enter__()


def test_a_strange_lock_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / ".lock").write_text("mine")
    with pytest.raises(PipelineError, match="not a runner's lock; remove it if"):
        locked(tmp_path).__enter__()
    assert (tmp_path / ".lock").read_text() == "mine"


def test_the_lock_goes_when_the_run_fails(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="broke"), locked(tmp_path):
        raise RuntimeError("broke")
    assert list(tmp_path.iterdir()) == []
