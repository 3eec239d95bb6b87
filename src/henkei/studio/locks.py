"""Locks between processes, by a file. The system lets go of them when a process ends in any way."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from henkei.errors import InvalidInput

_RETRY = 0.01  # seconds
_open: set[int] = set()
"""Descriptors of the lock files that this process has open."""

if sys.platform == "win32":
    import msvcrt

    def _locked(descriptor: int, wait: bool) -> bool:
        while True:
            try:
                msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
            except OSError:
                if not wait:
                    return False
                time.sleep(_RETRY)
            else:
                return True

    def _unlock(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_UNLCK, 1)
else:
    import fcntl

    def _locked(descriptor: int, wait: bool) -> bool:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            return False
        return True

    def _unlock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_UN)

    def _let_go() -> None:
        """A forked child shares its parent's locks, and would hold them when that has ended."""
        for descriptor in _open:
            os.close(descriptor)
        _open.clear()

    os.register_at_fork(after_in_child=_let_go)


class Lock:
    """A lock that one holder at a time can have, of all in all processes.

    path : its file; made if need be, and left behind.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._descriptor: int | None = None

    def take(self, wait: bool = False) -> bool:
        """Take it; False if another holder has it, who is waited for with ``wait``.

        The time of its file tells since when it is held.

        Raises
        ------
        InvalidInput : the file cannot be made or locked.
        """
        try:
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o600)
            _open.add(descriptor)
            try:
                taken = _locked(descriptor, wait)
                if taken:
                    os.utime(self.path)
                    self._descriptor = descriptor
            finally:
                if self._descriptor is None:
                    _close(descriptor)
        except OSError as error:
            raise InvalidInput(f"cannot lock {self.path}: {error.strerror or error}") from error
        return taken

    def release(self) -> None:
        """Let go of it, if it is held."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            _unlock(descriptor)
            _close(descriptor)


def _close(descriptor: int) -> None:
    _open.discard(descriptor)
    os.close(descriptor)


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Wait until no other block, in any process, is at this lock, and keep others out."""
    lock = Lock(path)
    lock.take(wait=True)
    try:
        yield
    finally:
        lock.release()


def held(path: Path) -> bool:
    """Whether another holder has this lock at present."""
    lock = Lock(path)
    taken = lock.take()
    lock.release()
    return not taken
