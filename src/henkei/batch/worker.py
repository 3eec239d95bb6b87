"""Loaded first by the worker processes on this machine."""

from __future__ import annotations

import signal
from typing import Any


def dask_setup(worker: Any) -> None:
    """Leave an interrupt from the keyboard to the process that asked; it ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
