"""Autosave: every step of a session in a file as it is done, and what is tried out twice a second.

Each line of the file is a checksum and a JSON object: the ``start``, a ``commit``, ``undo``,
``redo``, a ``draft``, or its ``drop``; and the id of the message that asked for it, so that it is
not done again for a page that asks again as it lost the answer. Documents stand there by their
top-level parts, only those that differ from the committed document, and whole now and then. The
system has each line before the call returns, so that a process which is killed loses nothing that
it wrote.
"""

from __future__ import annotations

import errno
import os
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import partial
from io import FileIO
from pathlib import Path
from typing import Any, Generic

from henkei.errors import InvalidInput
from henkei.io.whole import whole
from henkei.studio.history import Document, History, Step
from henkei.studio.lines import Codec, Parts, line, line_of, lines
from henkei.studio.packing import packed, unpacked

__all__ = ["Journal", "packed", "unpacked"]

NAME = "journal.jsonl"
WHOLE_EVERY = 50  # lines
INTERVAL = 0.5  # seconds
MOST_ASKED = 100  # ids of messages that are known


class Journal(Generic[Document]):
    """The file in which the steps of one session are kept.

    That the disk refuses is no error, as work goes on: ``trouble`` says so, until all could be
    written after all. Drafts are written by a thread, so that they may come at any rate.

    Parameters
    ----------
    folder : of the session; its journal is replaced by one of the steps given.
    codec : how documents are written.
    steps : those done so far, as :func:`henkei.studio.lines.read` and ``replay`` give them; for a
        new session ``History(codec.parts(document))``.
    asked : ids of the messages that asked for them.
    interval : seconds between drafts that are written; the last one is never left out.
    clock : tells the time in seconds.
    fsync : wait until each line is on the disk, so that it outlasts even a power cut.
    """

    def __init__(
        self,
        folder: Path,
        codec: Codec[Document],
        steps: History[Parts],
        asked: Iterable[Any] = (),
        *,
        interval: float = INTERVAL,
        clock: Callable[[], float] = time.monotonic,
        fsync: bool = False,
    ) -> None:
        self.file = folder / NAME
        self.trouble: str | None = None
        self.asked = deque(asked, maxlen=MOST_ASKED)
        self._codec, self._steps = codec, steps
        self._interval, self._clock, self._fsync = interval, clock, fsync
        self._stream: FileIO | None = None
        self._closed = False
        self._since_whole = 0
        self._lock = threading.Lock()
        self._waiting: deque[Step[Document]] = deque(maxlen=1)
        self._due = clock()
        self._woken, self._closing = threading.Event(), threading.Event()
        self._writer: threading.Thread | None = None
        self._write(b"")

    def commit(self, document: Document, label: str, tab: str = "", asked: Any = None) -> None:
        """A step to another document, for which a message of the id ``asked`` has asked."""
        with self._lock:
            self._waiting.clear()
            parts = self._codec.parts(document).sharing(self._steps.committed)
            step = Step.to(parts, label, tab)
            text = line_of("commit", step, self._base(), self._noted(asked))
            self._steps.commit(parts, label, tab)
            self._write(text)

    def recall(self, position: int) -> Callable[[], Document]:
        """What reads the document of a step again."""
        with self._lock:
            return partial(self._codec.document, self._steps.steps[position].document)

    def undo(self, asked: Any = None) -> None:
        """The last step is taken back."""
        with self._lock:
            self._waiting.clear()
            self._steps.undo()
            self._write(line("undo", self._noted(asked)))

    def redo(self, asked: Any = None) -> None:
        """The step that was undone last is done again."""
        with self._lock:
            self._waiting.clear()
            self._steps.redo()
            self._write(line("redo", self._noted(asked)))

    def draft(self, document: Document, label: str = "", tab: str = "") -> None:
        """A document that is tried out; it is written soon, or a later one in its place."""
        self._waiting.append(Step.to(document, label, tab))
        self._woken.set()
        if self._writer is None or not self._writer.is_alive():
            self._writer = threading.Thread(target=self._write_drafts, daemon=True)
            self._writer.start()

    def drop(self, asked: Any = None) -> None:
        """What was tried out is given up, or a message of the id ``asked`` changed nothing."""
        with self._lock:
            self._waiting.clear()
            noted = self._noted(asked)
            if noted or self._steps.drafted is not None:
                self._steps.drop()
                self._write(line("drop", noted))

    def flush(self) -> None:
        """Write the draft that waits, if one does."""
        with self._lock:
            self._due = self._clock() + self._interval
            if self._waiting:
                waiting = self._waiting.popleft()
                parts = self._codec.parts(waiting.document)
                step = Step.to(parts, waiting.label, waiting.tab)
                text = line_of("draft", step, self._base())
                self._steps.draft(parts, waiting.label, waiting.tab)
                self._write(text)

    def close(self) -> None:
        """Write what waits, and let go of the file."""
        self._closing.set()
        self._woken.set()
        if self._writer is not None:
            self._writer.join()
        self.flush()
        self._closed = True
        self._let_go()

    def _write_drafts(self) -> None:
        """What the thread does."""
        while not self._closing.is_set():
            self._woken.wait()
            pause = self._due - self._clock()
            if pause > 0:
                self._closing.wait(pause)
            else:
                self._woken.clear()
                self.flush()

    def _noted(self, asked: Any) -> list[Any]:
        """What is told in a line of the message that asked for it, if one did."""
        noted = [] if asked is None else [asked]
        self.asked += noted
        return noted

    def _base(self) -> Parts | None:
        """What the next line may leave out; now and then nothing."""
        self._since_whole = (self._since_whole + 1) % WHOLE_EVERY
        return self._steps.committed if self._since_whole else None

    def _write(self, text: bytes) -> None:
        """Append a line; all lines if the file is not open, as after a failure."""
        if self._closed:
            return
        try:
            if self._stream is None:
                self._stream = self._rewritten()
            elif self._stream.write(text) != len(text):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            elif self._fsync:
                os.fsync(self._stream.fileno())
            self.trouble = None
        except (OSError, InvalidInput) as error:
            self._let_go()
            self.trouble = f"what you do is not being saved at present: {error}"

    def _rewritten(self) -> FileIO:
        """The file with a line for each step, open for more."""
        with whole(self.file) as stream:
            stream.writelines(lines(self._steps, WHOLE_EVERY, self.asked))
        self._since_whole = 0
        return self.file.open("ab", buffering=0)

    def _let_go(self) -> None:
        stream, self._stream = self._stream, None
        if stream is not None:
            with suppress(OSError):
                stream.close()
