"""The sessions of a person on the disk: each in a folder, whose steps outlast any end of it."""

from __future__ import annotations

import json
import os
import re
import secrets
import shutil
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Generic

from henkei.errors import HenkeiError, InvalidFile, InvalidInput, MissingDependency
from henkei.io.whole import whole
from henkei.studio.blobs import Blobs
from henkei.studio.history import Document, History, Step
from henkei.studio.journal import NAME, Journal
from henkei.studio.lines import Codec, Parts, Record, read, replay
from henkei.studio.locks import Lock, held

ABOUT, LOCK, DAMAGED = "about.json", "lock", "damaged.jsonl"
MOST = 20  # sessions that are kept
AT_HAND = 4  # steps back whose documents are in memory, which may be large; older ones are read
YOUNG = 3600.0  # seconds in which what nothing refers to is left alone
_ID = re.compile("[0-9a-f]{16}")
_BLOB = re.compile(rb"(?<![0-9a-f])[0-9a-f]{32}(?![0-9a-f])")
_TRIES, _PAUSE = 20, 0.01  # others hold a lock for a moment when they look whether it is held


@dataclass(frozen=True)
class Offer:
    """A session that can be opened.

    created, changed : seconds since the epoch.
    size : of its journal, in bytes.
    meshes : their names.
    steps : how many can be undone or done again.
    """

    id: str
    created: float
    changed: float
    size: int
    meshes: tuple[str, ...] = ()
    steps: int = 0


class Kept(Generic[Document]):
    """A session that is open: its history, every step of which is saved.

    damage : what could not be read of it, if anything was damaged.
    """

    def __init__(
        self,
        id: str,
        history: History[Document],
        journal: Journal[Document],
        damage: str | None,
        closed: Callable[[], None],
    ) -> None:
        self.id, self.history, self.damage = id, history, damage
        self._journal, self._closed = journal, closed

    @property
    def trouble(self) -> str | None:
        """Why nothing is saved at present, if that is so."""
        return self._journal.trouble

    @property
    def asked(self) -> tuple[Any, ...]:
        """Ids of the messages that asked for what was done last, also before it was opened."""
        return tuple(self._journal.asked)

    def commit(self, document: Document, label: str, tab: str = "", asked: Any = None) -> bool:
        """As :meth:`History.commit`, for a message of the id ``asked``."""
        if not self.history.commit(document, label, tab):
            self._journal.drop(asked)
            return False
        self._journal.commit(document, label, tab, asked)
        old = self.history.position - AT_HAND
        if old >= 0:
            self.history.let_go(old, self._journal.recall(old))
        return True

    def draft(self, document: Document, label: str = "", tab: str = "") -> None:
        """As :meth:`History.draft`; if the process ends now, the draft will be the last step."""
        self.history.draft(document, label, tab)
        self._journal.draft(document, label, tab)

    def drop(self) -> None:
        """As :meth:`History.drop`."""
        self.history.drop()
        self._journal.drop()

    def undo(self, asked: Any = None) -> Step[Document]:
        """As :meth:`History.undo`."""
        step = self.history.undo()
        self._journal.undo(asked)
        return step

    def redo(self, asked: Any = None) -> Step[Document]:
        """As :meth:`History.redo`."""
        step = self.history.redo()
        self._journal.redo(asked)
        return step

    def close(self) -> None:
        """Save what waits, and let others open it."""
        self._journal.close()
        self._closed()


