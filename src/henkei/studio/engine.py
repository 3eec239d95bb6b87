"""Threads that do one thing after the other: the engine, on which a session lives, and others."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from queue import SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from henkei.studio.link import Session

Done = TypeVar("Done")
Post = Callable[[Callable[[], None]], None]
_LOG = logging.getLogger(__name__)


class Worker:
    """A thread that does what it is given, in that order, and never holds up the program's end."""

    def __init__(self, name: str) -> None:
        self._queue: SimpleQueue[tuple[Future[Any], Callable[[], Any]] | None] = SimpleQueue()
        self._thread = Thread(target=self._run, name=name, daemon=True)
        self._started = self._closed = False

    @property
    def busy(self) -> bool:
        """Whether something is still being done, or to be done."""
        return self._thread.is_alive()

    def start(self) -> None:
        """Begin, unless it has begun; what was submitted before has waited."""
        if not self._started:
            self._started = True
            self._thread.start()

    def submit(self, work: Callable[..., Done], *arguments: Any) -> Future[Done]:
        """Have something done.

        Raises
        ------
        RuntimeError : it has ended.
        """
        if self._closed:
            raise RuntimeError("the studio has ended")
        future: Future[Done] = Future()
        self._queue.put((future, partial(work, *arguments)))
        return future

    async def run(self, work: Callable[..., Done], *arguments: Any) -> Done:
        """Have something done and wait for it; if nobody waits any more it is done all the same."""
        return await asyncio.shield(asyncio.wrap_future(self.submit(work, *arguments)))

    def end(self) -> None:
        """Take nothing more; what was submitted is still done."""
        self._closed = True
        self._queue.put(None)

    def _run(self) -> None:
        while (item := self._queue.get()) is not None:
            future, work = item
            if future.set_running_or_notify_cancel():
                try:
                    future.set_result(work())
                except BaseException as error:
                    future.set_exception(error)
            del item, future, work  # what was done is not kept while nothing is to be done


class Engine(Worker):
    """The one thread on which all of a session's work is done.

    Parameters
    ----------
    opened : makes the session, on that thread; it is given the engine's :meth:`post`.
    """

    def __init__(self, opened: Callable[[Post], Session]) -> None:
        super().__init__("engine")
        self.session = self.submit(opened, self.post)

    def post(self, work: Callable[[], None]) -> None:
        """Have something done that nobody waits for; it may come too late."""

        def done() -> None:
            try:
                work()
            except Exception:
                _LOG.exception("what was posted to the session failed")

        with suppress(RuntimeError):
            self.submit(done)

    async def close(self, patience: float) -> None:
        """Close the session after what is still to be done, unless that takes long (seconds)."""

        def close() -> None:
            if self.session.exception() is None:
                self.session.result().close()
            self.end()

        if self._started:
            with suppress(TimeoutError):
                async with asyncio.timeout(patience):
                    await self.run(close)
                    await asyncio.to_thread(self._thread.join, patience)
