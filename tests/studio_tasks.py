"""Tasks for the tests of the studio's jobs: good ones, hanging ones, and hostile ones."""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np

from henkei.errors import HenkeiError, InvalidInput
from henkei.studio.tasks import read_file


def echo(request, blobs, report):
    """The request again, and who did it."""
    return {"request": request, "process": os.getpid()}


def told(request, blobs, report):
    """More progress and snapshots than can be shown, of arrays that change on the way."""
    values = np.zeros(1000, np.float32)
    for step in range(request["steps"]):
        values[:] = step
        report.snapshot({"step": step}, values=values)
        report.progress(f"step {step}", step / request["steps"])
    report.progress("over", float("nan"))
    return {"numbers": np.arange(3), "number": np.float64(0.5)}


def kept(request, blobs, report):
    """A blob read and a blob written."""
    values = blobs.get_message(request["blob"]).arrays["values"]
    return {"blob": blobs.put_message({"kind": "twice"}, values=2 * values)}


def sent(request, blobs, report):
    """A blob from where only bytes can be sent."""
    return {"blob": blobs.put(request["text"].encode()), "process": os.getpid()}


def warned(request, blobs, report):
    warnings.warn("the seams are lost", stacklevel=1)
    warnings.warn("the seams are lost", stacklevel=1)
    warnings.warn("not for people", DeprecationWarning, stacklevel=1)
    return {}


def threads(request, blobs, report):
    return {name: os.environ[name] for name in request["names"]}


def waits(request, blobs, report):
    """Until the file ``gate`` is there."""
    while not Path(request["gate"]).exists():
        report.progress("at the gate", 0.5)
        time.sleep(0.01)
    return {}


def spins(request, blobs, report):
    """For ever, without a word."""
    _tell(request)
    while True:
        pass


def locks(request, blobs, report):
    """For ever, and no other thread of the process runs meanwhile."""
    _tell(request)
    ctypes.PyDLL(None).sleep(600)


def _tell(request):
    """Open the pipe that the test reads, until this process ends."""
    if "pipe" in request:
        request["open"] = os.open(request["pipe"], os.O_WRONLY)


def refuses(request, blobs, report):
    raise InvalidInput("handles 3 and 4 are one; remove one of them")


def breaks(request, blobs, report):
    return {}["nothing"]


def hungry(request, blobs, report):
    raise MemoryError


def leaves(request, blobs, report):
    sys.exit("enough")


def answers_no_data(request, blobs, report):
    return {"task": object()}


def exits(request, blobs, report):
    os._exit(3)


def crashes(request, blobs, report):
    os.kill(os.getpid(), signal.SIGSEGV)
    time.sleep(60)


def is_killed(request, blobs, report):
    os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(60)


def leaves_a_child(request, blobs, report):
    """A process that would live on, and that has the connection to the studio too."""
    if os.fork() == 0:
        _tell(request)
        time.sleep(600)
    return {}


def grows(request, blobs, report):
    """Takes memory without end."""
    taken = []
    while True:
        taken.append(np.ones(10**6))


def digs(request, blobs, report):
    """Calls itself without end."""
    return digs(request, blobs, report)


def tries(request, blobs, report):
    """What of all that a restricted task may not do is refused, by name."""
    place = Path(request["folder"])
    libc = ctypes.CDLL(None)
    attempts = {
        "write": lambda: (place / "new").write_text("x"),
        "append": lambda: (place / "old").open("a"),
        "update": lambda: (place / "old").open("r+b"),
        "save": lambda: np.save(place / "new.npy", np.ones(3)),
        "open": lambda: os.open(place / "new", os.O_CREAT | os.O_RDWR),
        "mkdir": lambda: (place / "folder").mkdir(),
        "remove": lambda: (place / "old").unlink(),
        "rename": lambda: (place / "old").rename(place / "older"),
        "link": lambda: (place / "link").symlink_to(place / "old"),
        "chmod": lambda: (place / "old").chmod(0o777),
        "read": lambda: (place / "old").read_text(),
        "read passwd": lambda: Path("/etc/passwd").read_text(),
        "read around": lambda: (Path(request["own"]).parent / ".." / "old").read_text(),
        "read by link": lambda: Path(request["link"]).read_text(),
        "run": lambda: subprocess.run(["true"], check=False),
        "system": lambda: os.system("true"),
        "fork": os.fork,
        "kill": lambda: os.kill(os.getppid(), 0),
        "socket": socket.socket,
        "result": lambda: blobs.put_result(None),
        "native": lambda: _native(libc, place / "old"),
    }
    refused = []
    for name, attempt in attempts.items():
        try:
            attempt()
        except (OSError, HenkeiError):
            refused.append(name)
    own = Path(request["own"]).read_text()
    return {"refused": refused, "tried": list(attempts), "own": own}


def _native(libc, path):
    """Write past the audit hook, as machine code could."""
    file = libc.open(os.fsencode(path), os.O_WRONLY)
    if libc.write(file, b"x", 1) != 1:
        raise OSError


def reads_all(request, blobs, report):
    """How each file of a folder ends: a surface's blob, or a refusal."""
    ends = {}
    for file in sorted(Path(request["folder"]).iterdir()):
        try:
            found = read_file.run({"path": str(file), "alone": True}, blobs, report)
            ends[file.name] = ["surface", found["surface"]]
        except HenkeiError as error:
            ends[file.name] = ["refused", str(error)]
        except MemoryError:
            ends[file.name] = ["refused", f"{file.name}: there is not enough memory"]
    return ends
