"""What a job is told to do, and how it ends."""

from __future__ import annotations

import json
import logging
import signal
from dataclasses import dataclass
from typing import Any

from henkei.studio.messages import Message

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Task:
    """What to do, as data.

    function : such as ``"henkei.studio.tasks.quad:run"``.
    request : its argument, data that JSON can hold.
    reads : files that a restricted task may read, or folders with all in them.
    """

    function: str
    request: dict[str, Any]
    reads: tuple[str, ...] = ()


@dataclass(frozen=True)
class Done:
    """The task returned ``result``; ``warnings`` are those that it gave on the way."""

    result: dict[str, Any]
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Refused:
    """It cannot be done; the message says why, and what to do."""

    message: str


@dataclass(frozen=True)
class Cancelled:
    """It was asked to stop, or the studio closed."""


@dataclass(frozen=True)
class Failed:
    """A fault of henkei, or the process died; the log has more."""

    message: str


Outcome = Done | Refused | Cancelled | Failed


@dataclass(frozen=True)
class Running:
    """A job that has not ended.

    job : its id.
    message, fraction : the progress that it told last.
    waiting : for others to end.
    """

    job: str
    title: str
    message: str
    fraction: float
    waiting: bool


def told(title: str, cancelled: bool, message: Message) -> Outcome:
    """How a job ended, as its worker says.

    title : of the job, for the log.
    cancelled : it was asked to stop, so that what came of it no longer matters.
    """
    header = message.header
    text, kind = str(header["message"]), header["outcome"]
    if cancelled or kind == "cancelled":
        return Cancelled()
    if kind == "done":
        result = json.loads(message.arrays["result"].tobytes())
        return Done(result, tuple(map(str, header["warnings"])))
    if kind == "refused":
        return Refused(text)
    log.error("%s failed\n%s", title, header["trace"])
    return Failed(text)


def died(title: str, cancelled: bool, overdue: float | None, code: int) -> Outcome:
    """How a job ended whose process did.

    overdue : seconds after which it was killed; None if it was not for that.
    code : exit code of the process, negative for a signal.
    """
    if cancelled:
        return Cancelled()
    if overdue is not None:
        return Refused(
            f"this took longer than {overdue:g} seconds and was stopped; try it with a coarser mesh"
        )
    if code < 0:
        try:
            how = signal.Signals(-code).name
        except ValueError:
            how = f"signal {-code}"
    else:
        how = f"exit code {code}"
    log.error("%s: the worker process died (%s)", title, how)
    if how == "SIGKILL":
        return Failed(
            "the work ended unexpectedly: the system stopped it, most likely because memory ran "
            "out; nothing else was lost; try a coarser mesh or close other programs"
        )
    return Failed(
        f"the work ended unexpectedly ({how}); nothing else was lost; please report it to henkei, "
        "with what you did"
    )
