"""The engine: one thing after the other, on one thread, whatever goes wrong in it."""

from __future__ import annotations

import asyncio
import threading

import pytest

from apart import run
from henkei.studio.engine import Engine, Worker
from served import Noting


def test_everything_is_done_in_its_order_on_one_thread():
    worker, done = Worker("worker"), []
    futures = [worker.submit(done.append, k) for k in range(50)]
    threads = {worker.submit(threading.current_thread) for _ in range(3)}
    assert not done
    for _ in range(2):
        worker.start()
    assert [future.result(30) for future in futures] == [None] * 50
    assert done == list(range(50))
    (thread,) = {future.result(30) for future in threads}
    assert (thread.name, thread.daemon) == ("worker", True)
    worker.end()
    thread.join(30)
    assert not worker.busy


def test_what_fails_is_told_to_who_waits_and_the_rest_goes_on():
    worker = Worker("worker")
    failed, ended, fine = (worker.submit(f) for f in (lambda: [][1], lambda: exit(3), lambda: 5))
    given_up = worker.submit(lambda: 6)
    given_up.cancel()
    worker.end()
    worker.start()
    assert fine.result(30) == 5
    with pytest.raises(IndexError):
        failed.result()
    with pytest.raises(SystemExit):
        ended.result()
    with pytest.raises(RuntimeError, match="has ended"):
        worker.submit(lambda: 7)


def test_a_session_hears_of_what_was_posted_until_it_is_closed(caplog):
    session = Noting()
    engine = Engine(lambda post: session)
    engine.post(lambda: session.noted.append(("posted", 1)))
    engine.post(lambda: [][1])
    engine.start()
    run(engine.close(30))
    assert [what for what, _ in session.noted] == ["posted", "close"]
    assert "IndexError" in caplog.text
    engine.post(lambda: session.noted.append(("too late", 1)))
    assert not engine.busy
    assert len(session.noted) == 2


def test_the_end_does_not_wait_for_ever():
    enough = threading.Event()
    engine = Engine(lambda post: Noting())
    engine.submit(enough.wait, 30)
    engine.start()
    run(engine.close(0.01))
    assert engine.busy
    enough.set()


def test_a_session_that_was_never_needed_is_not_opened_at_the_end():
    opened = []
    run(Engine(lambda post: opened.append(post)).close(30))
    assert not opened


def test_what_nobody_waits_for_any_more_is_done_all_the_same():
    worker, done = Worker("worker"), threading.Event()

    async def give_up() -> None:
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(worker.run(done.set), 0.01)
        worker.start()

    run(give_up())
    assert done.wait(30)
    worker.end()
