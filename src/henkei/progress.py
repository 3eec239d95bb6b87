"""How long work reports, and how it is cancelled.

A long function takes ``progress``: a callable ``progress(message, fraction)`` with the fraction of
the work done in ``[0, 1]``. To cancel, let it raise; :class:`henkei.errors.Cancelled` is made for
that.
"""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, float], None]


def silent(message: str, fraction: float) -> None:
    """Report nothing."""


def part(progress: Progress, start: float, end: float, said: str | None = None) -> Progress:
    """The progress function of a step that takes the work from ``start`` to ``end``.

    said : in place of the step's own messages.
    """

    def report(message: str, fraction: float) -> None:
        progress(message if said is None else said, start + (end - start) * fraction)

    return report
