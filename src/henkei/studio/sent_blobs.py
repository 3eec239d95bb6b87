"""The store of a worker that cannot write: what it puts there goes through the studio."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from henkei.studio.blobs import Blobs


class SentBlobs(Blobs):
    """Messages, surfaces and other bytes are sent; results of methods cannot be put.

    send : sends a message to the studio, which keeps the array ``data`` of a ``blob``.
    """

    def __init__(self, folder: str | Path, send: Callable[..., None]) -> None:
        super().__init__(folder)
        self._send = send

    def put(self, data: bytes) -> str:
        """Have these bytes kept; the answer is their id, by which they cannot yet be got."""
        self._send({"kind": "blob"}, data=np.frombuffer(data, np.uint8))
        return hashlib.sha256(data).hexdigest()[:32]
