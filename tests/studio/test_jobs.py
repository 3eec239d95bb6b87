"""Work in other processes: what comes back, what happens to the studio when it goes wrong."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from henkei.errors import InvalidInput
from henkei.studio.blobs import Blobs
from henkei.studio.jobs import TASKS, Cancelled, Done, Failed, Jobs, Refused, Task
from henkei.studio.processes import THREADS

SOON = 60.0  # seconds after which something hangs
ALLOWED = (*TASKS, "studio_tasks:")
linux = pytest.mark.skipif(sys.platform != "linux", reason="limits and signals as Linux has them")


class Watch:
    """What is told about one job."""

    def __init__(self, jobs, function, request=None, *, reads=(), **options):
        self.progress, self.snapshots, self.ends = [], [], []
        self._told, self._over = threading.Condition(), threading.Event()
        self.job = jobs.start(
            Task(f"studio_tasks:{function}", request or {}, reads),
            title=function,
            on_progress=self._on_progress,
            on_snapshot=lambda job, header, arrays: self.snapshots.append((header, arrays)),
            on_end=self._on_end,
            **options,
        )

    def _on_progress(self, job, message, fraction):
        with self._told:
            self.progress.append((message, fraction))
            self._told.notify_all()

    def _on_end(self, job, outcome):
        assert job == self.job
        self.ends.append(outcome)
        self._over.set()

    def until(self, message):
        """Wait for a progress message."""
        with self._told:
            assert self._told.wait_for(lambda: message in [m for m, _ in self.progress], SOON)

    @property
    def outcome(self):
        assert self._over.wait(SOON)
        return self.ends[0]


def closed(jobs):
    """Close within a time, so that what hangs fails."""
    closing = threading.Thread(target=jobs.close, daemon=True)
    closing.start()
    closing.join(SOON)
    assert not closing.is_alive()


@contextlib.contextmanager
def opened(folder, **options):
    jobs = Jobs(folder, **{"idle": 0, "allowed": ALLOWED, **options})
    try:
        yield jobs
    finally:
        closed(jobs)


@pytest.fixture
def jobs(tmp_path):
    with opened(tmp_path / "blobs") as jobs:
        yield jobs


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    """Jobs for what leaves no trace in them."""
    with opened(tmp_path_factory.mktemp("studio")) as jobs:
        yield jobs


class Pipe:
    """Tells when the last process is gone that opened it for writing."""

    def __init__(self, path):
        os.mkfifo(path)
        self.path, self.opened = path, threading.Event()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        with self.path.open("rb") as stream:
            self.opened.set()
            stream.read()

    def wait(self):
        assert self.opened.wait(SOON)

    def is_left(self):
        self._reader.join(SOON)
        return not self._reader.is_alive()


def test_a_task_returns_data(shared):
    request = {"name": "Überschuß", "values": [1, 2.5, None, True], "deep": {"list": [[]]}}
    outcome = Watch(shared, "echo", request).outcome
    assert outcome.result["request"] == request
    assert outcome.result["process"] != os.getpid()
    assert outcome.warnings == ()


def test_a_large_request_and_answer(shared):
    """Larger than the header of a message, and than what a pipe holds."""
    request = {"values": list(range(500_000))}
    assert Watch(shared, "echo", request).outcome.result["request"] == request


def test_a_worker_is_used_again(shared):
    processes = {Watch(shared, "echo").outcome.result["process"] for _ in range(3)}
    assert len(processes) == 1


def test_progress_and_snapshots_are_the_latest_and_few(shared):
    steps = 5000
    watch = Watch(shared, "told", {"steps": steps})
    assert watch.outcome == Done({"numbers": [0, 1, 2], "number": 0.5})
    fractions = [fraction for _, fraction in watch.progress[:-1]]
    assert fractions == sorted(fractions)
    assert watch.progress[-1] == ("over", 0.0)
    assert 0 < len(watch.snapshots) <= len(watch.progress) < steps / 2
    for header, arrays in watch.snapshots:
        np.testing.assert_array_equal(arrays["values"], np.full(1000, header["step"], np.float32))
    assert watch.snapshots[-1][0] == {"step": steps - 1}


def test_tasks_work_with_blobs(shared):
    blobs = Blobs(shared._folder)
    values = np.arange(5.0)
    blob = blobs.put_message({"kind": "values"}, values=values)
    result = Watch(shared, "kept", {"blob": blob}).outcome.result
    np.testing.assert_array_equal(blobs.get_message(result["blob"]).arrays["values"], 2 * values)


def test_warnings_come_with_the_result(shared):
    assert Watch(shared, "warned").outcome == Done({}, ("the seams are lost",))


def test_libraries_have_one_thread(shared):
    result = Watch(shared, "threads", {"names": THREADS}).outcome.result
    assert result == dict.fromkeys(THREADS, "1")


@pytest.mark.parametrize(
    ("function", "kind", "message"),
    [
        ("refuses", Refused, "handles 3 and 4 are one; remove one of them"),
        ("hungry", Refused, "there is not enough memory for this"),
        ("breaks", Failed, "a fault of henkei, please report it: KeyError: 'nothing'"),
        ("leaves", Failed, "a fault of henkei, please report it: SystemExit: enough"),
        ("answers_no_data", Failed, "object is no data"),
        ("digs", Failed, "RecursionError"),
        ("is_not_there", Failed, "please report it: AttributeError"),
        ("exits", Failed, "ended unexpectedly (exit code 3)"),
        pytest.param("crashes", Failed, "ended unexpectedly (SIGSEGV)", marks=linux),
        pytest.param("is_killed", Failed, "memory ran out", marks=linux),
    ],
)
def test_what_goes_wrong_is_told_and_the_next_job_works(shared, function, kind, message):
    watch = Watch(shared, function)
    assert isinstance(watch.outcome, kind)
    assert message in watch.outcome.message
    assert Watch(shared, "echo").outcome.result["request"] == {}
    assert len(watch.ends) == 1


def test_a_fault_is_in_the_log(shared, caplog):
    assert isinstance(Watch(shared, "breaks").outcome, Failed)
    assert "in breaks" in caplog.text
    assert "KeyError" in caplog.text


@pytest.mark.parametrize(
    "function",
    [
        "os:system",
        "henkei.studio.tasks",
        "henkei.studio.tasks:run",
        "henkei.studio.tasks.a:b:c",
        "henkei.studio.tasks.a:b.c",
        "henkei.studio.tasks.a:b()",
        "henkei.studio.tasks.../a:run",
        " henkei.studio.tasks.a:run",
        "henkei.studio.tasks.a:run\n",
    ],
)
def test_only_tasks_are_done(shared, function):
    with pytest.raises(InvalidInput, match="is no task"):
        shared.start(Task(function, {}), title="", on_end=lambda job, outcome: None)


def test_more_jobs_than_workers_wait(shared, tmp_path):
    gate = tmp_path / "gate"
    at_work = [Watch(shared, "waits", {"gate": str(gate)}) for _ in range(2)]
    for watch in at_work:
        watch.until("at the gate")
    late = Watch(shared, "waits", {"gate": str(gate)})
    never = Watch(shared, "waits", {"gate": str(gate)})
    never.until("waiting")
    running = shared.running
    assert [one.job for one in running] == [w.job for w in (*at_work, late, never)]
    assert [one.waiting for one in running] == [False, False, True, True]
    assert running[0].message == "at the gate"
    assert running[0].fraction == 0.5
    shared.cancel(never.job)
    assert never.outcome == Cancelled()
    assert Watch(shared, "sent", {"text": "a"}, restricted=True).outcome.result  # has its own place
    gate.touch()
    for watch in (*at_work, late):
        assert watch.outcome == Done({})
    assert late.progress[0] == ("waiting", 0.0)
    assert shared.running == []


def test_a_job_that_reports_is_cancelled_politely(shared, tmp_path):
    process = Watch(shared, "echo").outcome.result["process"]
    watch = Watch(shared, "waits", {"gate": str(tmp_path / "gate")})
    watch.until("at the gate")
    shared.cancel(watch.job)
    assert watch.outcome == Cancelled()
    assert Watch(shared, "echo").outcome.result["process"] == process
    shared.cancel(watch.job)
    assert len(watch.ends) == 1


@linux
def test_jobs_that_do_not_listen_are_killed(shared, tmp_path, monkeypatch):
    monkeypatch.setattr("henkei.studio.jobs.PATIENCE", 0.2)
    pipes = [Pipe(tmp_path / name) for name in ("spins", "locks")]
    watches = [Watch(shared, pipe.path.name, {"pipe": str(pipe.path)}) for pipe in pipes]
    for pipe in pipes:
        pipe.wait()
    for watch in watches:
        shared.cancel(watch.job)
    assert [watch.outcome for watch in watches] == [Cancelled()] * 2
    assert all(pipe.is_left() for pipe in pipes)
    assert Watch(shared, "echo").outcome.result["request"] == {}


def test_a_job_that_takes_too_long_is_refused(shared):
    outcome = Watch(shared, "spins", limit_seconds=0.2).outcome
    assert isinstance(outcome, Refused)
    assert "longer than 0.2 seconds" in outcome.message


@linux
def test_an_idle_worker_that_was_killed_is_replaced(shared):
    process = Watch(shared, "echo").outcome.result["process"]
    os.kill(process, signal.SIGKILL)
    assert Watch(shared, "echo").outcome.result["process"] != process


def test_without_processes_jobs_fail(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with opened(tmp_path / "blobs") as jobs:
        outcome = Watch(jobs, "echo").outcome
        assert isinstance(outcome, Failed)
        assert "no process could be started" in outcome.message
    assert "No such file" in caplog.text


def test_a_python_without_henkei_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr("henkei.studio.processes.BOOT", "raise SystemExit(1)")
    with opened(tmp_path / "blobs") as jobs:
        assert "no process could be started" in Watch(jobs, "echo").outcome.message


def test_close_ends_all_jobs_once_and_leaves_nothing(tmp_path):
    def held():
        files = Path("/proc/self/fd").iterdir() if sys.platform == "linux" else ()
        return {*threading.enumerate(), *(file.name for file in files)}

    before = held()
    jobs = Jobs(tmp_path / "blobs", workers=1, idle=0, allowed=ALLOWED)
    process = Watch(jobs, "echo").outcome.result["process"]
    gate = {"gate": str(tmp_path / "gate")}
    watches = [Watch(jobs, "waits", gate) for _ in range(2)]
    watches[0].until("at the gate")
    closed(jobs)
    assert [watch.ends for watch in watches] == [[Cancelled()]] * 2
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)
    assert held() <= before
    with pytest.raises(InvalidInput, match="closing"):
        Watch(jobs, "echo")
    closed(jobs)


@linux
def test_close_ends_what_a_task_has_started(jobs, tmp_path):
    pipe = Pipe(tmp_path / "pipe")
    assert Watch(jobs, "leaves_a_child", {"pipe": str(pipe.path)}).outcome == Done({})
    pipe.wait()
    closed(jobs)
    assert pipe.is_left()


@pytest.mark.parametrize("python", [sys.executable, "is not there"])
def test_close_from_a_callback(tmp_path, monkeypatch, python):
    """On the thread that hears a process, and on the one that starts them."""
    monkeypatch.setattr(sys, "executable", python)
    over = threading.Event()
    jobs = Jobs(tmp_path / "blobs", idle=0, allowed=ALLOWED)

    def end(job, outcome):
        jobs.close()
        over.set()

    jobs.start(Task("studio_tasks:echo", {}), title="", on_end=end)
    assert over.wait(SOON)
    closed(jobs)


def test_a_callback_that_fails_harms_nothing(shared, caplog):
    def fails(*told):
        raise RuntimeError("the page is gone")

    over = threading.Event()
    shared.start(
        Task("studio_tasks:told", {"steps": 2}),
        title="",
        on_progress=fails,
        on_snapshot=fails,
        on_end=lambda job, outcome: (over.set(), fails()),
    )
    assert over.wait(SOON)
    assert Watch(shared, "echo").outcome.result["request"] == {}
    assert "the page is gone" in caplog.text


KILLED = """
import os, signal, sys
from pathlib import Path
from henkei.studio.jobs import Jobs, Task
jobs = Jobs(Path(sys.argv[1]), idle=0, allowed=("studio_tasks:",))
for name in "spins", "locks":
    task = Task("studio_tasks:" + name, {"pipe": f"{sys.argv[2]}/{name}"})
    jobs.start(task, title="", on_end=print)
