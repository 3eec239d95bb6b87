"""A page's connection: order, the window of frames, the latest live message, and its bounds."""

from __future__ import annotations

import asyncio
import json
import threading
import tracemalloc
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from starlette.websockets import WebSocketDisconnect

import apart
from henkei.errors import Infeasible
from henkei.studio import link
from henkei.studio.engine import Worker
from henkei.studio.link import WINDOW, Link, Outbox
from henkei.studio.messages import LONGEST_HEADER, Message, decode, encode
from served import Noting

POSITIONS = np.zeros((4, 3), np.float32)


class Socket:
    """The server's end of a WebSocket whose page is the test."""

    def __init__(self) -> None:
        self._to_server: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self._to_page: asyncio.Queue[bytes] = asyncio.Queue()
        self.reads = asyncio.Event()
        self.reads.set()
        self.closed: tuple[int, str] | None = None
        self.taken = 0

    async def receive(self) -> dict[str, Any]:
        event = await self._to_server.get()
        self.taken += 1
        return event

    async def send_bytes(self, data: bytes) -> None:
        await self.reads.wait()
        self._to_page.put_nowait(data)

    async def close(self, code: int, reason: str) -> None:
        self.closed = (code, reason)

    def say(self, **header: Any) -> None:
        self.say_bytes(encode(header))

    def say_bytes(self, data: bytes | str) -> None:
        kind = "bytes" if isinstance(data, bytes) else "text"
        self._to_server.put_nowait({"type": "websocket.receive", kind: data})

    def leave(self) -> None:
        self._to_server.put_nowait({"type": "websocket.disconnect", "code": 1001})

    async def hear(self) -> Message:
        return decode(await asyncio.wait_for(self._to_page.get(), 30))

    def unheard(self) -> list[Message]:
        return [decode(self._to_page.get_nowait()) for _ in range(self._to_page.qsize())]


class Bench:
    """A link under test, with the thread of its engine."""

    def __init__(self, session: Noting) -> None:
        self.session, self.socket = session, Socket()
        self.engine = Worker("engine")
        self.engine.start()
        self.link = Link(self.socket, session, self.engine.submit)  # type: ignore[arg-type]

    async def settled(self) -> None:
        """All that was said has been read, worked on and answered, as far as it can be."""
        for _ in range(6):
            for _ in range(20):
                await asyncio.sleep(0)
            await self.engine.run(lambda: None)

    async def refused(self) -> str:
        """What the next refusal says."""
        message = await self.socket.hear()
        assert message.kind == "refused"
        return str(message.header["message"])


def linked(session: Noting, test: Callable[[Bench], Awaitable[None]]) -> None:
    """Run a test on a link; it ends as the page leaves, and the session is told."""

    async def run() -> None:
        bench = Bench(session)
        running = asyncio.create_task(bench.link.run())
        try:
            await bench.settled()
            await test(bench)
            bench.socket.leave()
            await asyncio.wait_for(running, 30)
        finally:
            bench.engine.end()

    apart.run(run())
    (client,) = session.all("connected")
    assert session.all("disconnected") == [client]
    assert session.threads == {"engine"}


class Busy:
    """Keeps the engine busy until it is freed."""

    def __init__(self) -> None:
        self.free = threading.Event()

    def __call__(self, client: Any, message: Message) -> None:
        assert self.free.wait(30)


def frame(client: Any, message: Message) -> None:
    header = {"tab": "deform", "surface": "s", "sequence": message.header["sequence"]}
    client.frame(header, positions=POSITIONS)


# What is sent


def test_all_but_frames_come_in_their_order_however_slow_the_page():
    session = Noting()

    async def test(bench: Bench) -> None:
        bench.socket.reads.clear()
        (client,) = session.clients
        for k in range(300):
            (client.state if k % 3 else client.send)({"kind": "notice", "revision": k})
        await bench.settled()
        assert not bench.socket.unheard()
        bench.socket.reads.set()
        heard = [await bench.socket.hear() for _ in range(300)]
        assert [m.header["revision"] for m in heard] == list(range(300))
        assert [m.kind for m in heard[:4]] == ["notice", "state", "state", "notice"]

    linked(session, test)


