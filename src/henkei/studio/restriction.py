"""What a process may not do that reads a file of a stranger.

Limits of the system, where it has them, and an audit hook: Python asks it before each file is
opened, each process started, each address called. Neither can be lifted again.
"""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import all_suffixes
from pathlib import Path
from typing import Any

import henkei

try:
    import resource
except ImportError:  # Windows has no limits of this kind
    resource = None  # type: ignore[assignment]

MOST_OPEN_FILES = 32
SPARE_SECONDS = 5  # of processor time, beyond the seconds that a clock allows
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
FORBIDDEN = (
    "os.", "shutil.", "tempfile.", "subprocess.", "pty.", "socket.", "urllib.", "http.", "ftplib.",
    "smtplib.", "webbrowser.", "resource.", "fcntl.", "syslog.", "sqlite3.", "winreg.", "_winapi.",
)  # fmt: skip
HARMLESS = ("os.listdir", "os.scandir", "os.walk", "os.add_dll_directory")  # imports need them


def restrict(memory: int, seconds: float, reads: Sequence[str]) -> None:
    """Let this process from now on only compute, and read what it needs.

    Parameters
    ----------
    memory : bytes that it may take in addition to those it has.
    seconds : of processor time, in addition to those it used.
    reads : files that may be read, and folders with all in them; modules of Python may always.
    """
    if resource is not None:
        used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
        limits = {
            resource.RLIMIT_CORE: 0,
            resource.RLIMIT_FSIZE: 0,
            resource.RLIMIT_NOFILE: MOST_OPEN_FILES,
            resource.RLIMIT_CPU: int(used + seconds) + SPARE_SECONDS,
        }
        size = address_space()
        if size:
            limits[resource.RLIMIT_AS] = size + memory
        for kind, limit in limits.items():
            allowed = _allowed(limit, resource.getrlimit(kind)[1])
            resource.setrlimit(kind, (allowed, allowed))
    sys.addaudithook(_Guard(reads))


@contextlib.contextmanager
def less_memory(memory: int | None) -> Iterator[None]:
    """So many more bytes than now and no more may be taken inside the block."""
    size = address_space()
    if memory is None or resource is None or not size:
        yield
        return
    before, most = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (_allowed(size + memory, most), most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, most))


def _allowed(limit: int, most: int) -> int:
    """A limit, or the one that is there already if it is lower."""
    return limit if most == resource.RLIM_INFINITY else min(limit, most)


def address_space() -> int:
    """Bytes of addresses that this process has; 0 where the system does not tell."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except (OSError, ValueError):
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")


def half_of_memory() -> int:
    """Half the bytes of this machine's memory, or of 8 GiB where the system does not tell."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    except (AttributeError, ValueError, OSError):
        return 4 * 2**30


class _Guard:
    """The audit hook."""

    def __init__(self, reads: Sequence[str]) -> None:
        self._reads = tuple(map(os.path.realpath, reads))
        places = [*sys.path, sys.prefix, sys.base_prefix, *henkei.__path__]
        self._modules = tuple(os.path.realpath(place) for place in places if place)
        self._suffixes = tuple(all_suffixes())

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            path, _, flags = arguments
            if isinstance(path, int) or (not flags & WRITING and self._readable(path)):
                return
            raise PermissionError(errno.EACCES, "not allowed for files from outside", path)
        if event.startswith(FORBIDDEN) and event not in HARMLESS:
            raise PermissionError(errno.EACCES, f"{event} is not allowed for files from outside")

    def _readable(self, path: str | bytes) -> bool:
        place = os.path.realpath(os.fsdecode(path))
        if any(place == one or _inside(place, one) for one in self._reads):
            return True
        return place.endswith(self._suffixes) and any(_inside(place, m) for m in self._modules)


def _inside(place: str, folder: str) -> bool:
    return place.startswith(folder.rstrip(os.sep) + os.sep)
