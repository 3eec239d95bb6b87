"""What stands in a journal: its lines, and the steps that they tell of."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Generic

from henkei.errors import HenkeiError, InvalidFile, InvalidInput
from henkei.studio.blobs import Blobs
from henkei.studio.history import Document, History, Step
from henkei.studio.packing import packed, unpacked

FORM = 1
_dumps = partial(json.dumps, separators=(",", ":"))


@dataclass(frozen=True, eq=False)
class Parts:
    """A document as it is written: each top-level part as JSON text. No two of them are equal."""

    texts: Mapping[str, str]

    def sharing(self, other: Parts) -> Parts:
        """The same, with the texts of another one where they are equal, to need less memory."""
        equal = {name: text for name, text in other.texts.items() if self.texts.get(name) == text}
        return Parts({**self.texts, **equal})


@dataclass(frozen=True)
class Codec(Generic[Document]):
    """How documents are written and read.

    blobs : for long lists of numbers.
    dump : gives a document as plain data, by top-level part.
    load : the document of such data; ValueError or HenkeiError if it is none.
    """

    blobs: Blobs
    dump: Callable[[Document], Mapping[str, Any]]
    load: Callable[[dict[str, Any]], Document]

    def parts(self, document: Document) -> Parts:
        """A document as text; with all numbers in it if the disk refuses blobs."""
        data = self.dump(document)
        with suppress(InvalidInput):
            data = {name: packed(part, self.blobs) for name, part in data.items()}
        return Parts({name: _dumps(part) for name, part in data.items()})

    def document(self, parts: Parts) -> Document:
        """The document of a text.

        Raises
        ------
        InvalidFile : a blob is missing or damaged, or another version wrote it.
        """
        try:
            data = {name: json.loads(text) for name, text in parts.texts.items()}
            return self.load({name: unpacked(part, self.blobs) for name, part in data.items()})
        except (HenkeiError, ValueError) as error:
            why = " ".join(str(error).split())[:300]
            raise InvalidFile(f"what was saved of this step cannot be read: {why}") from None


@dataclass(frozen=True)
class Record:
    """What a journal tells of.

    steps : up to the first damage.
    damage : what is damaged, if anything is.
    asked : ids of the messages that asked for what was done last.
    """

    steps: History[Parts]
    damage: str | None = None
    asked: tuple[Any, ...] = ()


def read(file: Path) -> Record:
    """The steps in a journal; a draft that was neither committed nor dropped is the last one.

    A last line that is torn or damaged is left out, as it comes from a process that was killed.

    Raises
    ------
    InvalidFile : there is no such file, or not even its first line can be read.
    """
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InvalidFile(f"{file}: cannot be read ({error.strerror or error})") from None
    steps: History[Parts] | None = None
    damage = None
    asked: list[Any] = []
    found = content.removesuffix(b"\n").split(b"\n")
    for number, text in enumerate(found, 1):
        try:
            entry = _entry(text)
            steps = _after(steps, entry)
            asked += entry.get("asked", [])
        except (HenkeiError, ValueError, TypeError, LookupError, AttributeError) as error:
            if number < len(found):
                damage = f"line {number} of {len(found)} is damaged ({error}): later ones are lost"
            break
    if steps is None:
        raise InvalidFile(f"{file}: no journal, or one of another version, or its start is damaged")
    draft = steps.drafted
    if draft is not None and draft.document.texts != steps.committed.texts:
        steps.commit(draft.document, draft.label, draft.tab)
    steps.drop()
    return Record(steps, damage, tuple(asked))


def replay(record: Record, codec: Codec[Document]) -> tuple[History[Document], Record]:
    """The history that a journal tells of; its documents are read when they are asked for.

    Steps at the end that cannot be read are left out, in the record too.

    Raises
    ------
    InvalidFile : no step can be read.
    """
    kept = record.steps
    steps = [Step(s.label, s.tab, partial(_document, codec, s)) for s in kept.steps]
    failure: InvalidFile | None = None
    for position in range(kept.position, -1, -1):
        end = len(steps) if failure is None else position + 1
        try:
            history = History.restored(steps[:end], position)
        except InvalidFile as error:
            failure = failure or error
        else:
            damage = f"{failure}; it is left out" if failure else record.damage
            left = History.restored(kept.steps[:end], position)
            return history, replace(record, steps=left, damage=damage)
    raise failure or InvalidFile("there is no step")


def lines(steps: History[Parts], whole_every: int, asked: Sequence[Any] = ()) -> Iterator[bytes]:
    """The lines of a journal that tells of these steps, and of the draft.

    whole_every : so many lines with documents apart, one is whole.
    asked : what is told of messages, see :class:`Record`.
    """
    base: Parts | None = None
    for number, step in enumerate(steps.steps):
        if number:
            yield line_of("commit", step, base if number % whole_every else None)
        else:
            yield line_of("start", step, None, asked)
        base = step.document
    for _ in range(len(steps.steps) - 1 - steps.position):
        yield line("undo")
    if steps.drafted is not None:
        yield line_of("draft", steps.drafted, steps.committed)


def line_of(kind: str, step: Step[Parts], base: Parts | None, asked: Sequence[Any] = ()) -> bytes:
    """A line with the document of a step.

    base : the committed document before it, whose parts are left out; None to write all of them.
    asked : as in :func:`line`.
    """
    texts = step.document.texts
    about = {"label": _dumps(step.label), "tab": _dumps(step.tab), "form": _dumps(FORM)}
    if base is None or list(base.texts) != list(texts):
        return line(kind, asked, **about, document=_object(texts))
    changed = {name: text for name, text in texts.items() if base.texts[name] != text}
    return line(kind, asked, **about, changed=_object(changed))


def line(kind: str, asked: Sequence[Any] = (), **fields: str) -> bytes:
    """A line with a checksum.

    asked : ids of the messages that asked for it.
    fields : JSON texts.
    """
    because = {"asked": _dumps(list(asked))} if asked else {}
    text = _object({"kind": _dumps(kind), **because, **fields}).encode("ascii")
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _object(texts: Mapping[str, str]) -> str:
    return "{" + ",".join(f"{_dumps(name)}:{text}" for name, text in texts.items()) + "}"


def _entry(text: bytes) -> dict[str, Any]:
    """What a line says."""
    checksum, _, content = text.partition(b" ")
    if checksum != b"%08x" % zlib.crc32(content):
        raise InvalidFile("its checksum is another one")
    entry: dict[str, Any] = json.loads(content)
    if entry.get("form", FORM) != FORM:
        raise InvalidFile(f"it has form {entry['form']}, this version reads {FORM}")
    return entry


def _after(steps: History[Parts] | None, entry: dict[str, Any]) -> History[Parts]:
    """The steps after a line."""
    kind = entry["kind"]
    if steps is None:
        if kind != "start":
            raise InvalidFile("there is no start before it")
        return History(_parts(entry, None))
    match kind:
        case "commit":
            steps.commit(_parts(entry, steps.committed), entry["label"], entry["tab"])
        case "draft":
            steps.draft(_parts(entry, steps.committed), entry["label"], entry["tab"])
        case "drop":
            steps.drop()
        case "undo":
            steps.undo()
        case "redo":
            steps.redo()
        case _:
            raise InvalidFile(f"{kind!r} is of another version")
    return steps


def _parts(entry: dict[str, Any], base: Parts | None) -> Parts:
    whole = "document" in entry
    given = entry["document" if whole else "changed"].items()
    parts = Parts({name: _dumps(part) for name, part in given})
    if base is None:
        return parts
    return parts.sharing(base) if whole else Parts({**base.texts, **parts.texts})


def _document(codec: Codec[Document], step: Step[Parts]) -> Document:
    return codec.document(step.document)