@pytest.mark.parametrize("count", [4, 100_000])
def test_a_frame_says_what_the_page_lacks_whatever_was_left_out_before(count):
    """Also where it is large, and made aside."""
    session = Noting()
    positions = np.arange(3 * count, dtype=np.float32).reshape(count, 3)

    async def test(bench: Bench) -> None:
        (client,) = session.clients
        page = np.zeros_like(positions)
        heard = []
        for k in range(20):
            positions[k % 4] += 1
            client.frame({"tab": "quad", "surface": "a", "data": "d"}, positions=positions.copy())
            if k in (0, 1, 19):
                bench.socket.say(kind="ack", number=heard[-1] if heard else 0)
                message = await bench.socket.hear()
                heard.append(message.header["number"])
                page[message.arrays.get("ids", slice(None))] = message.arrays["positions"]
                np.testing.assert_array_equal(page, positions)
                assert len(message.arrays["positions"]) == {0: count, 1: 1, 19: 4}[k]
        assert heard == sorted(set(heard))

    linked(session, test)


def test_a_slow_link_gets_frames_of_16_bits_from_its_hello_on():
    session = Noting()

    async def test(bench: Bench) -> None:
        bench.socket.say(kind="hello", id=1, bits=16)
        await bench.socket.hear()
        for exact in (False, True):
            header = {"tab": "quad", "surface": "a", "exact": exact}
            session.clients[0].frame(header, positions=np.eye(3, dtype=np.float32))
            message = await bench.socket.hear()
            assert message.header["bits"] == (32 if exact else 16)
        for bits in (8, "16", None, True):
            bench.socket.say(kind="hello", bits=bits)
            assert "16 or 32" in await bench.refused()

    linked(session, test)


def test_no_more_frames_are_under_way_than_the_window_takes():
    session = Noting(on_live=frame)

    async def test(bench: Bench) -> None:
        for k in range(10):
            bench.socket.say(kind="live", sequence=k)
            await bench.settled()
        heard = bench.socket.unheard()
        assert [m.header["sequence"] for m in heard] == [0, 1]
        assert [m.header["sequence"] for m in session.all("live")] == [0, 1]
        bench.socket.say(kind="ack", number=12345)
        await bench.settled()
        assert not bench.socket.unheard()
        bench.socket.say(kind="ack", number=heard[0].header["number"])
        await bench.settled()
        (latest,) = bench.socket.unheard()
        assert latest.header["sequence"] == 9
        assert [m.header["sequence"] for m in session.all("live")] == [0, 1, 9]

    linked(session, test)


def test_a_page_that_never_acknowledges_still_gets_its_states():
    session = Noting(on_live=frame)

    async def test(bench: Bench) -> None:
        for k in range(5):
            bench.socket.say(kind="live", sequence=k)
            await bench.settled()
        (client,) = session.clients
        frame(client, Message({"sequence": 77}))
        bench.socket.say(kind="do", id=1)
        await bench.settled()
        assert [m.kind for m in bench.socket.unheard()] == ["frame", "frame", "done"]
        client.state({"revision": 3})
        for number in (1, 2):
            bench.socket.say(kind="ack", number=number)
        await bench.settled()
        assert [m.kind for m in bench.socket.unheard()] == ["state"]

    linked(session, test)


PUTS = st.lists(
    st.one_of(
        st.tuples(st.just("put"), st.integers(0, 3)),
        st.tuples(st.just("state"), st.integers(0, 3)),
        st.tuples(st.just("frame"), st.integers(0, 3)),
        st.tuples(st.just("send"), st.integers(1, 4)),
        st.tuples(st.just("ack"), st.integers(0, 3)),
    ),
    max_size=60,
)


