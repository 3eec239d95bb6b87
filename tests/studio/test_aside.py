"""Long preparation is done beside the engine, which goes on meanwhile."""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import SimpleQueue
from typing import Any
from weakref import ref

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from henkei.errors import Cancelled, InvalidInput
from henkei.progress import Progress, silent
from henkei.studio import deform_state
from henkei.studio.aside import Aside, at_once
from henkei.workflows.deform_by_recipe import Staged
from seated import LIMIT, Studio, bending

MOVE = {"name": "handle 1", "move": {"translation": [0, 0, 20]}}


def yes() -> bool:
    return True


def nothing() -> None:
    """For what nobody asked about."""


class Desk:
    """Asides, what they told and what they posted."""

    def __init__(self) -> None:
        self.told: list[dict[str, Any]] = []
        self.posted: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self.aside = Aside(self.posted.put, self.told.append)

    def start(self, work: Callable[[Progress], None], **how: Any) -> Any:
        return self.aside.start("work", work, **{"wanted": yes, "then": nothing, **how})


@pytest.fixture
def desk() -> Iterator[Desk]:
    found = Desk()
    yield found
    found.aside.close()


def test_work_is_told_of_and_what_follows_is_posted(desk: Desk) -> None:
    after: list[int] = []
    done = desk.start(lambda progress: progress("half", 0.5), then=lambda: after.append(1))
    assert done.result(LIMIT) is None
    desk.posted.get(timeout=LIMIT)()
    assert after == [1]
    assert [one["kind"] for one in desk.told] == ["progress", "progress", "ended"]
    assert len({one["job"] for one in desk.told}) == 1


def test_what_fails_is_told_to_who_asks_and_the_next_is_done(desk: Desk) -> None:
    def fail(progress: Progress) -> None:
        raise InvalidInput("nothing is fixed")

    failed, fine = desk.start(fail), desk.start(lambda progress: None)
    assert fine.result(LIMIT) is None
    with pytest.raises(InvalidInput, match="nothing is fixed"):
        failed.result()
    with pytest.raises(InvalidInput, match="nothing is fixed"):
        at_once(fail, silent).result()


def test_what_nobody_wants_ends_at_its_next_progress(desk: Desk) -> None:
    wanted, begun, go, after = [True], threading.Event(), threading.Event(), []

    def work(progress: Progress) -> None:
        begun.set()
        assert go.wait(LIMIT)
        progress("half", 0.5)
        after.append("half")

    how = {"wanted": lambda: wanted[0], "then": lambda: after.append("then")}
    first, second = desk.start(work, **how), desk.start(work, **how)
    assert begun.wait(LIMIT)
    wanted[0] = False
    go.set()
    for one in (first, second):
        with pytest.raises(Cancelled):
            one.result(LIMIT)
        desk.posted.get(timeout=LIMIT)()
    assert not after
    assert desk.told[-1]["kind"] == "ended"


class Gate:
    """Holds up preparations until it is opened."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.opened, self.passed = threading.Event(), 0
        prepare = Staged.prepare

        def held(stage: Staged, recipe: Any, progress: Progress) -> None:
            assert self.opened.wait(LIMIT)
            progress("held", 0.0)
            self.passed += 1
            prepare(stage, recipe, progress)

        monkeypatch.setattr(Staged, "prepare", held)
        monkeypatch.setattr(deform_state, "LONG", 0)


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch) -> Gate:
    return Gate(monkeypatch)


@pytest.fixture
def studio(tmp_path: Path, gate: Gate) -> Iterator[Studio]:
    running = Studio(tmp_path / "sessions")
    yield running
    gate.opened.set()
    running.close()


def view(studio: Studio) -> dict[str, Any]:
    found: dict[str, Any] = studio.page.tabs["deform"]["view"]
    return found


def prepared(studio: Studio) -> None:
    """Wait until the page was told so."""
    while view(studio)["preparing"]:
        studio.page.until("ended")
        studio.on_engine(nothing)


def test_the_engine_goes_on_while_systems_are_factored(
    studio: Studio, gate: Gate, tmp_path: Path
) -> None:
    bending(studio, tmp_path)
    assert view(studio)["preparing"]
    assert view(studio)["trouble"] is None
    rest = studio.page.positions["mesh"]
    assert studio.do("deform", "move_handle", **MOVE)["kind"] == "done"
    studio.live("deform", "move_handle", **MOVE)
    assert_array_equal(studio.page.positions["mesh"], rest)
    gate.opened.set()
    prepared(studio)
    assert gate.passed == 1
    assert not np.array_equal(studio.page.positions["mesh"], rest)
    assert studio.page.exact["mesh"]
    assert view(studio)["figures"]


def test_what_was_undone_is_not_prepared(studio: Studio, gate: Gate, tmp_path: Path) -> None:
    bending(studio, tmp_path)
    assert view(studio)["preparing"]
    assert studio.receive("undo")["kind"] == "done"
    assert not view(studio)["preparing"]
    gate.opened.set()
    studio.page.until("ended")
    assert gate.passed == 0


def test_the_surface_stays_where_it_was_until_the_next_system_is_there(
    studio: Studio, gate: Gate, tmp_path: Path
) -> None:
    gate.opened.set()
    bending(studio, tmp_path)
    prepared(studio)
    studio.do("deform", "move_handle", **MOVE)
    moved = studio.page.positions["mesh"]
    gate.opened.clear()
    studio.do("deform", "rename", kind="handles", name="handle 1", to="emblem")
    assert view(studio)["preparing"]
    assert_array_equal(studio.page.positions["mesh"], moved)
    gate.opened.set()
    prepared(studio)
    assert_array_equal(studio.page.positions["mesh"], moved)


def test_going_back_and_forth_prepares_once(studio: Studio, gate: Gate, tmp_path: Path) -> None:
    bending(studio, tmp_path)
    for _ in range(3):
        studio.receive("undo")
        studio.receive("redo")
    gate.opened.set()
    prepared(studio)
    assert gate.passed == 1


def test_no_pin_is_set_where_the_surface_is_not(studio: Studio, gate: Gate, tmp_path: Path) -> None:
    gate.opened.set()
    bending(studio, tmp_path)
    prepared(studio)
    studio.do("deform", "move_handle", **MOVE)
    gate.opened.clear()
    studio.do("deform", "select_vertices", vertices=[0])
    session = studio.page.last["session"]
    studio.do("document", "new")
    studio.do("document", "restore", session=session)
    assert view(studio)["preparing"]
    refused = studio.do("deform", "add_pin", vertex=5000)
    assert refused["kind"] == "refused"
    assert "still being prepared" in refused["message"]
    gate.opened.set()
    prepared(studio)
    assert studio.do("deform", "add_pin", vertex=5000)["kind"] == "done"


def test_what_was_given_up_is_not_kept(studio: Studio, gate: Gate, tmp_path: Path) -> None:
    gate.opened.set()
    bending(studio, tmp_path)
    prepared(studio)
    stage = ref(studio.session._services.present("deform").stage)
    studio.do("document", "new")
    gc.collect()
    assert stage() is None
