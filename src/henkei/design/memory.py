"""Whether levels fit in memory, found out before any is made."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from henkei.errors import InvalidInput

PER_VERTEX = 1000  # bytes of faces, operators and shapes of a level, by its vertices


def require_memory(sizes: Sequence[tuple[int, int, int]]) -> None:
    """Raise InvalidInput for levels of these vertices, edges and faces, coarse to fine, that the
    machine has no memory for."""
    room = available_memory()
    if room is None:
        return
    needed = 0
    for level, (vertices, _, faces) in enumerate(sizes):
        needed += PER_VERTEX * vertices
        if needed > room:
            raise InvalidInput(
                f"level {level} has {vertices:,} vertices and {faces:,} faces and would take about "
                f"{needed / 2**30:,.1f} GiB of memory, of which {room / 2**30:,.1f} GiB are free; "
                f"use fewer levels: at most {level - 1}"
            )


def available_memory() -> int | None:
    """Bytes that can still be had; None where the system doesn't say."""
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024 * int(line.split()[1])
    except (OSError, ValueError):
        pass
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None