@given(PUTS)
@settings(max_examples=150, deadline=None)
def test_an_outbox_keeps_what_lasts_and_the_latest_frames(steps):
    """Against what was put, whatever the order of putting, sending and acknowledging."""
    outbox = Outbox()
    lasting: list[str] = []
    latest: dict[int, str] = {}
    heard: list[str] = []
    under_way: list[int] = []

    def take() -> bool:
        item = outbox.pop()
        if isinstance(item, bytes):
            heard.append(item.decode())
        elif item is not None:
            heard.append(item.header["text"])
            under_way.append(item.number)
        assert len(under_way) <= WINDOW
        return item is not None

    for k, (what, which) in enumerate(steps):
        if what == "frame":
            latest[which] = f"frame {k} of {which}"
            outbox.put_frame({"tab": "quad", "surface": which, "text": latest[which]}, {})
        elif what == "send":
            _ = [take() for _ in range(which)]
        elif what == "ack" and under_way:
            outbox.acknowledge(under_way.pop(0))
        elif what in ("put", "state"):
            lasting.append(f"{what} {k}")
            (outbox.put_state if what == "state" else outbox.put)(lasting[-1].encode())
            latest = {} if what == "state" else latest
    while take() or under_way:
        while under_way:
            outbox.acknowledge(under_way.pop())

    frames = [text for text in heard if text.startswith("frame")]
    numbers = [int(text.split()[1]) for text in frames]
    assert [text for text in heard if text not in frames] == lasting
    assert numbers == sorted(set(numbers))
    assert set(latest.values()) <= set(frames)
    for k, text in enumerate(heard):
        if text.startswith("state"):
            later = [int(other.split()[1]) for other in heard[k:]]
            assert min(later) == later[0]  # nothing from before a state comes after it


# What comes


def test_while_the_engine_works_only_the_latest_live_message_waits():
    busy = Busy()
    session = Noting(on_receive=busy, on_live=frame)

    async def test(bench: Bench) -> None:
        bench.socket.say(kind="do", id=1)
        for k in range(100):
            bench.socket.say(kind="live", sequence=k)
        while bench.socket.taken < 101:
            await asyncio.sleep(0)
        busy.free.set()
        await bench.settled()
        assert [m.header["sequence"] for m in session.all("live")] == [99]

    linked(session, test)


@pytest.mark.parametrize("kind", ["do", "drop", "undo", "redo"])
def test_a_live_message_that_waits_is_out_of_date_after(kind):
    busy = Busy()
    session = Noting(on_receive=busy)

    async def test(bench: Bench) -> None:
        bench.socket.say(kind="cancel", job="j")
        bench.socket.say(kind="live", sequence=0)
        bench.socket.say(kind=kind, id=1)
        while bench.socket.taken < 3:
            await asyncio.sleep(0)
        busy.free.set()
        await bench.settled()
        assert [m.kind for m in session.all("receive")] == ["cancel", kind]
        assert not session.all("live")

    linked(session, test)


def test_messages_are_worked_on_in_their_order_and_edits_of_a_page_that_left_count():
    session = Noting()

    async def test(bench: Bench) -> None:
        for k in range(40):
            bench.socket.say(kind="do", id=k)

    linked(session, test)
    assert [m.header["id"] for m in session.all("receive")] == list(range(40))


def test_nothing_more_is_read_while_much_waits_for_the_engine(monkeypatch):
    monkeypatch.setattr(link, "EASY_MESSAGES", 5)
    busy = Busy()
    session = Noting(on_receive=busy)

    async def test(bench: Bench) -> None:
        for k in range(100):
            bench.socket.say(kind="do", id=k)
        for _ in range(500):
            await asyncio.sleep(0)
        assert bench.socket.taken == 6
        busy.free.set()
        while len(session.all("receive")) < 100:
            await bench.settled()

    linked(session, test)


def test_nothing_more_is_read_while_much_waits_for_the_page(monkeypatch):
    monkeypatch.setattr(link, "EASY_MESSAGES", 5)
    session = Noting()

    async def test(bench: Bench) -> None:
        bench.socket.reads.clear()
        for _ in range(100):
            bench.socket.say(kind="no such kind")
        for _ in range(500):
            await asyncio.sleep(0)
        assert bench.socket.taken <= 8
        bench.socket.reads.set()
        for _ in range(100):
            assert "'no such kind'" in await bench.refused()

    linked(session, test)


