"""One page's connection: what waits to be sent to it, and what came from it for the engine.

The event loop only moves bytes; the session's work is done by the engine, one thing after the
other. Neither a page that does not read nor one that writes without end makes either of them hold
more than a bounded amount of memory.
"""

from __future__ import annotations

import asyncio
import itertools
import logging
from collections import deque
from collections.abc import Callable, Hashable
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from numpy.typing import NDArray
from starlette.websockets import WebSocket, WebSocketDisconnect

from henkei.errors import HenkeiError, InvalidInput
from henkei.studio.messages import Message, decode, encode
from henkei.studio.shown import Shown

WINDOW = 2  # frames sent and not acknowledged
KINDS = ("hello", "do", "live", "grab", "drop", "ack", "undo", "redo", "cancel")
_ENDS_LIVE = ("do", "drop", "undo", "redo")  # a live message that still waits is then out of date

MOST_MESSAGES, MOST_BYTES = 10_000, 256 << 20  # that wait for a page before it is given up
EASY_MESSAGES, EASY_BYTES = 64, 32 << 20  # up to which more is read from a page
SLOWEST_SEND = 60.0  # seconds
LAST_WORDS = 1.0  # seconds
TRY_AGAIN_LATER = 1013  # the close code, of RFC 6455's registry
_LARGE = 1 << 20  # bytes of positions, from which on a frame is made aside from the event loop
_LONGEST_ANSWER = 1000  # characters
_FAR_BEHIND = "the page is too far behind; it may come back"

_LOG = logging.getLogger(__name__)
Submit = Callable[..., "Future[Any]"]


class Session(Protocol):
    """What a studio serves.

    Its methods run on the engine's thread, but for ``uploaded`` and ``data``.
    """

    def connected(self, client: Client) -> None:
        """A page has come."""

    def disconnected(self, client: Client) -> None:
        """A page has gone."""

    def receive(self, client: Client, message: Message) -> None:
        """Do what a message says and answer it through the client."""

    def live(self, client: Client, message: Message) -> None:
        """The same for the latest live message; those before it may never have come."""

    def uploaded(self, path: Path, name: str) -> dict[str, Any]:
        """Open a file, which is removed after that; on a thread for uploads, may take long."""

    def export(self, request: dict[str, Any]) -> dict[str, Any]:
        """Begin to write a file."""

    def data(self, blob: str) -> Path | None:
        """The file of a blob."""

    def download(self, ident: str) -> tuple[Path, str] | None:
        """The file of an export, and its name."""

    def open(self, path: Path) -> None:
        """Open a file of this machine."""

    def close(self) -> None:
        """The studio ends."""


class Load:
    """How many messages, and bytes, wait somewhere."""

    def __init__(self) -> None:
        self._messages = self._bytes = 0
        self._less = asyncio.Event()

    def add(self, size: int) -> None:
        """One more."""
        self._messages += 1
        self._bytes += size

    def remove(self, size: int) -> None:
        """One less."""
        self._messages -= 1
        self._bytes -= size
        self._less.set()

    def exceeds(self, messages: int, size: int) -> bool:
        """Whether more than that wait; a single message may be of any size."""
        return self._messages > messages or (self._messages > 1 and self._bytes > size)

    async def eased(self) -> None:
        """Wait until little waits."""
        while self.exceeds(EASY_MESSAGES, EASY_BYTES):
            self._less.clear()
            await self._less.wait()


class Frame(NamedTuple):
    """Where a surface is now; what of it the page lacks is found out when it is sent."""

    number: int
    header: dict[str, Any]
    arrays: dict[str, NDArray[Any]]


