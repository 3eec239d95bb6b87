"""Calls of ``meshio``: found when needed, kept from printing, its errors put into one line."""

from __future__ import annotations

import contextlib
import io
import warnings
from collections.abc import Iterator
from typing import Any

from henkei.errors import MissingDependency


def library() -> Any:
    """The package.

    Raises
    ------
    MissingDependency : it is not installed.
    """
    try:
        import meshio
    except ImportError:
        raise MissingDependency(
            "this format needs the meshio package: pip install henkei[formats]"
        ) from None
    return meshio


def reason(error: BaseException, printed: io.StringIO) -> str:
    """What an error of meshio says, on one line."""
    said = str(error) if isinstance(error, Exception) else printed.getvalue()
    return f"meshio says: {' '.join(said.split()) or type(error).__name__}"


@contextlib.contextmanager
def quiet() -> Iterator[io.StringIO]:
    """Catch what meshio prints."""
    printed = io.StringIO()
    with (
        contextlib.redirect_stdout(printed),
        contextlib.redirect_stderr(printed),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        yield printed