# What goes wrong


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (Infeasible("the curve cannot be met; choose fewer points"), "the curve cannot be met"),
        (ZeroDivisionError("by zero"), "failed inside henkei (ZeroDivisionError: by zero)"),
    ],
)
@pytest.mark.parametrize("kind", ["do", "live"])
def test_what_fails_is_answered_and_the_connection_stays(kind, error, told, caplog):
    def fail(client: Any, message: Message) -> None:
        raise error

    session = Noting(on_receive=fail, on_live=fail)

    async def test(bench: Bench) -> None:
        for k in range(3):
            bench.socket.say(kind=kind, id=k)
            message = await bench.socket.hear()
            assert (message.kind, message.header["id"]) == ("refused", k)
            assert told in message.header["message"]

    linked(session, test)
    assert len(caplog.records) == (3 if isinstance(error, ZeroDivisionError) else 0)


async def sent_away(bench: Bench) -> None:
    while bench.socket.closed is None:
        await asyncio.sleep(0)
    assert bench.socket.closed == (link.TRY_AGAIN_LATER, link._FAR_BEHIND)


@pytest.mark.parametrize("bound", ["MOST_MESSAGES", "MOST_BYTES"])
def test_a_page_that_is_far_behind_is_sent_away_and_nothing_is_held_for_it(monkeypatch, bound):
    monkeypatch.setattr(link, bound, {"MOST_MESSAGES": 50, "MOST_BYTES": 50_000}[bound])
    session = Noting()

    async def test(bench: Bench) -> None:
        bench.socket.reads.clear()
        (client,) = session.clients
        for _ in range(60):
            client.state({"text": "x" * 1000})
        await sent_away(bench)
        assert bench.link._outbox.pop() is None
        client.state({"text": "too late"})
        frame(client, Message({"sequence": 1}))
        await bench.settled()
        assert bench.link._outbox.pop() is None

    linked(session, test)


def test_a_single_message_may_be_larger_than_the_bound(monkeypatch):
    monkeypatch.setattr(link, "MOST_BYTES", 1000)
    session = Noting()

    async def test(bench: Bench) -> None:
        session.clients[0].send({"kind": "basis"}, start=np.zeros((500, 3), np.float32))
        assert (await bench.socket.hear()).arrays["start"].shape == (500, 3)

    linked(session, test)


def test_a_page_that_takes_nothing_is_sent_away(monkeypatch):
    monkeypatch.setattr(link, "SLOWEST_SEND", 0.01)
    session = Noting()

    async def test(bench: Bench) -> None:
        bench.socket.reads.clear()
        session.clients[0].state({})
        await sent_away(bench)

    linked(session, test)


def test_a_page_that_breaks_off_while_something_is_sent():
    session = Noting()

    async def test(bench: Bench) -> None:
        async def broken(data: bytes) -> None:
            raise WebSocketDisconnect(1006)

        bench.socket.send_bytes = broken  # type: ignore[method-assign]
        session.clients[0].state({})
        await bench.settled()
        assert bench.socket.closed is None

    linked(session, test)


def test_a_client_may_be_called_after_everything_has_ended():
    session = Noting()

    async def test(bench: Bench) -> None:
        pass

    linked(session, test)
    session.clients[0].state({"revision": 1})
    session.clients[0].frame({"tab": "quad", "surface": "a"})


# What makes no sense


VALID = [
    encode({"kind": "do", "id": 7, "tab": "deform", "action": "move", "by": [1.0, 2.0, 3.0]}),
    encode({"kind": "live", "sequence": 3, "tab": "design"}, ids=np.arange(5, dtype=np.uint32)),
    encode({"kind": "ack", "number": 3}),
]


def bare(header: Any, more: bytes = b"") -> bytes:
    """A message with any JSON in the place of its header."""
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    return len(text).to_bytes(4, "little") + text + bytes(-(4 + len(text)) % 8) + more


def arrays(*table: Any) -> bytes:
    return bare({"kind": "do", "id": 1, "arrays": list(table)}, bytes(64))


