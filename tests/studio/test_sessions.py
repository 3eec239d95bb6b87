"""Sessions on the disk: they outlast any end of the studio, and go only when nobody needs them."""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import time
import weakref
from pathlib import Path

import pytest

from henkei.errors import InvalidFile, InvalidInput
from henkei.studio.sessions import AT_HAND, MOST, Sessions

START = {"meshes": [], "deform": {"ids": []}}
KILLED = """
import sys
from pathlib import Path
from henkei.studio.sessions import Sessions

sessions = Sessions({"meshes": [], "deform": {"ids": []}}, dict, dict, sys.argv[1])
kept = sessions.create()
for n in range(3):
    kept.commit({"meshes": [{"name": "head"}], "deform": {"ids": [n] * 100}}, f"step {n}", "deform")
kept.undo()
print(kept.id, flush=True)
for n in range(100):
    kept.draft({"meshes": [{"name": "head"}], "deform": {"ids": [n] * 200}}, "drag", "deform")
print("dragged", flush=True)
sys.stdin.read()
"""


def opened(folder) -> Sessions[dict]:
    return Sessions(START, dict, dict, folder)


def document(*names: str, ids=(), **parts) -> dict:
    meshes = [{"name": name} for name in names]
    return {"meshes": meshes, "deform": {"ids": list(ids)}, **parts}


def filled(sessions: Sessions[dict], *names: str) -> str:
    """The id of a session that was closed."""
    kept = sessions.create()
    kept.commit(document(*names), "open", "deform")
    kept.close()
    return kept.id


def folder_of(sessions: Sessions[dict], id: str) -> Path:
    return sessions.folder / "sessions" / id


def age(sessions: Sessions[dict], seconds: float, pattern: str = "**/*") -> None:
    """Let files of a folder be so old."""
    then = time.time() - seconds
    for path in sessions.folder.glob(pattern):
        os.utime(path, (then, then))


@pytest.fixture
def sessions(tmp_path) -> Sessions[dict]:
    return opened(tmp_path / "henkei")


# Opening and closing


def test_documents_of_steps_long_past_are_not_in_memory(sessions):
    class Ids(list):
        """A list that can be watched."""

    kept, watched = sessions.create(), []
    for n in range(3 * AT_HAND):
        ids = Ids([n] * 100)
        watched.append(weakref.ref(ids))
        kept.commit(document("head", deform={"ids": ids}), f"step {n}", "deform")
        del ids
    gc.collect()
    assert [one() is None for one in watched] == [True] * (2 * AT_HAND) + [False] * AT_HAND
    for n in reversed(range(1, 3 * AT_HAND)):
        assert kept.undo().label == f"step {n}"
        assert kept.history.now == document("head", ids=[n - 1] * 100)
    assert kept.undo().label == "step 0"
    assert kept.history.now == START
    for n in range(3 * AT_HAND):
        kept.redo()
        assert kept.history.now == document("head", ids=[n] * 100)
    kept.close()


def test_a_session_goes_on_where_it_was_closed(sessions):
    kept = sessions.create()
    assert kept.history.now == START
    assert kept.commit(document("head"), "open", "deform")
    assert not kept.commit(document("head"), "open", "deform")
    assert kept.commit(document("head", ids=range(100)), "select", "deform")
    kept.undo()
    kept.draft(document("head", ids=[1]), "drag", "quad")
    kept.drop()
    kept.close()

    again = opened(sessions.folder).open(kept.id)
    assert again.damage is None
    assert again.trouble is None
    assert again.history.now == document("head")
    assert again.redo().label == "select"
    assert again.history.now == document("head", ids=range(100))
    assert [again.undo().label, again.undo().label] == ["select", "open"]
    assert again.history.now == START
    again.close()


def test_what_is_tried_out_when_it_is_closed_is_a_step(sessions):
    kept = sessions.create()
    kept.draft(document("head"), "drag", "quad")
    kept.close()
    again = sessions.open(kept.id)
    assert again.history.now == document("head")
    assert again.undo().tab == "quad"
    again.close()


def test_a_commit_of_what_is_there_ends_what_was_tried_out(sessions):
    kept = sessions.create()
    kept.commit(document("head"), "open")
    kept.draft(document("hand"), "drag")
    kept.commit(document("head"), "nothing")
    kept.close()
    again = sessions.open(kept.id)
    assert (again.history.now, again.history.undo_label) == (document("head"), "open")
    again.close()


