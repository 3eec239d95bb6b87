"""The pages that look at a session, and what they are told."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from henkei.errors import HenkeiError, InvalidInput
from henkei.mesh import Floats
from henkei.studio import exports
from henkei.studio.document import TABS, Document
from henkei.studio.drawables import normalised
from henkei.studio.packing import packed
from henkei.studio.services import Services
from henkei.studio.tabs.base import Basis, TabState

LONG, OFTEN = 0.3, 0.1  # seconds until progress is shown, and between two of its messages
BROKEN = (
    "this cannot be shown, which is a fault of ours. Undo the last step to go on, and please "
    "report it with what the terminal says"
)
_LOG = logging.getLogger(__name__)


class Client(Protocol):
    """A page, as :mod:`henkei.studio.link` has it. Its methods may be called from any thread."""

    def state(self, header: dict[str, Any], **arrays: NDArray[Any]) -> None:
        """Send what is never left out."""

    def frame(self, header: dict[str, Any], **arrays: NDArray[Any]) -> None:
        """Send all positions of a surface, unless newer ones come before there is room."""

    def send(self, header: dict[str, Any], **arrays: NDArray[Any]) -> None:
        """Send an answer."""


class Pages:
    """All pages of a session; each is sent only the tabs that changed since it was told last.

    revision : counts what they were told.
    """

    def __init__(self, services: Services) -> None:
        self.revision = 0
        self._services = services
        self._clients: dict[Client, dict[str, Any]] = {}  # the entries of tabs that each has
        self._entries: dict[str, tuple[Any, dict[str, Any]]] = {}

    def add(self, client: Client) -> None:
        """A page has come, or knows nothing any more."""
        self._clients[client] = {}

    def remove(self, client: Client) -> None:
        """A page has gone."""
        self._clients.pop(client, None)

    def forget(self) -> None:
        """Another document is open: no page has anything of it."""
        self._entries.clear()
        for client in self._clients:
            self._clients[client] = {}

    def renew(self, tab: str) -> None:
        """The view of a tab is another one though its state is not."""
        self._entries.pop(tab, None)

    def tell(self, header: dict[str, Any]) -> None:
        """Send all of them a message."""
        for client in list(self._clients):
            client.send(header)

    def publish(self, document: Document, front: str, header: Mapping[str, Any]) -> None:
        """Tell all of them what is now.

        Parameters
        ----------
        front : the tab in front, whose view is made.
        header : what there is to tell beside the document.
        """
        self.revision += 1
        entries = {tab: self._entry(document, tab, tab == front) for tab in TABS}
        told = {
            "kind": "state",
            "revision": self.revision,
            "tab": front,
            "meshes": [entry.model_dump() for entry in document.meshes],
            "examples": [],
            **header,
        }
        for client, known in self._clients.items():
            new = {tab: one for tab, one in entries.items() if known.get(tab) is not one}
            unchanged = [tab for tab in TABS if tab not in new]
            client.state({**told, "tabs": new, "unchanged": unchanged})
            self._clients[client] = entries
        try:
            self.show_positions(document, front, exact=True)
        except Exception as error:  # what was done is done, and its state is told
            _LOG.exception("the surfaces of %s have no positions", front)
            message = str(error) if isinstance(error, HenkeiError) else BROKEN
            self.tell({"kind": "notice", "level": "error", "message": message})

    def show_positions(
        self,
        document: Document,
        tab: str,
        *,
        exact: bool,
        sequence: Any = None,
        but: Client | None = None,
    ) -> None:
        """Bring the surfaces of a tab that move to where they are now, ``but`` on one page."""
        if not self._clients.keys() - {but}:
            return
        for key, positions in self._positions(document, tab).items():
            data = self._drawn(tab, key)
            if data is not None:
                placed = normalised(positions, *self._services.frame(data))
                header = {"tab": tab, "surface": key, "data": data, "exact": exact}
                self.show_surface({**header, "sequence": sequence}, placed, but=but)

    def show_surface(
        self, header: dict[str, Any], positions: NDArray[Any], *, but: Client | None = None
    ) -> None:
        """Bring one surface to positions (n, 3) as pages have them."""
        for client in self._clients:
            if client is not but:
                client.frame({"kind": "frame", **header}, positions=positions)

    def send_basis(self, client: Client, tab: str, basis: Basis, asked: Mapping[str, Any]) -> None:
        """Tell a page how a surface answers the drag that it begins."""
        centre, scale = self._services.frame(str(self._drawn(tab, basis.surface)))
        header = {"kind": "basis", "tab": tab, "surface": basis.surface, "scale": scale}
        client.send(
            {**asked, **header},
            start=normalised(basis.start, centre, scale),
            response=basis.response.astype(np.float32),
        )

    def _entry(self, document: Document, tab: str, front: bool) -> dict[str, Any]:
        """State and view of a tab as pages get them; the view only of the one in front."""
        state = document.tab(tab)
        key = (state, document.meshes, front)
        known = self._entries.get(tab)
        if known is None or any(a is not b for a, b in zip(known[0], key, strict=True)):
            view = self._view(tab, state) if front else {"surfaces": {}}
            entry = {"state": state.model_dump(mode="json"), "view": view}
            with suppress(InvalidInput):  # the disk refuses blobs
                entry = packed(entry, self._services.blobs)
            self._entries[tab] = known = (key, _finite(entry))
        return known[1]

    def _view(self, tab: str, state: TabState) -> dict[str, Any]:
        """The view of a tab; a mistake in it ends neither the session nor its pages."""
        try:
            view: dict[str, Any] = _plain(TABS[tab].view(state, self._services))
        except HenkeiError as error:
            return {"surfaces": {}, "problem": str(error)}
        except Exception:
            _LOG.exception("%s has no view", tab)
            return {"surfaces": {}, "problem": BROKEN}
        if all(state.meshes.values()):
            view["exports"] = exports.listed(tab, done=state.made is not None)
        return view

    def _positions(self, document: Document, tab: str) -> dict[str, Floats]:
        """Of the surfaces that move; none while something is wrong, which the view tells."""
        if "problem" in self._entries.get(tab, ((), {"view": {}}))[1]["view"]:
            return {}
        return TABS[tab].frames(document.tab(tab), self._services)

    def _drawn(self, tab: str, surface: str) -> str | None:
        """The blob that pages draw under a key of a view."""
        known = self._entries.get(tab)
        drawn = known[1]["view"].get("surfaces", {}).get(surface) if known else None
        return None if drawn is None else str(drawn["data"])


class EngineProgress:
    """Progress of what the engine does itself, shown once it takes long."""

    def __init__(self, tell: Callable[[dict[str, Any]], None]) -> None:
        self._tell, self._start, self._told = tell, time.monotonic(), 0.0

    def __call__(self, message: str, fraction: float) -> None:
        now = time.monotonic()
        if now - self._start > LONG and now - self._told > OFTEN:
            self._told = now
            told = {"kind": "progress", "job": "engine", "title": "Working", "cancellable": False}
            self._tell({**told, "message": message, "fraction": fraction})

    def end(self) -> None:
        """Nothing is shown any more."""
        if self._told:
            told = {"kind": "ended", "job": "engine", "outcome": "done", "message": ""}
            self._tell(told)


def _plain(data: Any) -> Any:
    """Plain data with lists in place of arrays."""
    if isinstance(data, dict):
        return {key: _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, np.ndarray | np.generic):
        return data.tolist()
    return data


def _finite(data: Any) -> Any:
    """Plain data with None in place of what is no number, which JSON cannot hold."""
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_finite(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data