class Outbox:
    """What waits to be sent: lasting messages in their order, and the latest frame of each surface.

    At most :data:`WINDOW` frames are under way; the others wait, and what came after them goes
    first. A frame that waits makes way for a newer one of the same surface, and for any state,
    after which it would be out of date. Used on the event loop only.
    """

    def __init__(self) -> None:
        self.load = Load()
        self.overrun = asyncio.Event()
        self._lasting: deque[tuple[int, bytes]] = deque()
        self._frames: dict[Hashable, Frame] = {}  # oldest first
        self._under_way: set[int] = set()
        self._numbers = itertools.count(1)
        self._news = asyncio.Event()
        self._closed = False

    def put(self, data: bytes) -> None:
        """A message that is never dropped, as long as the page follows at all."""
        if self._closed:
            return
        self._lasting.append((next(self._numbers), data))
        self.load.add(len(data))
        self._news.set()
        if self.load.exceeds(MOST_MESSAGES, MOST_BYTES):
            self.close()
            self.overrun.set()

    def put_state(self, data: bytes) -> None:
        """The same for a state."""
        self._frames.clear()
        self.put(data)

    def put_frame(self, header: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> None:
        """A frame of the surface that ``tab`` and ``surface`` of its header name."""
        if not self._closed:
            surface = (header.get("tab"), header.get("surface"))
            self._frames.pop(surface, None)
            self._frames[surface] = Frame(next(self._numbers), header, arrays)
            self._news.set()

    def acknowledge(self, number: int) -> None:
        """The page has drawn a frame."""
        self._under_way.discard(number)
        self._news.set()

    def takes_frames(self) -> bool:
        """Whether the next frame would go out at once."""
        return not self._frames and len(self._under_way) < WINDOW

    def pop(self) -> bytes | Frame | None:
        """What is to be sent now, if anything."""
        first = self._lasting[0][0] if self._lasting else None
        if self._frames and len(self._under_way) < WINDOW:
            surface, frame = next(iter(self._frames.items()))
            if first is None or frame.number < first:
                del self._frames[surface]
                self._under_way.add(frame.number)
                return frame
        if first is None:
            return None
        _, data = self._lasting.popleft()
        self.load.remove(len(data))
        return data

    async def next(self) -> bytes | Frame:
        """What is to be sent now, as soon as there is something."""
        while (item := self.pop()) is None:
            self._news.clear()
            await self._news.wait()
        return item

    def close(self) -> None:
        """Let go of everything, and take nothing more."""
        self._closed = True
        self._lasting.clear()
        self._frames.clear()


class Client:
    """A page, for the session. Any thread may call; once the page has gone, nothing happens."""

    def __init__(self, outbox: Outbox) -> None:
        self._outbox, self._loop = outbox, asyncio.get_running_loop()

    def send(self, header: dict[str, Any], **arrays: NDArray[Any]) -> None:
        """Send a message that is never dropped."""
        self._post(self._outbox.put, encode(header, **arrays))

    def state(self, header: dict[str, Any], **arrays: NDArray[Any]) -> None:
        """Send a state; frames that have not been sent yet are dropped."""
        self._post(self._outbox.put_state, encode({**header, "kind": "state"}, **arrays))

    def frame(self, header: dict[str, Any], **arrays: NDArray[Any]) -> None:
        """Send the ``positions`` of a surface, all of them, unless newer ones come before.

        The header is that of :meth:`henkei.studio.shown.Shown.frame`. The array is kept until then,
        and must stay as it is.
        """
        self._post(self._outbox.put_frame, header, arrays)

    def _post(self, put: Callable[..., None], *arguments: Any) -> None:
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(put, *arguments)


class Link:
    """A connection between one page and a session.

    Parameters
    ----------
    socket : accepted already.
    session : what the page looks at.
    submit : ``submit(function, *arguments)`` has the engine do it.
    """

    def __init__(self, socket: WebSocket, session: Session, submit: Submit) -> None:
        self._socket, self._session, self._submit = socket, session, submit
        self._loop = asyncio.get_running_loop()
        self._outbox = Outbox()
        self._client = Client(self._outbox)
        self._shown = Shown()
        self._in_work = Load()
        self._latest: deque[Message] = deque(maxlen=1)  # the live message that waits
        self._living = False  # the engine has been asked to look at it

    async def run(self) -> None:
        """Serve the page until it goes, or follows so slowly that it is sent away to come back."""
        await self._engine(self._session.connected)
        try:
            reason = await self._exchange()
            if reason:
                with suppress(TimeoutError, WebSocketDisconnect):
                    async with asyncio.timeout(LAST_WORDS):
                        await self._socket.close(TRY_AGAIN_LATER, reason)
        finally:
            self._latest.clear()
            self._outbox.close()
            await self._engine(self._session.disconnected)

    async def _exchange(self) -> str:
        """Send and receive until either ends; why the page is to be sent away, if it is."""
        works = self._send_all(), self._receive_all(), self._outbox.overrun.wait()
        tasks = [asyncio.ensure_future(work) for work in works]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        try:
            for task in done:
                task.result()
        except WebSocketDisconnect:
            return ""
        except TimeoutError:
            return _FAR_BEHIND
        return _FAR_BEHIND if self._outbox.overrun.is_set() else ""

    async def _send_all(self) -> None:
        while True:
            item = await self._outbox.next()
            data = item if isinstance(item, bytes) else await self._made(item)
            async with asyncio.timeout(SLOWEST_SEND):
                await self._socket.send_bytes(data)
            self._look_at_live()

    async def _made(self, frame: Frame) -> bytes:
        """The message that brings the page to where a surface is."""
        shown, (number, header, arrays) = self._shown, frame

        def make() -> bytes:
            told, moved = shown.frame({**header, "kind": "frame", "number": number}, **arrays)
            return encode(told, **moved)

        large = arrays["positions"].nbytes > _LARGE
        return await asyncio.to_thread(make) if large else make()

    async def _receive_all(self) -> None:
        while True:
            await self._in_work.eased()
            await self._outbox.load.eased()
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            try:
                if data is None:
                    raise InvalidInput("a message is binary, not text")
                self._take(_checked(decode(data)), len(data))
            except InvalidInput as error:
                self._outbox.put(encode(_refused(None, str(error))))

    def _take(self, message: Message, size: int) -> None:
        if message.kind == "ack":
            self._outbox.acknowledge(message.header["number"])
        elif message.kind == "live":
            self._latest.append(message)
        else:
            if message.kind in _ENDS_LIVE:
                self._latest.clear()
            if message.kind == "hello":  # the page has nothing
                self._shown = Shown(message.header.get("bits", 32))
            self._in_work.add(size)
            done = asyncio.wrap_future(self._submit(self._work, self._session.receive, message))
            done.add_done_callback(lambda _: self._in_work.remove(size))
        self._look_at_live()

    def _look_at_live(self) -> None:
        """Ask the engine to, if a live message waits and its frame would go out at once."""
        if self._latest and not self._living and self._outbox.takes_frames():
            self._living = True
            asyncio.wrap_future(self._submit(self._live)).add_done_callback(self._lived)

    def _lived(self, _: Any) -> None:
        self._living = False
        self._look_at_live()

    def _live(self) -> None:
        """On the engine: what is the latest by now."""
        with suppress(IndexError):
            self._work(self._session.live, self._latest.pop())

    def _work(self, done: Callable[[Client, Message], None], message: Message) -> None:
        """On the engine: a mistake in it is answered, and ends neither the studio nor the page."""
        try:
            done(self._client, message)
        except HenkeiError as error:
            self._client.send(_refused(message.header.get("id"), str(error)))
        except Exception as error:
            _LOG.exception("a message of kind %s failed", message.kind)
            told = f"this failed inside henkei ({type(error).__name__}: {error}); try another way"
            self._client.send(_refused(message.header.get("id"), told))

    async def _engine(self, told: Callable[[Client], None]) -> None:
        await asyncio.shield(asyncio.wrap_future(self._submit(told, self._client)))


def _refused(ident: Any, message: str) -> dict[str, Any]:
    return {"kind": "refused", "id": ident, "message": message[:_LONGEST_ANSWER]}


def _checked(message: Message) -> Message:
    """A message whose kind is known, with a usable ``id`` and ``number``.

    Raises
    ------
    InvalidInput : it is not.
    """
    if message.kind not in KINDS:
        raise InvalidInput(
            f"no message is of kind {message.kind[:20]!r}; known are {', '.join(KINDS)}"
        )
    ident = message.header.get("id")
    if not (ident is None or _is_number(ident) or (isinstance(ident, str) and len(ident) <= 64)):
        raise InvalidInput("the id of a message is a whole number or up to 64 characters")
    if message.kind == "hello" and message.header.get("bits", 32) not in (16, 32):
        raise InvalidInput("the bits of a coordinate are 16 or 32")
    if message.kind == "ack" and not _is_number(message.header.get("number")):
        raise InvalidInput("an ack says the number of a frame")
    return message


def _is_number(value: Any) -> bool:
    return type(value) is int and abs(value) < 1 << 53
