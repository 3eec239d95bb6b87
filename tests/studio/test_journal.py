"""The journal: what it tells of is what was done, wherever it breaks off."""

from __future__ import annotations

import errno
import json
import os
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict

from henkei.errors import InvalidFile, InvalidInput
from henkei.studio.blobs import Blobs
from henkei.studio.history import History
from henkei.studio.journal import MOST_ASKED, NAME, Journal
from henkei.studio.lines import Codec, read, replay


class Tab(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")
    ids: tuple[int, ...] = ()
    size: float = 0.0


class Document(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")
    name: str = ""
    deform: Tab = Tab()
    design: Tab = Tab()


def codec(folder) -> Codec[Document]:
    return Codec(
        Blobs(folder / "blobs"), lambda d: d.model_dump(mode="json"), Document.model_validate
    )


def begun(folder, **settings) -> Journal[Document]:
    used = codec(folder)
    return Journal(folder, used, History(used.parts(Document())), **settings)


def told(history: History) -> tuple:
    """All that a person can tell of a history."""
    steps = [(step.label, step.tab, step.document) for step in history.steps]
    return steps, history.position, history.now


def replayed(folder) -> History[Document]:
    return replay(read(folder / NAME), codec(folder))[0]


def kinds(folder) -> list[str]:
    return [json.loads(text[9:])["kind"] for text in (folder / NAME).read_bytes().splitlines()]


def waited_for(condition) -> bool:
    """Wait until it is so, with a limit that only a failure meets."""
    end = time.monotonic() + 60
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.005)
    return True


DOCUMENTS = st.builds(
    Document,
    name=st.sampled_from(["", "head", '"quoted"\n', "ç\ud800"]),
    deform=st.builds(Tab, ids=st.sampled_from([(), (1, 2), tuple(range(100))])),
    design=st.builds(Tab, size=st.sampled_from([0.0, 0.1, 1e300])),
)
COMMIT = st.tuples(st.just("commit"), DOCUMENTS, st.sampled_from(["move", "turn"]))
DRAFT = st.tuples(st.just("draft"), DOCUMENTS, st.just("drag"))
OTHER = st.sampled_from([("undo",), ("redo",), ("drop",), ("flush",), ("open",)])


@settings(max_examples=40, deadline=None)
@given(actions=st.lists(COMMIT | COMMIT | DRAFT | OTHER, max_size=40))
def test_what_was_done_is_told(tmp_path_factory, actions):
    folder = tmp_path_factory.mktemp("session")
    history, journal = History(Document()), begun(folder, interval=1e9)
    for name, *arguments in actions:
        if name == "commit":
            if history.commit(*arguments, "tab"):
                journal.commit(*arguments, "tab")
            else:
                journal.drop()
        elif name == "draft":
            history.draft(*arguments, "tab")
            journal.draft(*arguments, "tab")
        elif name == "undo" and history.position:
            history.undo()
            journal.undo()
        elif name == "redo" and history.redo_label is not None:
            history.redo()
            journal.redo()
        elif name == "drop":
            history.drop()
            journal.drop()
        elif name == "flush":
            journal.flush()
        elif name == "open":  # by the next process, which takes a draft for a step
            journal.close()
            _end(history)
            record = read(folder / NAME)
            journal = Journal(folder, codec(folder), record.steps, interval=1e9)
        assert journal.trouble is None
    journal.close()
    _end(history)
    assert told(replayed(folder)) == told(history)


def _end(history: History) -> None:
    """What becomes of a draft when the process ends."""
    step = history.drafted
    if step is not None:
        history.commit(step.document, step.label, step.tab)


def small_session(folder) -> list[tuple]:
    """A journal with all kinds of lines; what is told after each of them, and after none."""
    history, journal = History(Document()), begun(folder)
    one = Document(name="one", deform=Tab(ids=tuple(range(70))))
    two = one.model_copy(update={"design": Tab(size=2)})
    expected = []

    def note():
        steps = History.restored(history.steps, history.position)
        step = history.drafted
        if step is not None:
            steps.commit(step.document, step.label, step.tab)
        expected.append(told(steps))

    note()
    for document, label in ((one, "first"), (two, "second")):
        history.commit(document, label, "deform")
        journal.commit(document, label, "deform")
        note()
    for name in ("undo", "undo", "redo"):
        getattr(history, name)()
        getattr(journal, name)()
        note()
    for size in (3, 4):
        document = one.model_copy(update={"design": Tab(size=size)})
        history.draft(document, "drag", "design")
        journal.draft(document, "drag", "design")
        journal.flush()
        note()
    history.drop()
    journal.drop()
    note()
    history.commit(two, "third", "quad")
    journal.commit(two, "third", "quad")
    note()
    journal.close()
    return expected


def test_a_journal_cut_anywhere_tells_of_all_before(tmp_path):
    expected = small_session(tmp_path)
    content = (tmp_path / NAME).read_bytes()
    ends = [place for place, byte in enumerate(content) if byte == ord("\n")]
    assert len(ends) == len(expected)
    for length in range(ends[0]):
        (tmp_path / NAME).write_bytes(content[:length])
        with pytest.raises(InvalidFile, match="start is damaged"):
            read(tmp_path / NAME)
    for length in range(ends[0], len(content) + 1):
        (tmp_path / NAME).write_bytes(content[:length])
        record = read(tmp_path / NAME)
        assert record.damage is None
        if length in ends:
            assert told(replay(record, codec(tmp_path))[0]) == expected[ends.index(length)]
            steps = written(record.steps)
        assert written(record.steps) == steps, length


def test_any_byte_that_is_damaged_costs_only_what_comes_after(tmp_path):
    expected = small_session(tmp_path)
    content = (tmp_path / NAME).read_bytes()
    ends = [place for place, byte in enumerate(content) if byte == ord("\n")]
    for place in range(ends[0] + 1, len(content) - 1):
        damaged = bytearray(content)
        damaged[place] ^= 1 << (place % 8)
        (tmp_path / NAME).write_bytes(damaged)
        record = read(tmp_path / NAME)
        line = sum(end < place for end in ends)
        assert (record.damage is None) == (place >= ends[-2]), place
        if place - 1 in ends:
            assert told(replay(record, codec(tmp_path))[0]) == expected[line - 1]
            steps = written(record.steps)
        assert written(record.steps) == steps, place


def written(steps: History) -> tuple:
    """A history of parts, to be compared with another."""
    texts = [(step.label, step.tab, step.document.texts) for step in steps.steps]
    return texts, steps.position


@pytest.mark.parametrize("content", [b"", b"\n", b"text", b"\xff\x00" * 50, b"00000000 {}\n"])
def test_what_is_no_journal_is_refused(tmp_path, content):
    (tmp_path / NAME).write_bytes(content)
    with pytest.raises(InvalidFile):
        read(tmp_path / NAME)


def test_a_journal_of_another_form_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("henkei.studio.lines.FORM", 2)
    begun(tmp_path).close()
    monkeypatch.undo()
    with pytest.raises(InvalidFile, match="another version"):
        read(tmp_path / NAME)


def test_a_missing_journal_is_told(tmp_path):
    with pytest.raises(InvalidFile, match="cannot be read"):
        read(tmp_path / NAME)


# What stands in the file


def test_a_line_holds_only_the_parts_that_changed_and_a_whole_one_comes_now_and_then(tmp_path):
    journal = begun(tmp_path)
    for size in range(1, 121):
        journal.commit(Document(name="x" * 100, design=Tab(size=size)), "size")
    journal.close()
    entries = [json.loads(text[9:]) for text in (tmp_path / NAME).read_bytes().splitlines()]
    whole = [n for n, entry in enumerate(entries) if "document" in entry]
    assert whole == [0, 50, 100]
    assert all(list(entries[n]["changed"]) == ["design"] for n in range(2, 50))
    assert replayed(tmp_path).now.design.size == 120


def test_long_lists_stand_in_blobs_once(tmp_path):
    journal = begun(tmp_path)
    ids = tuple(range(10_000))
    for size in range(20):
        journal.commit(Document(deform=Tab(ids=ids, size=size)), "size")
    journal.close()
    assert len(list((tmp_path / "blobs").glob("[0-9a-f]*"))) == 1
    assert (tmp_path / NAME).stat().st_size < 20 * 250
    assert replayed(tmp_path).now.deform.ids == ids


def test_opening_writes_one_line_for_each_step(tmp_path):
    small_session(tmp_path)
    before = told(replayed(tmp_path))
    Journal(tmp_path, codec(tmp_path), read(tmp_path / NAME).steps).close()
    assert kinds(tmp_path) == ["start", "commit", "commit"]
    assert told(replayed(tmp_path)) == before


def test_the_messages_that_asked_last_are_known_however_often_it_is_opened(tmp_path):
    journal, asked = begun(tmp_path), [f"page-{n}" for n in range(MOST_ASKED + 5)]
    for n, ident in enumerate(asked):
        journal.commit(Document(design=Tab(size=n)), "size", asked=ident)
    journal.undo("undo")
    journal.redo("redo")
    journal.undo()  # nobody asked
    for _ in range(2):
        journal.close()
        record = read(tmp_path / NAME)
        assert list(record.asked)[-MOST_ASKED:] == [*asked, "undo", "redo"][-MOST_ASKED:]
        journal = Journal(tmp_path, codec(tmp_path), record.steps, record.asked)
    assert len(journal.asked) == len(read(tmp_path / NAME).asked) == MOST_ASKED
    journal.close()


def test_documents_are_read_when_they_are_asked_for(tmp_path):
    loaded = []
    used = codec(tmp_path)
    counting = Codec(
        used.blobs, used.dump, lambda data: loaded.append(data["name"]) or used.load(data)
    )
    journal = begun(tmp_path)
    for n in range(10):
        journal.commit(Document(name=str(n)), "name")
    journal.close()
    history, _ = replay(read(tmp_path / NAME), counting)
    assert loaded == ["9"]
    history.undo()
    assert (loaded, history.now.name) == (["9", "8"], "8")


# Damage beyond the file


def test_steps_whose_blobs_are_gone_are_left_out(tmp_path):
    journal = begun(tmp_path)
    journal.commit(Document(name="kept"), "name")
    journal.commit(Document(name="kept", deform=Tab(ids=tuple(range(100)))), "select")
    journal.commit(Document(name="more", deform=Tab(ids=tuple(range(100)))), "name")
    journal.close()
    for blob in (tmp_path / "blobs").glob("[0-9a-f]*"):
        blob.unlink()
    history, record = replay(read(tmp_path / NAME), codec(tmp_path))
    assert history.now == Document(name="kept")
    assert history.redo_label is None
    assert "there is no blob" in record.damage
    assert len(record.steps.steps) == len(history.steps)


def test_a_document_of_another_version_is_told(tmp_path):
    journal = begun(tmp_path)
    journal.close()
    used = codec(tmp_path)
    newer = Codec(used.blobs, used.dump, lambda data: used.load({**data, "unknown": 1}))
    with pytest.raises(InvalidFile, match=r"cannot be read.*unknown"):
        replay(read(tmp_path / NAME), newer)


def test_a_full_disk_stops_no_work_and_all_is_written_when_it_has_room(tmp_path, monkeypatch):
    journal, history = begun(tmp_path, fsync=True), History(Document())

    def commit(document):
        history.commit(document, "change")
        journal.commit(document, "change")

    commit(Document(name="before"))
    with monkeypatch.context() as full:
        full.setattr(os, "fsync", _full)
        commit(Document(name="while full", deform=Tab(ids=tuple(range(100)))))
        assert "not being saved" in journal.trouble
        history.undo()
        journal.undo()
        history.redo()
        journal.redo()
        journal.draft(Document(name="tried"))
        journal.flush()
        assert "No space left" in journal.trouble
    journal.drop()
    assert journal.trouble is None
    assert told(replayed(tmp_path)) == told(history)
    commit(Document(name="after"))
    journal.close()
    assert told(replayed(tmp_path)) == told(history)


def _full(descriptor):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


# Drafts


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_drafts_are_written_at_most_so_often_and_the_last_one_always(tmp_path):
    clock = Clock()
    journal = begun(tmp_path, clock=clock, interval=0.01)
    size = 0
    for second in range(4):
        for _ in range(60):
            size += 1
            journal.draft(Document(design=Tab(size=size)), "drag", "design")
        assert waited_for(lambda lines=second + 1: kinds(tmp_path).count("draft") > lines - 1)
        clock.now += 0.01
    assert waited_for(lambda: replayed(tmp_path).now.design.size == size)
    assert kinds(tmp_path).count("draft") <= 5  # one for each time of the clock
    journal.close()


def test_nobody_needs_to_call_again_for_the_last_draft(tmp_path):
    journal = begun(tmp_path, interval=0.02)
    for size in range(1, 4):
        journal.draft(Document(design=Tab(size=size)), "drag", "design")
    assert waited_for(lambda: replayed(tmp_path).now.design.size == 3)
    history = replayed(tmp_path)
    assert (history.undo_label, history.undo().tab) == ("drag", "design")
    journal.close()


def test_closing_writes_what_waits_and_then_nothing_more(tmp_path):
    journal = begun(tmp_path, interval=1e9)
    journal.draft(Document(name="first"))
    assert waited_for(lambda: "draft" in kinds(tmp_path))
    journal.draft(Document(name="last"))
    journal.close()
    assert replayed(tmp_path).now.name == "last"
    journal.commit(Document(name="too late"), "change")
    journal.close()
    assert replayed(tmp_path).now.name == "last"


@pytest.mark.parametrize("end", ["drop", "undo", "redo", "commit"])
def test_a_draft_that_waits_ends_with_what_comes_after_it(tmp_path, end):
    journal = begun(tmp_path, interval=1e9)
    journal.flush()  # from now on the thread waits
    document = Document(name="committed")
    journal.commit(document, "first")
    if end == "redo":
        journal.undo()
    journal.draft(Document(name="tried"))
    if end == "commit":
        journal.commit(document, "again")
    else:
        getattr(journal, end)()
    journal.close()
    assert "draft" not in kinds(tmp_path)
    assert replayed(tmp_path).now.name == ("" if end == "undo" else "committed")


def test_what_cannot_be_undone_is_refused(tmp_path):
    journal = begun(tmp_path)
    for name in ("undo", "redo"):
        with pytest.raises(InvalidInput, match="nothing to"):
            getattr(journal, name)()
    journal.close()
    assert kinds(tmp_path) == ["start"]