sys.stdin.read()
os.kill(os.getpid(), signal.SIGKILL)
"""


@linux
def test_workers_end_with_the_studio(tmp_path):
    pipes = [Pipe(tmp_path / name) for name in ("spins", "locks")]
    command = [sys.executable, "-c", KILLED, str(tmp_path / "blobs"), str(tmp_path)]
    tests = str(Path(__file__).parents[1])
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, env={**os.environ, "PYTHONPATH": tests}
    ) as studio:
        for pipe in pipes:
            pipe.wait()
        studio.communicate(b"now", timeout=SOON)
        assert studio.returncode == -signal.SIGKILL
    assert all(pipe.is_left() for pipe in pipes)


def test_a_restricted_job_sends_what_it_keeps_and_is_the_last_of_its_worker(shared):
    results = [
        Watch(shared, "sent", {"text": text}, restricted=True).outcome.result
        for text in ("a surface", "another")
    ]
    blobs = Blobs(shared._folder)
    assert [blobs.get(result["blob"]) for result in results] == [b"a surface", b"another"]
    assert results[0]["process"] != results[1]["process"]


@linux
def test_a_restricted_job_can_only_compute_and_read_its_file(shared, tmp_path):
    (tmp_path / "old").write_text("mine")
    own = tmp_path / "upload"
    own.mkdir()
    (own / "file").write_text("yours")
    (own / "link").symlink_to(tmp_path / "old")
    request = {"folder": str(tmp_path), "own": str(own / "file"), "link": str(own / "link")}
    before = sorted(tmp_path.iterdir())
    result = Watch(shared, "tries", request, reads=(str(own),), restricted=True).outcome.result
    assert result["refused"] == result["tried"]
    assert result["own"] == "yours"
    assert sorted(tmp_path.iterdir()) == before
    assert (tmp_path / "old").read_text() == "mine"


@linux
def test_memory_has_a_limit(tmp_path):
    with opened(tmp_path / "blobs", memory=2**26) as jobs:
        outcomes = [Watch(jobs, "grows", restricted=kind).outcome for kind in (False, True)]
    for outcome in outcomes:
        assert isinstance(outcome, Refused)
        assert "memory" in outcome.message
