"""A worker process: it waits for a task, does it, tells how that goes, and waits for the next.

It and the studio exchange messages of :mod:`henkei.studio.messages`; nothing is pickled, so that
one that a hostile file took over could tell the studio nothing but data. To a worker:

``task``      what to do, as JSON in the array ``task``
``cancel``    the job that is no longer wanted

and from it ``ready`` (once), ``started``, ``progress``, ``snapshot``, ``blob`` (bytes for the store
from a restricted worker, which cannot write) and ``ended``. It ends when the studio does.
"""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import json
import math
import os
import pkgutil
import signal
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable
from importlib import import_module
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from henkei.errors import Cancelled, HenkeiError
from henkei.studio import tasks
from henkei.studio.messages import Message, decode, encode
from henkei.studio.restriction import less_memory, restrict

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from henkei.studio.blobs import Blobs

PROGRESS_INTERVAL = 0.05  # seconds
SNAPSHOT_INTERVAL = 0.1  # seconds
LONGEST_MESSAGE = 2000  # characters
MOST_WARNINGS = 20
AHEAD = (
    "henkei.studio.blobs", "henkei.topology", "henkei.io.obj", "henkei.io.ply", "henkei.io.stl",
    "henkei.io.off", "henkei.io.gltf", "henkei.io.vtk_legacy", "henkei.io.vtp", "henkei.io.grids",
    "henkei.io.gmsh", "henkei.io.abaqus", "henkei.io.nastran", "meshio",
)  # fmt: skip
"""What is imported first in idle time, before the modules of tasks."""
PR_SET_PDEATHSIG = 1


class Report:
    """How a task tells what it does. Cheap to call: a thread sends the latest, now and then.

    Each call raises :class:`henkei.errors.Cancelled` once the job was cancelled.
    """

    def __init__(self, worker: Worker, job: str) -> None:
        self._worker, self._job = worker, job
        self._lock = threading.Lock()
        self._news, self._over = threading.Event(), threading.Event()
        self._progress: tuple[str, float] | None = None
        self._snapshot: bytes | None = None
        self._next_snapshot = 0.0
        self._speaker = threading.Thread(target=self._speak, daemon=True)

    def progress(self, message: str, fraction: float) -> None:
        """A :data:`henkei.progress.Progress`; shown about 20 times a second."""
        self._check()
        whole = min(max(float(fraction), 0.0), 1.0) if math.isfinite(fraction) else 0.0
        with self._lock:
            self._progress = str(message)[:LONGEST_MESSAGE], whole
        self._news.set()

    def snapshot(self, header: dict[str, Any], **arrays: NDArray[Any]) -> None:
        """How the work looks now, a message for the page; about 10 a second are sent.

        The arrays are copied here, of the types that :func:`henkei.studio.messages.encode` takes.
        """
        self._check()
        data = encode({"kind": "snapshot", "header": header}, **arrays)
        with self._lock:
            self._snapshot = data
        self._news.set()

    @property
    def due(self) -> bool:
        """Whether a snapshot would be sent at once; ask before making a costly one."""
        return self._snapshot is None and time.monotonic() >= self._next_snapshot

    def __enter__(self) -> Self:
        self._speaker.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._news.set()
        self._speaker.join()

    def _check(self) -> None:
        if self._worker.cancelled == self._job:
            raise Cancelled("cancelled")

    def _speak(self) -> None:
        while True:
            self._news.wait()
            self._news.clear()
            over = self._over.is_set()
            snapshot = None
            with self._lock:
                progress, self._progress = self._progress, None
                if over or time.monotonic() >= self._next_snapshot:
                    snapshot, self._snapshot = self._snapshot, None
            if progress is not None:
                message, fraction = progress
                self._worker.send({"kind": "progress", "message": message, "fraction": fraction})
            if snapshot is not None:
                self._worker.send_bytes(snapshot)
                self._next_snapshot = time.monotonic() + SNAPSHOT_INTERVAL
            if over:
                return
            self._over.wait(PROGRESS_INTERVAL)
            if self._snapshot is not None:
                self._news.set()


