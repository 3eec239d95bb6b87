"""Long work in other processes: started, told about, cancelled, and never the end of the studio."""

from __future__ import annotations

import json
import logging
import re
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from typing import Any, Self

from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.studio.blobs import Blobs
from henkei.studio.messages import Message
from henkei.studio.outcomes import (
    Cancelled,
    Done,
    Failed,
    Outcome,
    Refused,
    Running,
    Task,
    died,
    told,
)
from henkei.studio.processes import Process
from henkei.studio.restriction import half_of_memory

__all__ = ["Cancelled", "Done", "Failed", "Jobs", "Outcome", "Refused", "Running", "Task"]

TASKS = ("henkei.studio.tasks.",)
"""Where tasks are looked for."""
FUNCTION = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*", re.ASCII)
PATIENCE = 1.5  # seconds that a cancelled task has to stop by itself
RESTRICTED_SECONDS = 60.0
FIRST_WARM_UP = 1.0  # seconds that the studio has for its first page before a worker is warmed up
NEXT_WARM_UP = 10.0  # seconds, after one did not come to work
MOST_TRIES = 2
MOST_RESTRICTED = 1
WAITING = "waiting"
NO_PROCESS = (
    "no process could be started for this work; close other programs, or start the studio again"
)

log = logging.getLogger(__name__)

OnProgress = Callable[[str, str, float], None]
OnSnapshot = Callable[[str, dict[str, Any], dict[str, NDArray[Any]]], None]
OnEnd = Callable[[str, Outcome], None]
Step = Callable[[], None]


@dataclass(eq=False)
class _Job:
    id: str
    task: bytes
    title: str
    on_progress: OnProgress
    on_snapshot: OnSnapshot
    on_end: OnEnd
    limit_seconds: float | None
    restricted: bool
    message: str = ""
    fraction: float = 0.0
    tries: int = 0
    started: bool = False
    cancelled: bool = False
    overdue: bool = False
    overdue_at: float = inf
    killed_at: float = inf


@dataclass(eq=False)
class _Worker:
    process: Process
    ready: bool = False
    spent: bool = False
    job: _Job | None = None


def _ignored(*_: object) -> None:
    """For what nobody asked about."""


