"""Runs tasks on this machine: as many workers at a time as there are jobs, the machine's cores shared among them."""

from __future__ import annotations

import os
import selectors
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.execute.display import Display
from pipeline.execute.process import WorkerProcess
from pipeline.execute.schedule import Schedule
from pipeline.plan import Plan, PlannedTask
from stages.runner import BAD_DATA, BAD_INPUT, NO_ROOM_LEFT, PUBLISHED, TRANSIENT
from store.atomic import replace_file

_TICK = 0.5  # [s] between redrawings
_IDLE = 6  # workers kept waiting at least: starting one takes seconds, keeping it some 300 MB


@dataclass
class _Job:
    worker: WorkerProcess
    task: PlannedTask
    start: float


class LocalRunner:
    """Worker processes for one run; use it as a context, which stops them.

    Every stage has its own workers, kept between tasks. `jobs` tasks run at a time with cores / jobs threads each; a
    dataset's own task, such as training, has all cores.
    """

    def __init__(self, plan: Plan, jobs: int, display: Display) -> None:
        self._plan = plan
        self._jobs = jobs
        self._display = display
        self._cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        self._idle: list[WorkerProcess] = []  # least recently used first
        self._busy: dict[int, _Job] = {}
        self._started = 0
        self._selector = selectors.DefaultSelector()
        self.no_room = ""

    def __enter__(self) -> LocalRunner:
        return self

    def __exit__(self, *_: object) -> None:
        workers = [*self._idle, *(job.worker for job in self._busy.values())]
        for worker in workers:
            worker.ask_to_stop()
        for worker in workers:
            worker.stop()
        self._selector.close()

    def run(self, plan: Plan, schedule: Schedule) -> None:
        """Run `schedule` to its end, or until the disk is full; `no_room` then says where."""
        self._plan = plan
        while not self.no_room:
            while len(self._busy) < self._jobs and (task := schedule.next()) is not None:
                self._start(task)
            if not self._busy:
                return
            self._retire(schedule)
            for key, _ in self._selector.select(_TICK):
                self._hear(self._busy[key.fd], schedule)
            self._display.tick(schedule)

    def _start(self, task: PlannedTask) -> None:
        path = self._plan.task_file(task)
        replace_file(path, self._plan.to_task(task).to_json().encode())
        worker = next((w for w in reversed(self._idle) if w.stage == task.stage), None)
        if worker is None:
            if len(self._idle) >= max(self._jobs, _IDLE):
                self._idle.pop(0).stop()
            self._started += 1
            threads = self._cores if task.kind == "dataset" else max(1, self._cores // self._jobs)
            worker = WorkerProcess(self._plan.catalog, task.stage, threads, self._log(task.stage))
        else:
            self._idle.remove(worker)
        self._busy[worker.fileno()] = _Job(worker, task, time.monotonic())
        self._selector.register(worker, selectors.EVENT_READ)
        self._display.started(task)
        worker.start(path)

    def _hear(self, job: _Job, schedule: Schedule) -> None:
        for answer in job.worker.answers():
            if "progress" in answer:
                self._display.progress(job.task, *answer["progress"])
                continue
            self._selector.unregister(job.worker)
            del self._busy[job.worker.fileno()]
            if answer["code"] in (PUBLISHED, BAD_DATA):
                self._idle.append(job.worker)
            else:
                job.worker.stop()  # after a failure its memory can't be trusted
            self._settle(job, answer, schedule)

    def _settle(self, job: _Job, answer: Mapping[str, Any], schedule: Schedule) -> None:
        task, code = job.task, answer["code"]
        message = answer["message"] if code is not None else f"{task}: {answer['message']}"
        again = False
        if code == PUBLISHED:
            schedule.publish(task)
        elif code == BAD_DATA:
            schedule.reject(task, message)
        elif code == NO_ROOM_LEFT:
            self.no_room = message
            schedule.fail(task, message, final=True)
        else:
            again = schedule.fail(task, message, transient=code == TRANSIENT, final=code == BAD_INPUT)
        self._display.ended(task, time.monotonic() - job.start, "" if code == PUBLISHED else message, again)

    def _retire(self, schedule: Schedule) -> None:
        """Stop the idle workers of stages that have nothing left to do."""
        if not self._idle:
            return
        needed = schedule.stages_left
        for worker in [worker for worker in self._idle if worker.stage not in needed]:
            self._idle.remove(worker)
            worker.stop()

    def _log(self, stage: str) -> Path:
        return self._plan.recipe.output / stage / "logs" / f"worker_{self._started}.log"
