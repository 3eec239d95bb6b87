"""A session on a thread of its own, and what a page of it is told, for tests."""

from __future__ import annotations

import itertools
import queue
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import henkei as hk
from henkei.progress import silent
from henkei.shapes import bumper, bumper_parts
from henkei.studio.examples import example
from henkei.studio.messages import Message
from henkei.studio.session import Session
from henkei.studio.tasks import example as task

LIMIT = 60.0  # seconds that anything may take
_IDENTS = itertools.count(1)  # of messages, as pages have them: no two are the same


class Page:
    """Stands for a page: what it was told."""

    def __init__(self) -> None:
        self.told: queue.Queue[tuple[dict[str, Any], dict[str, Any]]] = queue.Queue()
        self.last: dict[str, Any] = {}
        self.tabs: dict[str, Any] = {}
        self.positions: dict[str, Any] = {}
        self.exact: dict[str, bool] = {}

    def send(self, header: dict[str, Any], **arrays: Any) -> None:
        self.told.put((header, arrays))

    def state(self, header: dict[str, Any], **arrays: Any) -> None:
        self.last = header
        self.tabs |= header["tabs"]

    def frame(self, header: dict[str, Any], **arrays: Any) -> None:
        self.positions[header["surface"]] = arrays["positions"]
        self.exact[header["surface"]] = header["exact"]

    def until(self, kind: str) -> dict[str, Any]:
        while True:
            header, _ = self.told.get(timeout=LIMIT)
            if header["kind"] == kind:
                return header


class Studio:
    """A session on a thread of its own, and a page that looks at it."""

    def __init__(self, folder: Path) -> None:
        self.work: queue.Queue[Any] = queue.Queue()
        self.thread = threading.Thread(target=self._run)
        self.thread.start()
        self.session = self.on_engine(lambda: Session(folder, self.work.put))
        self.page = Page()
        self.ident = 0
        self.on_engine(lambda: self.session.connected(self.page))
        self.receive("hello", session=None)

    def _run(self) -> None:
        while (work := self.work.get()) is not None:
            work()

    def on_engine(self, work: Any) -> Any:
        answer: queue.Queue[Any] = queue.Queue()

        def run() -> None:
            try:
                answer.put((work(), None))
            except BaseException as error:
                answer.put((None, error))

        self.work.put(run)
        value, error = answer.get(timeout=LIMIT)
        if error is not None:
            raise error
        return value

    def receive(self, kind: str, **header: Any) -> dict[str, Any]:
        self.ident = next(_IDENTS)
        message = Message({"kind": kind, "id": self.ident, **header})
        self.on_engine(lambda: self.session.receive(self.page, message))
        while True:
            told, _ = self.page.told.get(timeout=LIMIT)
            if told.get("id") == self.ident:
                return told

    def do(self, tab: str, action: str, **arguments: Any) -> dict[str, Any]:
        return self.receive("do", tab=tab, action=action, arguments=arguments)

    def example(self, name: str) -> None:
        """Open a built-in example that is made here, which is quicker than in a worker."""
        report: Any = SimpleNamespace(progress=silent)
        made = task.run({"name": name}, self.session._services.blobs, report)
        self.on_engine(lambda: self.session.desk.take_example(example(name), **made))

    def live(self, tab: str, action: str, **arguments: Any) -> None:
        message = Message(
            {"kind": "live", "tab": tab, "action": action, "sequence": 7, "arguments": arguments}
        )
        self.on_engine(lambda: self.session.live(self.page, message))

    def close(self, *, kill: bool = False) -> None:
        if not kill:
            self.on_engine(self.session.close)
        self.work.put(None)
        self.thread.join()


def opened(studio: Studio, tmp_path: Path, surface: Any, name: str = "mesh.obj") -> dict[str, Any]:
    path = tmp_path / name
    hk.write(path, surface)
    answer: dict[str, Any] = studio.session.uploaded(path, name)
    return answer


def bending(studio: Studio, tmp_path: Path) -> None:
    """A bumper whose sides stay and whose emblem is a handle."""
    parts = bumper_parts()
    studio.do("document", "show", name="deform")
    opened(studio, tmp_path, bumper())
    for kind, region in (("fixed", "sides"), ("handles", "handle")):
        studio.do("deform", "select_vertices", vertices=parts[region].tolist())
        assert studio.do("deform", "add", kind=kind)["kind"] == "done"