def test_a_session_is_open_once(sessions):
    kept = sessions.create()
    kept.commit(document("head"), "open")
    assert sessions.offers() == []
    for other in (sessions, opened(sessions.folder)):
        for refused in (other.open, other.forget):
            with pytest.raises(InvalidInput, match="open already"):
                refused(kept.id)
    kept.close()
    assert [offer.id for offer in sessions.offers()] == [kept.id]
    sessions.open(kept.id).close()


@pytest.mark.parametrize("bad", ["", "..", "../blobs", "0" * 15, "0" * 17, "G" * 16, None, 3])
def test_only_ids_of_sessions_are_looked_up(sessions, bad):
    for look in (sessions.open, sessions.forget):
        with pytest.raises(InvalidInput, match="no id of a session"):
            look(bad)


def test_sessions_that_are_not_there_are_told(sessions):
    for look in (sessions.open, sessions.forget):
        with pytest.raises(InvalidFile, match="there is no session"):
            look("0" * 16)


def test_offers_say_what_is_in_a_session(sessions):
    before = time.time() - 1
    first, second = filled(sessions, "head", "hand"), filled(sessions, "foot")
    age(sessions, 50, f"sessions/{first}/journal.jsonl")
    newer, older = sessions.offers()
    assert (newer.id, newer.meshes, newer.steps) == (second, ("foot",), 1)
    assert (older.id, older.meshes, older.steps) == (first, ("head", "hand"), 1)
    assert before < newer.created <= newer.changed
    about = json.loads((folder_of(sessions, first) / "about.json").read_text())
    assert (about["meshes"], about["steps"]) == (["head", "hand"], 1)


def test_to_open_a_session_is_no_change(sessions):
    filled(sessions, "head")
    age(sessions, 1000)
    (before,) = sessions.offers()
    sessions.open(before.id).close()
    (after,) = sessions.offers()
    assert (after.created, after.changed) == (before.created, before.changed)


def test_a_session_with_nothing_in_it_goes_when_it_is_closed(sessions):
    kept = sessions.create()
    kept.close()
    assert sessions.offers() == []
    assert not folder_of(sessions, kept.id).exists()


def test_a_session_is_forgotten(sessions):
    id = filled(sessions, "head")
    sessions.forget(id)
    assert sessions.offers() == []
    assert not folder_of(sessions, id).exists()


# Crashes and damage