NONSENSE = {
    "nothing": b"",
    "three bytes": b"abc",
    "a length without end": b"\xff\xff\xff\xff" + bytes(20),
    "a length beyond the end": (1000).to_bytes(4, "little") + b"{}",
    "a header that is too long": bare(b'{"a":"' + b"x" * LONGEST_HEADER + b'"}'),
    "no JSON": bare(b"{kind: do}"),
    "no UTF-8": bare(b'{"kind": "\xff\xfe"}'),
    "a list": bare([1, 2]),
    "deep lists": bare(b"[" * 100_000),
    "deep objects": bare(b'{"a":' * 50_000 + b"1" + b"}" * 50_000),
    "not a number": bare(b'{"kind": "do", "id": NaN}'),
    "a long number": bare(b'{"kind": "do", "id": ' + b"9" * 10_000 + b"}"),
    "no kind": bare({}),
    "an unknown kind": bare({"kind": "x" * 5000}),
    "a list as kind": bare({"kind": ["do"]}),
    "an object as id": bare({"kind": "do", "id": {}}),
    "a yes as id": bare({"kind": "do", "id": True}),
    "a long id": bare({"kind": "undo", "id": "x" * 65}),
    "a large id": bare({"kind": "undo", "id": 10**20}),
    "an ack of nothing": bare({"kind": "ack"}),
    "an ack of text": bare({"kind": "ack", "number": "1"}),
    "an ack of infinity": bare(b'{"kind": "ack", "number": 1e999}'),
    "arrays that are none": bare({"kind": "do", "arrays": 5}),
    "too many arrays": arrays(*[[f"a{k}", "u1", [1]] for k in range(17)]),
    "an unknown dtype": arrays(["a", "f2", [1]]),
    "a list as dtype": arrays(["a", ["f4"], [1]]),
    "a number as name": arrays([5, "f4", [1]]),
    "twice the same name": arrays(["a", "u1", [1]], ["a", "u1", [1]]),
    "a negative shape": arrays(["a", "f4", [-1]]),
    "a large shape": arrays(["a", "f8", [1 << 39, 1 << 39, 1 << 39]]),
    "a shape beyond the end": arrays(["a", "f4", [100]]),
    "a shape of halves": arrays(["a", "f4", [0.5]]),
    "text": "kind: do",
}


@pytest.mark.parametrize("nonsense", NONSENSE.values(), ids=NONSENSE)
def test_nonsense_is_answered_with_what_is_wrong(nonsense):
    session = Noting()

    async def test(bench: Bench) -> None:
        bench.socket.say_bytes(nonsense)
        told = await bench.refused()
        assert 10 < len(told) <= 1000
        assert "\n" not in told
        bench.socket.say(kind="do", id=5)
        assert (await bench.socket.hear()).header["id"] == 5

    linked(session, test)
    assert len(session.all("receive")) == 1


def malformed(count: int) -> Iterator[bytes | str]:
    """Random bytes, valid messages with mistakes, and nonsense, in turn."""
    chance = np.random.default_rng(0)
    fixed = [data for data in NONSENSE.values() if len(data) < 20_000]
    for k in range(count):
        valid = bytearray(VALID[k % len(VALID)])
        where = int(chance.integers(len(valid)))
        if k % 5 == 0:
            yield chance.bytes(int(chance.integers(200)))
        elif k % 5 == 1:
            valid[where] ^= int(chance.integers(1, 256))
            yield bytes(valid)
        elif k % 5 == 2:
            yield bytes(valid[:where])
        elif k % 5 == 3:
            valid[:4] = chance.bytes(4)
            yield bytes(valid)
        else:
            yield fixed[int(chance.integers(len(fixed)))]


def test_ten_thousand_malformed_messages():
    """All are answered or, if the mistake left them usable, worked on; nothing piles up."""
    session = Noting()

    async def test(bench: Bench) -> None:
        answers: list[int] = []
        for k, data in enumerate(malformed(10_000)):
            bench.socket.say_bytes(data)
            if k % 100 == 99:
                await bench.settled()
                for message in bench.socket.unheard():
                    assert message.kind in ("refused", "done")
                    answers.append(len(message.header.get("message", "a good answer")))
                session.noted[1:] = []
            if k == 2000:
                tracemalloc.start()
        grown, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert grown < 500_000
        assert 7000 < len(answers) <= 10_000
        assert min(answers) > 10
        bench.socket.say(kind="do", id="still there")
        assert (await bench.socket.hear()).header["id"] == "still there"

    linked(session, test)