class Sessions(Generic[Document]):
    """All sessions in a folder; several studios may use it at a time.

    Parameters
    ----------
    start : the document of a new session.
    dump, load : see :class:`henkei.studio.lines.Codec`; the meshes of a document are its part
        ``meshes``, each with a ``name``.
    folder : where; by default where the system keeps such things of a person.
    fsync : see :class:`henkei.studio.journal.Journal`.

    Raises
    ------
    InvalidInput : the folder cannot be made.
    """

    def __init__(
        self,
        start: Document,
        dump: Callable[[Document], Mapping[str, Any]],
        load: Callable[[dict[str, Any]], Document],
        folder: str | os.PathLike[str] | None = None,
        *,
        fsync: bool = False,
    ) -> None:
        self.folder = _usual_folder() if folder is None else Path(folder)
        _make(self.folder)
        self.blobs = Blobs(self.folder / "blobs")
        self._sessions = self.folder / "sessions"
        _make(self._sessions)
        self._start, self._codec, self._fsync = start, Codec(self.blobs, dump, load), fsync

    def create(self) -> Kept[Document]:
        """A new session."""
        id = secrets.token_hex(8)
        folder = self._sessions / id
        _make(folder)
        lock = _taken(folder)
        steps = History(self._codec.parts(self._start))
        journal = Journal(folder, self._codec, steps, fsync=self._fsync)
        with suppress(HenkeiError, OSError):
            self._about(folder)
        return Kept(id, History(self._start), journal, None, lambda: self._closed(folder, lock))

    def open(self, id: str) -> Kept[Document]:
        """Go on with a session.

        Raises
        ------
        InvalidInput : it is open already, here or in another studio.
        InvalidFile : there is no such session, or nothing of it can be read.
        """
        folder = self._folder(id)
        lock = _taken(folder)
        try:
            history, record = replay(read(folder / NAME), self._codec)
            journal = self._continued(folder, record)
        except BaseException:
            lock.release()
            raise
        return Kept(id, history, journal, record.damage, lambda: self._closed(folder, lock))

    def offers(self) -> list[Offer]:
        """Sessions with something in them that nobody has open, the last changed first."""
        offers = []
        for folder in self._folders():
            with suppress(HenkeiError, OSError):
                if not held(folder / LOCK):
                    offers.append(self._about(folder))
        offers = [offer for offer in offers if offer.steps or offer.meshes]
        return sorted(offers, key=lambda offer: (-offer.changed, offer.id))

    def listed(self, but: str) -> list[dict[str, Any]]:
        """Those offers in which meshes are, as pages are told of them; ``but`` one session."""
        return [
            {"session": one.id, "saved": one.changed, "meshes": list(one.meshes)}
            for one in self.offers()
            if one.id != but and one.meshes
        ]

    def forget(self, id: str) -> None:
        """Remove a session.

        Raises
        ------
        InvalidInput : it is open, here or in another studio.
        InvalidFile : there is no such session.
        """
        folder = self._folder(id)
        _remove(folder, _taken(folder))

    def tidy(self) -> int:
        """Remove what is of no use: all but the newest sessions, and blobs that no session needs.

        Sessions that are open stay, and all blobs that one of them used since it was opened. The
        answer is how many blobs were removed.
        """
        young = time.time() - YOUNG
        before = young
        folders = sorted(((_changed(folder), folder) for folder in self._folders()), reverse=True)
        for place, (changed, folder) in enumerate(folders):
            with suppress(HenkeiError, OSError):
                if held(folder / LOCK):
                    before = min(before, (folder / LOCK).stat().st_mtime)
                elif place >= MOST or (changed < young and self._is_empty(folder)):
                    self.forget(folder.name)
        try:
            return self.blobs.sweep(self._needed(), before)
        except OSError:
            return 0  # what cannot be read may need any of them

    def _continued(self, folder: Path, record: Record) -> Journal[Document]:
        """The journal of a session that goes on; that it is opened is no change."""
        file = folder / NAME
        times = file.stat()
        if record.damage:
            with suppress(OSError):
                shutil.copyfile(file, folder / DAMAGED)
        journal = Journal(folder, self._codec, record.steps, record.asked, fsync=self._fsync)
        with suppress(OSError):
            os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))
        return journal

    def _folders(self) -> list[Path]:
        return [folder for folder in self._sessions.iterdir() if _ID.fullmatch(folder.name)]

    def _folder(self, id: str) -> Path:
        if not isinstance(id, str) or not _ID.fullmatch(id):
            raise InvalidInput(f"{str(id)[:40]!r} is no id of a session: 16 hexadecimal digits")
        folder = self._sessions / id
        if not folder.is_dir():
            raise InvalidFile(f"there is no session {id} any more")
        return folder

    def _about(self, folder: Path) -> Offer:
        """What is known of a session, read from its journal if that has changed since."""
        state = (folder / NAME).stat()
        changed, size = state.st_mtime, state.st_size
        known = _noted(folder)
        if known is not None and (known.changed, known.size) == (changed, size):
            return known
        created = changed if known is None else known.created
        steps = read(folder / NAME).steps
        done = len(steps.steps) - 1
        offer = Offer(folder.name, created, changed, size, _meshes(steps.now), done)
        with suppress(InvalidInput), whole(folder / ABOUT, "w") as stream:
            json.dump(asdict(offer), stream)
        return offer

    def _is_empty(self, folder: Path) -> bool:
        if not (folder / NAME).exists():
            return True
        offer = self._about(folder)
        return not (offer.steps or offer.meshes)

    def _closed(self, folder: Path, lock: Lock) -> None:
        """A session is no longer open; if there is nothing in it, it goes."""
        empty = False
        with suppress(HenkeiError, OSError):
            empty = self._is_empty(folder)
        if empty:
            _remove(folder, lock)
        lock.release()

    def _needed(self) -> set[str]:
        """The blobs that sessions name."""
        needed: set[str] = set()
        for file in self._sessions.glob("*/*.jsonl"):
            with suppress(FileNotFoundError):
                needed.update(blob.decode() for blob in _BLOB.findall(file.read_bytes()))
        return needed


def _usual_folder() -> Path:
    try:
        from platformdirs import user_state_path
    except ImportError:
        raise MissingDependency(
            "where to keep sessions is not known; pip install henkei[studio], or name a folder"
        ) from None
    return user_state_path("henkei", appauthor=False)


def _make(folder: Path) -> None:
    """Make a folder that only this person can look into."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"cannot make the folder {folder}: {error.strerror}") from error


def _taken(folder: Path) -> Lock:
    """The lock of a session, held.

    Raises
    ------
    InvalidInput : another holds it.
    """
    lock = Lock(folder / LOCK)
    for _ in range(_TRIES):
        if lock.take():
            return lock
        time.sleep(_PAUSE)
    raise InvalidInput(f"session {folder.name} is open already; close it there first")


def _remove(folder: Path, lock: Lock) -> None:
    """Remove a session whose lock is held, and let go of it; its file is the last that goes."""
    for file in folder.iterdir():
        if file != lock.path:
            with suppress(OSError):
                file.unlink()
    lock.release()
    shutil.rmtree(folder, ignore_errors=True)


def _changed(folder: Path) -> float:
    """When the session's last line was written, or its folder made."""
    for path in (folder / NAME, folder):
        with suppress(OSError):
            return path.stat().st_mtime
    return 0.0


def _noted(folder: Path) -> Offer | None:
    """What was noted of a session, if it can be read."""
    try:
        note = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
        return Offer(
            folder.name,
            float(note["created"]),
            float(note["changed"]),
            int(note["size"]),
            tuple(str(name) for name in note["meshes"]),
            int(note["steps"]),
        )
    except (OSError, ValueError, TypeError, LookupError):
        return None


def _meshes(parts: Parts) -> tuple[str, ...]:
    """Names of the meshes that a document has open."""
    entries = json.loads(parts.texts.get("meshes", "[]"))
    entries = entries if isinstance(entries, list) else []
    return tuple(str(one["name"]) for one in entries if isinstance(one, dict) and "name" in one)