def test_a_killed_studio_loses_nothing_that_was_written(sessions):
    command = [sys.executable, "-c", KILLED, str(sessions.folder)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        id = process.stdout.readline().strip()
        journal = folder_of(sessions, id) / "journal.jsonl"
        assert process.stdout.readline() == "dragged\n"
        assert sessions.offers() == []
        end = time.monotonic() + 60
        wanted = json.dumps(sessions.blobs.put_message({"kind": "numbers"}, values=_drawn(99)))
        while wanted not in journal.read_text() and time.monotonic() < end:
            time.sleep(0.01)
        process.kill()
        process.wait(60)
    (offer,) = sessions.offers()
    assert (offer.id, offer.meshes, offer.steps) == (id, ("head",), 3)
    kept = sessions.open(id)
    assert kept.damage is None
    assert kept.history.now["deform"]["ids"] == [99] * 200
    labels = [kept.undo().label for _ in range(3)]
    assert labels == ["drag", "step 1", "step 0"]
    kept.close()


def _drawn(n):
    import numpy as np

    return np.full(200, n, np.uint32)


def test_a_studio_killed_in_the_middle_of_a_line_offers_what_came_before(sessions):
    id = filled(sessions, "head")
    with (folder_of(sessions, id) / "journal.jsonl").open("ab") as stream:
        stream.write(b'01234567 {"kind":"commit","la')
    (offer,) = sessions.offers()
    assert offer.steps == 1
    kept = sessions.open(id)
    assert kept.damage is None
    kept.commit(document("hand"), "open")
    kept.close()
    again = sessions.open(id)
    assert again.history.now == document("hand")
    again.close()


def test_damage_is_told_and_the_damaged_file_is_kept(sessions):
    kept = sessions.create()
    for name in "abc":
        kept.commit(document(name), f"open {name}")
    kept.close()
    file = folder_of(sessions, kept.id) / "journal.jsonl"
    lines = file.read_bytes().splitlines(keepends=True)
    damaged = b"".join([*lines[:2], lines[2].replace(b"open", b"opfn"), *lines[3:]])
    file.write_bytes(damaged)
    again = sessions.open(kept.id)
    assert "line 3 of 4 is damaged" in again.damage
    assert again.history.undo_label == "open a"
    assert file.with_name("damaged.jsonl").read_bytes() == damaged
    again.close()


def test_a_session_of_which_nothing_can_be_read_is_not_offered_and_can_be_forgotten(sessions):
    id, good = filled(sessions, "head"), filled(sessions, "hand")
    (folder_of(sessions, id) / "journal.jsonl").write_bytes(b"nothing")
    assert [offer.id for offer in sessions.offers()] == [good]
    for _ in range(2):  # and no lock is left behind
        with pytest.raises(InvalidFile, match="start is damaged"):
            sessions.open(id)
    sessions.forget(id)


@pytest.mark.parametrize("about", ["", "[]", "{}", '{"created": "x"}', '{"created": null}'])
def test_a_damaged_note_is_made_anew(sessions, about):
    id = filled(sessions, "head")
    (folder_of(sessions, id) / "about.json").write_text(about)
    (offer,) = sessions.offers()
    assert (offer.meshes, offer.steps) == (("head",), 1)


# Tidying


def test_the_newest_sessions_stay(sessions):
    running = sessions.create()
    running.commit(document("running"), "open")
    ids = [filled(sessions, str(n)) for n in range(MOST + 3)]
    for n, id in enumerate(ids):
        age(sessions, 5000 - n, f"sessions/{id}/journal.jsonl")
    age(sessions, 9000, f"sessions/{running.id}/journal.jsonl")
    sessions.tidy()
    assert {offer.id for offer in sessions.offers()} == set(ids[3:])
    assert running.commit(document("again"), "open")
    running.close()
    assert running.id in {offer.id for offer in sessions.offers()}


def test_old_folders_with_nothing_in_them_go_and_young_ones_stay(sessions):
    for name in ("0" * 16, "1" * 16):
        folder_of(sessions, name).mkdir()
    age(sessions, 9000, f"sessions/{'0' * 16}")
    sessions.tidy()
    assert [path.name for path in (sessions.folder / "sessions").iterdir()] == ["1" * 16]


def test_blobs_that_a_session_can_come_back_to_stay(sessions):
    blobs = [sessions.blobs.put(bytes([n])) for n in range(6)]
    kept = sessions.create()
    for blob in blobs[:4]:
        kept.commit(document("head", ids=range(100), quad=blob), "change")
    kept.undo()  # its blob may be needed again
    kept.commit(document("head", ids=range(200), quad=blobs[4]), "change")  # now it may not
    kept.undo()
    kept.close()
    sessions.open(kept.id).close()
    age(sessions, 9000)
    assert sessions.tidy() == 2
    again = sessions.open(kept.id)
    assert again.redo().document == document("head", ids=range(200), quad=blobs[4])
    again.close()
    for blob in (*blobs[:3], blobs[4]):
        sessions.blobs.get(blob)
    for blob in (blobs[3], blobs[5]):
        with pytest.raises(InvalidFile):
            sessions.blobs.get(blob)


def test_young_blobs_stay(sessions):
    blob = sessions.blobs.put(b"of an upload that is going on")
    assert sessions.tidy() == 0
    assert sessions.blobs.get(blob)


def test_blobs_that_a_running_session_used_stay_however_old(sessions):
    before = sessions.blobs.put(b"before")
    age(sessions, 50_000, "blobs/*")
    kept = sessions.create()
    during = sessions.blobs.put(b"during")
    age(sessions, 10_000, "blobs/" + during)
    age(sessions, 20_000, f"sessions/{kept.id}/lock")
    assert opened(sessions.folder).tidy() == 1
    with pytest.raises(InvalidFile):
        sessions.blobs.get(before)
    kept.close()
    assert opened(sessions.folder).tidy() == 1
    with pytest.raises(InvalidFile):
        sessions.blobs.get(during)


# Where


@pytest.mark.skipif(os.name == "nt", reason="permissions are of another kind there")
def test_only_its_owner_can_look_into_the_folder(sessions):
    kept = sessions.create()
    for path in (sessions.folder, sessions.blobs.folder, folder_of(sessions, kept.id)):
        assert path.stat().st_mode & 0o777 == 0o700
    kept.close()


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InvalidInput, match="cannot make"):
        opened(tmp_path / "file" / "henkei")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere it is another place")
def test_by_default_sessions_are_where_the_system_keeps_them(tmp_path, monkeypatch):
    pytest.importorskip("platformdirs")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert opened(None).folder == tmp_path / "henkei"


def test_the_usual_place_is_looked_up_only_when_it_is_needed(sessions, monkeypatch):
    monkeypatch.setitem(sys.modules, "platformdirs", None)
    assert opened(sessions.folder).offers() == []
    with pytest.raises(InvalidInput, match="name a folder"):
        opened(None)
