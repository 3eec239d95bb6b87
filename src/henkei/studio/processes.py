"""Worker processes as the studio sees them: started, heard, and ended without a trace."""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import Any

import numpy as np

from henkei.errors import InvalidInput
from henkei.studio.messages import Message, decode, encode

LARGEST_MESSAGE = 2**31 - 1  # bytes
BOOT = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from henkei.studio.worker import main; main(int(sys.argv[2]), sys.argv[3])"
)
THREADS = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS",
    "BLIS_NUM_THREADS", "NUMEXPR_NUM_THREADS",
)  # fmt: skip

log = logging.getLogger(__name__)


class Process:
    """A worker process, and the thread that hears it.

    Parameters
    ----------
    folder : of the blobs.
    heard : called with each message, on the thread of this process.
    ended : called with the exit code, negative for a signal, when nothing is left of the process;
        the last thing that its thread does.

    Raises
    ------
    OSError : the system starts no process.
    """

    def __init__(
        self,
        folder: Path,
        heard: Callable[[Process, Message], None],
        ended: Callable[[Process, int], None],
    ) -> None:
        self._heard, self._ended = heard, ended
        self._connection, theirs = Pipe()
        try:
            self._process = _started(theirs, folder)
        except BaseException:
            self._connection.close()
            raise
        finally:
            theirs.close()
        self._lock = threading.Lock()
        self._reaped = False
        self.thread = threading.Thread(target=self._listen, name="henkei-worker", daemon=True)
        self.thread.start()

    def order(self, header: dict[str, Any], data: bytes = b"") -> None:
        """Send a message; one to a process that has ended is lost."""
        try:
            self._connection.send_bytes(encode(header, task=np.frombuffer(data, np.uint8)))
        except OSError as error:
            log.debug("a worker is gone: %s", error)

    def kill(self) -> None:
        """End the process at once, with all that it started."""
        with self._lock:
            if not self._reaped:
                self._kill()

    def _kill(self) -> None:
        if sys.platform == "win32":
            self._process.kill()
            return
        try:
            os.killpg(self._process.pid, signal.SIGKILL)
        except (ProcessLookupError, PermissionError):  # not yet, or no longer, a group of its own
            self._process.kill()

    def _listen(self) -> None:
        try:
            while True:
                message = decode(self._connection.recv_bytes(LARGEST_MESSAGE))
                self._heard(self, message)
        except (EOFError, OSError):
            pass
        except InvalidInput as error:
            log.error("a worker sent what is no message: %s", error)
        except Exception:
            log.exception("a message of a worker could not be taken")
        with self._lock:
            self._kill()
            code = self._process.wait()
            self._reaped = True
        self._connection.close()
        self._ended(self, code)


def _started(theirs: Connection[Any, Any], folder: Path) -> subprocess.Popen[bytes]:
    """A fresh Python with the other end of the connection, and with our modules."""
    handle = theirs.fileno()
    how: dict[str, Any] = {}
    if sys.platform == "win32":
        os.set_handle_inheritable(handle, True)
        how["startupinfo"] = subprocess.STARTUPINFO(lpAttributeList={"handle_list": [handle]})
        how["creationflags"] = subprocess.CREATE_NO_WINDOW
    else:
        how["pass_fds"] = [handle]
        how["start_new_session"] = True  # an interrupt from the keyboard is for the studio
    return subprocess.Popen(
        [sys.executable, "-c", BOOT, json.dumps(sys.path), str(handle), str(folder)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        env={**os.environ, **dict.fromkeys(THREADS, "1")},
        **how,
    )
