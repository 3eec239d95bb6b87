"""Long work that the engine's own objects need, on a thread beside it, while the engine goes on."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from henkei.errors import Cancelled
from henkei.progress import Progress
from henkei.studio.engine import Worker

OFTEN = 0.1  # seconds between two messages of progress


class Aside:
    """One such piece of work at a time; what nobody wants any more ends at its next progress.

    Parameters
    ----------
    post : runs something on the session's thread.
    tell : says something to all pages.
    """

    def __init__(
        self, post: Callable[[Callable[[], None]], None], tell: Callable[[dict[str, Any]], None]
    ) -> None:
        self._post, self._tell = post, tell
        self._worker = Worker("aside")
        self._worker.start()
        self._count = itertools.count(1)

    def start(
        self,
        title: str,
        work: Callable[[Progress], None],
        *,
        wanted: Callable[[], bool],
        then: Callable[[], None],
    ) -> Future[None]:
        """Have something done.

        Parameters
        ----------
        wanted : whether anybody still waits for it; may be called from any thread.
        then : called on the session's thread when it has ended, well or not, and was wanted.
        """
        job, told = f"aside {next(self._count)}", [0.0]
        about = {"job": job, "title": title, "cancellable": False}

        def progress(message: str, fraction: float) -> None:
            if not wanted():
                raise Cancelled("nobody waits for this any more")
            now = time.monotonic()
            if now - told[0] > OFTEN:
                told[0] = now
                self._tell({"kind": "progress", **about, "message": message, "fraction": fraction})

        def run() -> None:
            progress("beginning", 0.0)
            work(progress)

        def ended(future: Future[None]) -> None:
            error = future.exception()
            bad = "cancelled" if isinstance(error, Cancelled) else "failed"
            outcome = bad if error else "done"
            self._post(lambda: over(outcome))

        def over(outcome: str) -> None:
            self._tell({"kind": "ended", "job": job, "outcome": outcome, "message": ""})
            if wanted():
                then()

        self._tell({"kind": "progress", **about, "message": "waiting", "fraction": 0.0})
        future = self._worker.submit(run)
        future.add_done_callback(ended)
        return future

    def close(self) -> None:
        """Take nothing more; what goes on does not hold up the program's end."""
        self._worker.end()


def at_once(work: Callable[[Progress], None], progress: Progress) -> Future[None]:
    """The same for what is short: done when this returns, well or not."""
    future: Future[None] = Future()
    try:
        work(progress)
        future.set_result(None)
    except Exception as error:
        future.set_exception(error)
    return future
