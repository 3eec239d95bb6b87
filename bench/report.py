"""Figures as Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "combine.md"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table; short rows are filled up."""
    full = [[*row, *[""] * (len(head) - len(row))] for row in rows]
    ruled = [list(head), ["---"] * len(head), *full]
    return "\n".join("| " + " | ".join(row) + " |" for row in ruled)


def lines(*paragraphs: str) -> str:
    """Paragraphs with an empty line between them."""
    return "\n\n".join(paragraph for paragraph in paragraphs if paragraph) + "\n"


def seconds(value: float) -> str:
    """Three digits, without exponents."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def number(value: float) -> str:
    """Three digits."""
    return f"{value:.3g}"


def target(name: str, measured: float, limit: float) -> list[str]:
    """A row that sets a figure beside its target."""
    return [name, number(measured), f"<= {limit:g}", "met" if measured <= limit else "**missed**"]


def growth(points: Sequence[tuple[float, float]]) -> float | None:
    """Exponent of growth of (size, cost), by least squares in logarithms."""
    if len(points) < 2:
        return None
    size, cost = np.log(np.array(points)).T
    return float(np.polyfit(size, cost, 1)[0])


def put_in_document(name: str, text: str) -> None:
    """Replace what stands between the marks of ``python -m bench NAME`` in ``docs/combine.md``."""
    start, end = f"<!-- made by `python -m bench {name}` -->", f"<!-- end of {name} -->"
    before, found, rest = DOCUMENT.read_text().partition(start)
    _, closed, after = rest.partition(end)
    if not (found and closed):
        raise RuntimeError(f"{DOCUMENT} lacks the marks {start} and {end}")
    DOCUMENT.write_text(f"{before}{start}\n\n{text}\n{end}{after}")
