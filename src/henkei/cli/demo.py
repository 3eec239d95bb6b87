"""``henkei demo``: two built-in heads, combined and morphed."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Annotated

from cyclopts import Parameter
from rich.text import Text

from henkei.cli.combining import listing, quality_lines
from henkei.cli.console import console, progress_bar
from henkei.cli.outputs import Written, shown
from henkei.workflows.demo import demonstrate


def demo(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("demo-out"),
    resolution: float = 1.0,
) -> None:
    """Combine and morph two built-in heads, and show the result on a page.

    Example: `henkei demo -o demo-out`, then open `demo-out/index.html` in a browser.

    Parameters
    ----------
    output
        Folder for meshes, results, pictures and the page; made if it is not there.
    resolution
        How much finer the heads are than usual, from 0.5 to 4.
    """
    start = perf_counter()
    with progress_bar() as progress:
        done = demonstrate(output, resolution=resolution, progress=progress)
    files = [Written.of(what, [done.folder / name]) for name, what in done.files.items()]
    out = console()
    out.print("Two heads, modelled in code, combined into one mesh and morphed.")
    out.print(listing(quality_lines(done.combined)))
    out.print(shown(files))
    if done.missing:
        out.print(Text(f"No pictures: {done.missing}"))
    out.print(Text(f"{perf_counter() - start:.0f} s. Open {done.folder / 'index.html'}"))
