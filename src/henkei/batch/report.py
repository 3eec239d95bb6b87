"""What came of each scan, for a spreadsheet (``report.csv``) and for programs (``report.json``)."""

from __future__ import annotations

import csv
import json
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any, Literal

from henkei.io.whole import whole

Status = Literal["waiting", "done", "kept", "failed"]

CSV, JSON = "report.csv", "report.json"
FIGURE = "to_source_mean"  # how far the scan is from the result: the one figure to tell
SHARE = 0.02  # of the time may go into writing reports along the way


@dataclass
class Row:
    """One scan.

    status : ``waiting`` until it has its turn, ``kept`` where an earlier result serves.
    seconds : that the work took, where it was done in this run.
    """

    name: str
    scan: str
    status: Status = "waiting"
    error: str = ""
    seconds: float | None = None
    quality: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    trace: str = ""

    @property
    def told(self) -> str:
        """How it went, in a few words."""
        mean = self.quality.get(FIGURE)
        return f"{mean:.3%} of the diagonal away" if isinstance(mean, float) else self.status

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON."""
        entry: dict[str, Any] = {"name": self.name, "scan": self.scan, "status": self.status}
        if self.error:
            entry["error"] = self.error
        if self.trace:
            entry["trace"] = self.trace
        if self.warnings:
            entry["warnings"] = list(self.warnings)
        if self.seconds is not None:
            entry["seconds"] = round(self.seconds, 3)
        if self.quality:
            entry["quality"] = {name: _finite(value) for name, value in self.quality.items()}
        return entry


@dataclass
class Report:
    """All scans of a run, in their order, and what was the same for all."""

    about: Mapping[str, Any]
    rows: list[Row]
    _next: float = 0.0

    def count(self, *statuses: Status) -> int:
        """How many scans have one of these statuses."""
        return sum(row.status in statuses for row in self.rows)

    @property
    def distances(self) -> dict[str, float]:
        """Mean distance of each scan from its result, as a fraction of the diagonal, by name."""
        figures = {row.name: row.quality.get(FIGURE) for row in self.rows}
        return {name: value for name, value in figures.items() if isinstance(value, float)}

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON."""
        counts = {name: self.count(name) for name in ("done", "kept", "failed", "waiting")}
        return {**self.about, **counts, "scans": [row.as_dict() for row in self.rows]}

    def write(self, folder: Path) -> None:
        """Write both files, each whole or not at all."""
        with whole(folder / JSON, "w") as stream:
            stream.write(json.dumps(self.as_dict(), indent=1, allow_nan=False) + "\n")
        with whole(folder / CSV, "w") as stream:
            stream.write(self._table())

    def write_now_and_then(self, folder: Path) -> None:
        """Write both files, unless that was done a moment ago."""
        started = time.monotonic()
        if started >= self._next:
            self.write(folder)
            ended = time.monotonic()
            self._next = ended + max(1.0, (ended - started) / SHARE)

    def _table(self) -> str:
        figures = list(dict.fromkeys(name for row in self.rows for name in row.quality))
        text = StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(["name", "scan", "status", "error", "warnings", "seconds", *figures])
        for row in self.rows:
            seconds = "" if row.seconds is None else f"{row.seconds:.3f}"
            about = [row.name, row.scan, row.status, row.error, "; ".join(row.warnings), seconds]
            table.writerow([*about, *(row.quality.get(name, "") for name in figures)])
        return text.getvalue()


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
