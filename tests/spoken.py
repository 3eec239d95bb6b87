"""A page without a browser: what it says to a running studio, and what it is told."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any

import httpx
from websockets.sync.client import ClientConnection, connect

from driven import RunningStudio
from henkei.studio.messages import Message, decode, encode
from served import plain_client

PATIENCE = 60.0  # seconds that an answer may take
_IDS = count(1)  # of messages: no two are the same


class Page:
    """A WebSocket to a studio; frames are acknowledged, and the latest state is kept."""

    def __init__(self, socket: ClientConnection, session: str | None = None) -> None:
        self._socket = socket
        self.state: dict[str, Any] = {}
        self.tabs: dict[str, Any] = {}
        self.say(kind="hello", session=session)
        self.until("state")

    def say(self, **header: Any) -> None:
        """Send a message."""
        self.send(encode(header))

    def send(self, data: bytes) -> None:
        """Send bytes, whatever they are."""
        self._socket.send(data)

    def hear(self) -> Message:
        """The next message."""
        data = self._socket.recv(timeout=PATIENCE)
        assert isinstance(data, bytes)
        message = decode(data)
        if message.kind == "frame":
            self.say(kind="ack", number=message.header["number"])
        elif message.kind == "state":
            self.state = message.header
            self.tabs |= message.header["tabs"]
        return message

    def until(self, kind: str) -> Message:
        """The next message of a kind."""
        while (message := self.hear()).kind != kind:
            pass
        return message

    def ask(self, kind: str, **header: Any) -> Message:
        """Send a message and wait for its answer."""
        ident = f"asked {next(_IDS)}"
        self.say(kind=kind, id=ident, **header)
        while (message := self.hear()).header.get("id") != ident:
            pass
        return message

    def do(self, tab: str, action: str, **arguments: Any) -> None:
        """Do an action, which is not refused."""
        answer = self.ask("do", tab=tab, action=action, arguments=arguments)
        assert answer.kind == "done", answer.header


@contextmanager
def speaking(studio: RunningStudio) -> Iterator[Page]:
    """A page of a studio."""
    address = studio.address.replace("http", "ws", 1).replace("/?", "/ws?")
    with connect(
        address, compression=None, max_size=None, proxy=None, ping_interval=None
    ) as socket:
        yield Page(socket)


@contextmanager
def requesting(studio: RunningStudio) -> Iterator[httpx.Client]:
    """A client whose requests have the studio's token."""
    base, token = studio.address.split("/?token=")
    with plain_client(base_url=base, headers={"X-Token": token}, timeout=PATIENCE) as client:
        yield client


def upload(client: httpx.Client, name: str, data: bytes) -> dict[str, Any]:
    """What a studio answers to a file."""
    answer = client.post("/upload", params={"name": name}, content=data)
    assert answer.status_code == 200, answer.text
    told: dict[str, Any] = answer.json()
    return told