class Worker:
    """This process.

    cancelled : the job that was cancelled last.
    """

    def __init__(self, connection: Connection, folder: str) -> None:
        self.cancelled = ""
        self._connection, self._folder = connection, folder
        self._sending = threading.Lock()
        self._orders: SimpleQueue[Message] = SimpleQueue()
        found = pkgutil.iter_modules(tasks.__path__, f"{tasks.__name__}.")
        self._cold = [*AHEAD, *(module.name for module in found)]

    def send(self, header: dict[str, Any], **arrays: NDArray[Any]) -> None:
        """Send a message to the studio."""
        self.send_bytes(encode(header, **arrays))

    def send_bytes(self, data: bytes) -> None:
        """Send an encoded message; without the studio there is nothing left to do."""
        try:
            with self._sending:
                self._connection.send_bytes(data)
        except OSError:
            os._exit(0)

    def run(self) -> None:
        """Do tasks; a restricted one is the last."""
        threading.Thread(target=self._listen, daemon=True).start()
        self.send({"kind": "ready"})
        while self._perform(self._next()):
            pass

    def _listen(self) -> None:
        """Hear the studio, also during a task; its end is ours."""
        try:
            while True:
                message = decode(self._connection.recv_bytes())
                if message.kind == "cancel":
                    self.cancelled = message.header["job"]
                else:
                    self._orders.put(message)
        finally:
            os._exit(0)

    def _next(self) -> Message:
        """The next order; modules are imported ahead until it comes."""
        while self._cold and self._orders.empty():
            with contextlib.suppress(Exception):  # the task that needs it will tell
                import_module(self._cold.pop(0))
        return self._orders.get()

    def _perform(self, order: Message) -> bool:
        """Do a task; returns whether another may follow."""
        header = order.header
        task = json.loads(order.arrays["task"].tobytes())
        restricted = bool(header["restricted"])
        self.send({"kind": "started"})
        with Report(self, header["job"]) as report, warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", UserWarning)
            # Before there are limits: with too little memory, loading OpenBLAS never ends.
            blobs = self._blobs(restricted)
            if restricted:
                restrict(header["memory"], header["seconds"], task["reads"])
                ended = _outcome(lambda: _run(task, blobs, report))
            else:
                with less_memory(header["memory"]):
                    ended = _outcome(lambda: _run(task, blobs, report))
        texts = [str(one.message) for one in told if issubclass(one.category, UserWarning)]
        ended["warnings"] = [text[:LONGEST_MESSAGE] for text in dict.fromkeys(texts)][
            :MOST_WARNINGS
        ]
        result = np.frombuffer(ended.pop("result"), np.uint8)
        self.send({"kind": "ended", **ended}, result=result)
        return not restricted

    def _blobs(self, restricted: bool) -> Blobs:
        if restricted:
            from henkei.studio.sent_blobs import SentBlobs

            return SentBlobs(self._folder, self.send)
        from henkei.studio.blobs import Blobs

        return Blobs(self._folder)


def _run(task: dict[str, Any], blobs: Blobs, report: Report) -> bytes:
    """What a task returns, as JSON."""
    module, _, name = task["function"].partition(":")
    function: Callable[..., Any] = getattr(import_module(module), name)
    return json.dumps(function(task["request"], blobs, report), default=_plain).encode()


def _outcome(work: Callable[[], bytes]) -> dict[str, Any]:
    """How work ended: ``outcome``, ``message``, ``trace`` and ``result``."""
    outcome, message, trace, result = "done", "", "", b""
    try:
        result = work()
    except Cancelled:
        outcome = "cancelled"
    except HenkeiError as error:
        outcome, message = "refused", str(error)
    except MemoryError:
        outcome, message = "refused", "there is not enough memory for this; try a coarser mesh"
    except BaseException as fault:
        outcome = "failed"
        message = f"a fault of henkei, please report it: {type(fault).__name__}: {fault}"
        trace = traceback.format_exc()
    return {
        "outcome": outcome,
        "message": message[:LONGEST_MESSAGE],
        "trace": trace[-10 * LONGEST_MESSAGE :],
        "result": result,
    }


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is no data that JSON can hold")


def main(handle: int, folder: str) -> None:
    """Be a worker, with the connection of this handle and the blobs of this folder."""
    if sys.platform == "win32":
        from multiprocessing.connection import PipeConnection

        connection: Any = PipeConnection(handle)
    else:
        from multiprocessing.connection import Connection

        os.set_inheritable(handle, False)
        connection = Connection(handle)
    if sys.platform == "linux":  # even where a library does not let the listener run
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    with contextlib.suppress(RuntimeError, OSError, ValueError):  # there may be no console
        faulthandler.enable()
    Worker(connection, folder).run()
