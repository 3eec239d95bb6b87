"""What commands print on: results on stdout, progress, warnings and errors on stderr."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from henkei.progress import Progress, silent

if TYPE_CHECKING:
    from rich.console import Console


def console() -> Console:
    """Where results go."""
    from rich.console import Console

    return Console(highlight=False)


def errors() -> Console:
    """Where all else goes."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


@contextmanager
def tidy_warnings() -> Iterator[None]:
    """Print warnings as one line each, without the place in the code."""

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        from rich.text import Text

        target = errors()
        text = Text.assemble(("warning: ", "bold yellow"), str(message))
        target.print(text, soft_wrap=not target.is_terminal)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


@contextmanager
def progress_bar() -> Iterator[Progress]:
    """A progress function that draws a bar while the work lasts, if stderr is a terminal."""
    target = errors()
    if not target.is_terminal:
        yield silent
        return
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = TextColumn("{task.description:<24}"), BarColumn(), TimeElapsedColumn()
    with Bar(*columns, console=target, transient=True) as bar:
        task = bar.add_task("", total=1.0)

        def report(message: str, fraction: float) -> None:
            bar.update(task, description=message, completed=fraction)

        yield report
