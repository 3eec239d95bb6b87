"""Where the page of the studio is: bundled from ``web/``, and part of every wheel."""

from __future__ import annotations

from pathlib import Path

from henkei.errors import MissingDependency

_FOLDER = Path(__file__).parents[1] / "page"


def page_folder() -> Path:
    """The folder of ``index.html`` (the studio), ``viewer.js`` (for notebooks) and what they load.

    Raises
    ------
    MissingDependency : the page was not built.
    """
    if not (_FOLDER / "index.html").is_file():
        raise MissingDependency(
            "this installation was made without Node.js, which bundles the studio's page: install "
            "a wheel that has it, or install Node.js 18 or later with npm and install henkei again "
            "(in a clone of the repository: make studio)"
        )
    return _FOLDER
