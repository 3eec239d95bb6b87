"""A studio served to tests: a session that only notes what it was asked, and pages."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import httpx
from websockets.sync.client import ClientConnection, connect

from henkei.studio.engine import Engine
from henkei.studio.messages import Message, decode, encode
from henkei.studio.security import Access
from henkei.studio.server import Settings, app, listening, server, url

TOKEN = "a-token-for-the-tests"


@dataclass
class Noting:
    """A session that notes what comes and on which thread; what is set below happens on top."""

    folder: Path = Path()
    noted: list[tuple[str, Any]] = field(default_factory=list)
    threads: set[str] = field(default_factory=set)
    clients: list[Any] = field(default_factory=list)
    on_receive: Callable[[Any, Message], None] = lambda client, message: client.send(
        {"kind": "done", "id": message.header.get("id")}
    )
    on_live: Callable[[Any, Message], None] = lambda client, message: None
    on_upload: Callable[[Path, str], dict[str, Any]] = lambda path, name: {"mesh": "m1"}
    on_export: Callable[[dict[str, Any]], dict[str, Any]] = lambda request: {"job": "j1"}
    files: dict[str, tuple[Path, str]] = field(default_factory=dict)

    def connected(self, client: Any) -> None:
        self._note("connected", client)
        self.clients.append(client)

    def disconnected(self, client: Any) -> None:
        self._note("disconnected", client)

    def receive(self, client: Any, message: Message) -> None:
        self._note("receive", message)
        self.on_receive(client, message)

    def live(self, client: Any, message: Message) -> None:
        self._note("live", message)
        self.on_live(client, message)

    def uploaded(self, path: Path, name: str) -> dict[str, Any]:
        self.noted.append(("uploaded", (path, name, path.read_bytes())))
        return self.on_upload(path, name)

    def export(self, request: dict[str, Any]) -> dict[str, Any]:
        self._note("export", request)
        return self.on_export(request)

    def data(self, blob: str) -> Path | None:
        self._note("data", blob)
        path = self.folder / blob
        return path if path.exists() else None

    def download(self, ident: str) -> tuple[Path, str] | None:
        self._note("download", ident)
        return self.files.get(ident)

    def open(self, path: Path) -> None:
        self._note("open", path)

    def close(self) -> None:
        self._note("close", None)

    def all(self, what: str) -> list[Any]:
        """What was noted of a kind."""
        return [value for name, value in self.noted if name == what]

    def _note(self, what: str, value: Any) -> None:
        self.noted.append((what, value))
        self.threads.add(threading.current_thread().name)


@dataclass(frozen=True)
class Served:
    """A running studio."""

    session: Noting
    engine: Engine
    http: httpx.Client
    port: int

    @contextmanager
    def page(self, **settings: Any) -> Iterator[ClientConnection]:
        """A page that has connected."""
        address = f"ws://127.0.0.1:{self.port}/ws?token={TOKEN}"
        with connect(address, compression=None, max_size=None, proxy=None, **settings) as page:
            yield page


@contextmanager
def served(session: Noting, **settings: Any) -> Iterator[Served]:
    """A studio on a free port, in a thread; settings are those of the server."""
    given = replace(Settings(Access(TOKEN)), **settings)
    engine = Engine(lambda post: session)
    listener = listening("127.0.0.1", 0)
    port = int(listener.getsockname()[1])
    running = server(app(engine, given))
    thread = threading.Thread(target=running.run, kwargs={"sockets": [listener]})
    thread.start()
    base = url(listener, given.access).split("?")[0]
    try:
        with plain_client(base_url=base, params={"token": TOKEN}) as http:
            yield Served(session, engine, http, port)
    finally:
        running.should_exit = True
        thread.join()
        listener.close()


def plain_client(**settings: Any) -> httpx.Client:
    """A client that knows no proxies and, to start quickly, no certificates."""
    return httpx.Client(trust_env=False, verify=False, **settings)


def say(page: ClientConnection, **header: Any) -> None:
    """Send a message."""
    page.send(encode(header))


def hear(page: ClientConnection, kind: str | None = None) -> Message:
    """The next message (of a kind)."""
    while True:
        data = page.recv(timeout=30)
        assert isinstance(data, bytes)
        message = decode(data)
        if kind in (None, message.kind):
            return message


def until(condition: Callable[[], bool]) -> None:
    """Wait for something that another thread does."""
    waiting = threading.Event()
    for _ in range(3000):
        if condition():
            return
        waiting.wait(0.01)
    raise AssertionError("it never came")