class Jobs:
    """Runs tasks in worker processes; all methods may be called from any thread.

    Callbacks come on threads of this object, for one job one after the other: any number of
    ``on_progress(job, message, fraction)`` and ``on_snapshot(job, header, arrays)``, then exactly
    one ``on_end(job, outcome)``. They must be quick, and not wait for this object.

    Parameters
    ----------
    folder : of the blobs.
    workers : how many ordinary jobs run at a time; others wait. A restricted one beside them
        does not wait for them, only for other restricted ones.
    memory : bytes that a job may take; None for no limit, and for half of the machine's memory in
        a restricted one.
    idle : how many processes are started ahead of the next job, with henkei imported; with 0, one
        that has done a job is still kept for the next.
    allowed : starts of names of the modules that tasks may be in.
    """

    def __init__(
        self,
        folder: Path,
        *,
        workers: int = 2,
        memory: int | None = None,
        idle: int = 1,
        allowed: tuple[str, ...] = TASKS,
    ) -> None:
        self._blobs = Blobs(folder)
        self._folder = folder
        self._most, self._memory, self._idle, self._allowed = workers, memory, idle, allowed
        self._changed = threading.Condition()
        self._queue: list[_Job] = []
        self._workers: list[_Worker] = []
        self._count = 0
        self._stillborn = 0  # processes that ended before they were ready, one after the other
        self._warm_from = time.monotonic() + FIRST_WARM_UP
        self._closing = False
        self._minder = threading.Thread(target=self._mind, name="henkei-jobs", daemon=True)
        self._minder.start()

    def start(
        self,
        task: Task,
        *,
        title: str,
        on_end: OnEnd,
        on_progress: OnProgress = _ignored,
        on_snapshot: OnSnapshot = _ignored,
        limit_seconds: float | None = None,
        restricted: bool = False,
    ) -> str:
        """Do a task as soon as a worker is free for it; returns the id of the job.

        Parameters
        ----------
        title : what it is, for people.
        limit_seconds : how long it may run; then it is killed and refused.
        restricted : it reads what a stranger made: it can write nothing but blobs (which go through
            this process), read nothing but ``task.reads``, and not compute or grow without end.

        Raises
        ------
        InvalidInput : the function is not one of the allowed, or the jobs are closed.
        """
        function = task.function
        if not FUNCTION.fullmatch(function) or not function.startswith(self._allowed):
            raise InvalidInput(f"{function!r} is no task; tasks are in {', '.join(self._allowed)}")
        data = json.dumps(vars(task)).encode()
        if restricted and limit_seconds is None:
            limit_seconds = RESTRICTED_SECONDS
        with self._changed:
            if self._closing:
                raise InvalidInput("the studio is closing and starts no more work")
            self._count += 1
            job = _Job(
                f"j{self._count}", data, title, on_progress, on_snapshot, on_end, limit_seconds,
                restricted,
            )  # fmt: skip
            self._queue.append(job)
            self._changed.notify()
        return job.id

    def cancel(self, job: str) -> None:
        """Stop a job: its next progress raises, and soon its process is killed. It ends as
        :class:`Cancelled` whatever comes first; a job that has ended is left alone."""
        with self._changed:
            for worker in self._workers:
                if worker.job is not None and worker.job.id == job and not worker.job.cancelled:
                    worker.job.cancelled = True
                    worker.job.killed_at = time.monotonic() + PATIENCE
                    worker.process.order({"kind": "cancel", "job": job})
            for waiting in self._queue:
                waiting.cancelled |= waiting.id == job
            self._changed.notify()

    @property
    def running(self) -> list[Running]:
        """The jobs that have not ended, in the order in which they came."""
        with self._changed:
            jobs = [(worker.job, False) for worker in self._workers if worker.job is not None]
            jobs += [(job, True) for job in self._queue]
            ordered = sorted(jobs, key=lambda entry: int(entry[0].id[1:]))
            return [Running(j.id, j.title, j.message, j.fraction, w) for j, w in ordered]

    def close(self) -> None:
        """End all jobs as :class:`Cancelled`, and all processes; nothing of them is left."""
        with self._changed:
            self._closing = True
            self._changed.notify()
            waiting, self._queue = self._queue, []
        if threading.current_thread() is not self._minder:
            self._minder.join()
        for job in waiting:
            self._end(job, Cancelled())
        with self._changed:
            processes = [worker.process for worker in self._workers]
        for process in processes:
            process.kill()
        for process in processes:
            if process.thread is not threading.current_thread():
                process.thread.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _mind(self) -> None:
        """Give work to workers, and see to it that there are enough and none outstays its time."""
        while True:
            with self._changed:
                if self._closing:
                    return
                self._kill_overdue()
                steps = [*self._dismissed(), *self._given()]
                if not steps:
                    self._changed.wait(self._pause())
                    continue
            for step in steps:
                self._tell(step)

    def _kill_overdue(self) -> None:
        now = time.monotonic()
        for worker in self._workers:
            job = worker.job
            if job is not None and now >= min(job.overdue_at, job.killed_at):
                job.overdue = now >= job.overdue_at
                job.overdue_at = job.killed_at = inf
                worker.process.kill()

    def _dismissed(self) -> Iterator[Step]:
        """Ends of the waiting jobs that were cancelled, or that no process can be had for."""
        for job in list(self._queue):
            if job.cancelled or self._stillborn >= MOST_TRIES:
                self._queue.remove(job)
                outcome = Cancelled() if job.cancelled else Failed(NO_PROCESS)
                yield partial(self._end, job, outcome)
        if self._stillborn >= MOST_TRIES:
            self._stillborn = 0

    def _given(self) -> Iterator[Step]:
        """Waiting jobs to ready workers; starts the processes that are still needed for them."""
        running = [worker.job for worker in self._workers if worker.job is not None]
        free = {False: self._most, True: MOST_RESTRICTED}
        for job in running:
            free[job.restricted] -= 1
        spare = [w for w in self._workers if w.job is None and not w.spent]
        ready = [worker for worker in spare if worker.ready]
        wanted = self._idle if time.monotonic() >= self._warm_from else 0
        for job in list(self._queue):
            if not free[job.restricted]:
                if not job.message:
                    job.message = WAITING
                    yield partial(self._tell, job.on_progress, job.id, WAITING, 0.0)
                continue
            free[job.restricted] -= 1
            if not ready:
                wanted += 1
                continue
            worker = ready.pop(0)
            spare.remove(worker)
            self._queue.remove(job)
            worker.job = job
            job.tries += 1
            if job.limit_seconds is not None:
                job.overdue_at = time.monotonic() + job.limit_seconds
            yield partial(worker.process.order, self._order(job), job.task)
        for _ in range(wanted - len(spare)):
            if not self._hire():
                yield _ignored
        for worker in ready[max(self._idle, 1) :]:
            worker.spent = True
            worker.process.kill()

    def _order(self, job: _Job) -> dict[str, Any]:
        memory = self._memory
        if memory is None and job.restricted:
            memory = half_of_memory()
        return {
            "kind": "task",
            "job": job.id,
            "restricted": job.restricted,
            "memory": memory,
            "seconds": job.limit_seconds,
        }

    def _hire(self) -> bool:
        """Start a process; False if the system does not."""
        try:
            process = Process(self._folder, self._heard, self._ended)
        except OSError as error:
            log.error("no worker process could be started: %s", error)
            self._lost()
            return False
        self._workers.append(_Worker(process))
        return True

    def _lost(self) -> None:
        """A process did not come to work; the next is started after a while."""
        self._stillborn += 1
        self._warm_from = time.monotonic() + NEXT_WARM_UP

    def _pause(self) -> float | None:
        """Seconds until something is to be done if nothing happens."""
        times = [self._warm_from] if self._warm_from > time.monotonic() else []
        for worker in self._workers:
            if worker.job is not None:
                times += [worker.job.overdue_at, worker.job.killed_at]
        soonest = min(times, default=inf)
        return None if soonest == inf else max(soonest - time.monotonic(), 0.0)

    def _worker(self, process: Process) -> _Worker:
        return next(worker for worker in self._workers if worker.process is process)

    def _heard(self, process: Process, message: Message) -> None:
        """Take a message of a worker, on the thread of its process."""
        header = message.header
        with self._changed:
            worker = self._worker(process)
            job = worker.job
            if message.kind == "ready":
                worker.ready = True
                self._stillborn = 0
                self._changed.notify()
            elif job is not None and message.kind == "started":
                job.started = True
            elif job is not None and message.kind == "progress":
                job.message = str(header["message"])
                job.fraction = min(max(float(header["fraction"]), 0.0), 1.0)
            elif job is not None and message.kind == "ended":
                worker.job, worker.spent = None, job.restricted
                self._changed.notify()
        if job is None:
            return
        if message.kind == "progress":
            self._tell(job.on_progress, job.id, job.message, job.fraction)
        elif message.kind == "snapshot":
            self._tell(job.on_snapshot, job.id, header["header"], message.arrays)
        elif message.kind == "blob" and job.restricted:
            self._blobs.put(message.arrays["data"].tobytes())
        elif message.kind == "ended":
            self._end(job, told(job.title, job.cancelled, message))

    def _ended(self, process: Process, code: int) -> None:
        """A process is gone; what it was doing is tried again if it had not begun."""
        with self._changed:
            worker = self._worker(process)
            self._workers.remove(worker)
            job = worker.job
            if not worker.ready and not self._closing:
                self._lost()
            again = (
                job is not None
                and not (job.started or job.cancelled or job.overdue or self._closing)
                and job.tries < MOST_TRIES
            )
            if job is not None and again:
                self._queue.insert(0, job)
            self._changed.notify()
        if job is not None and not again:
            self._end(
                job,
                Cancelled()
                if self._closing
                else died(
                    job.title, job.cancelled, job.limit_seconds if job.overdue else None, code
                ),
            )

    def _end(self, job: _Job, outcome: Outcome) -> None:
        self._tell(job.on_end, job.id, outcome)

    def _tell(self, callback: Callable[..., None], *arguments: Any) -> None:
        try:
            callback(*arguments)
        except Exception:
            log.exception("what was to be told about a job was not taken")
