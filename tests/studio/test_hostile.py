"""A studio among enemies: no message and no file ends it, each is answered in words, none stays."""

from __future__ import annotations

import json
import string
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import psutil
import pytest

import henkei as hk
from driven import RunningStudio, studio_running
from henkei.shapes import cube_cage, random_disk
from henkei.studio.document import TABS
from henkei.studio.document_actions import _KINDS as DOCUMENT
from henkei.errors import InvalidInput
from henkei.studio.link import KINDS
from henkei.studio.messages import decode, encode
from henkei.studio.tabs.base import LongAction
from hostile_files import lies, mutated, sound
from spoken import Page, requesting, speaking, upload

MESSAGES, FILES = 10_000, 200
WARM_UP = 2_500  # messages of the same kind, before memory is measured
GROWTH = 1.10
HUGE = 300_000  # numbers
SLOW = {"bomb.vtp"}  # a gigabyte a second is unpacked until the memory that it may have is full


class Damage:
    """Messages as no page sends them."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self._count = 0
        self.schemas = {
            (tab, name): (kind.model_json_schema(), issubclass(kind, LongAction))
            for tab, one in TABS.items()
            for name, kind in one.actions.items()
        } | {
            ("document", name): (kind.model_json_schema(), False) for name, kind in DOCUMENT.items()
        }

    def messages(self, count: int) -> Iterator[bytes]:
        """``count`` messages; each is answered or, if it is sound after all, does something."""
        kinds = [self.noise, self.header, self.action, self.action, self.broken, self.arrays]
        for number in range(count):
            yield kinds[number % len(kinds)]()

    def any_of(self, values: Sequence[Any]) -> Any:
        return values[int(self.rng.integers(len(values)))]

    def text(self, most: int = 30) -> str:
        letters = string.printable + "äß漢\u202e\x00\ud7ff"
        return "".join(self.any_of(letters) for _ in range(int(self.rng.integers(most))))

    def noise(self) -> bytes:
        """Bytes."""
        return self.rng.bytes(int(self.rng.integers(200)))

    def value(self, depth: int = 0) -> Any:
        """Anything that JSON can say, and NaN."""
        plain = [
            None, True, False, 0, -1, 1e308, 5e-324, 2**31, 2**53, 2**64, 10**30, -0.5, "", "m1",
            self.text(), "x" * 10_000, [], {}, [0] * 100, ["a", 1, None], float("nan"),
            {"blob": "0" * 32}, {"vertices": [0, 1]}, {"file": "/etc/passwd"},
        ]  # fmt: skip
        if depth < 3 and self.rng.random() < 0.2:
            return [self.value(depth + 1) for _ in range(int(self.rng.integers(5)))]
        if depth < 3 and self.rng.random() < 0.2:
            return {self.text(8): self.value(depth + 1) for _ in range(int(self.rng.integers(4)))}
        return self.any_of(plain)

    def header(self) -> bytes:
        """A JSON header in which anything may be anything."""
        known = {
            "kind": ["hello", "do", "live", "grab", "drop", "undo", "redo", "cancel", "ack", "?"],
            "tab": [*TABS, "document", "nothing"],
            "action": [name for _, name in self.schemas],
            "arguments": [{}],
            "session": [None, "0" * 16],
            "bits": [16, 32],
            "number": [1],
            "job": ["j1"],
        }
        header = {name: self.any_of(values) for name, values in known.items()}
        for name in list(header):
            if self.rng.random() < 0.15:
                del header[name]
            elif self.rng.random() < 0.3:
                header[name] = self.value()
        return self.packed(header)

    def action(self) -> bytes:
        """An action of a tab with arguments of which some are right."""
        (tab, name), (schema, long) = self.any_of(list(self.schemas.items()))
        arguments = self.meant(schema, schema.get("$defs", {}))
        names = list(arguments)
        what = int(self.rng.integers(5))
        if names and what == 0:
            del arguments[self.any_of(names)]
        elif names and what in (1, 2):
            arguments[self.any_of(names)] = self.value()
        elif what == 3 or long:
            arguments[self.text() or "more"] = self.value()
        kind = "live" if self.rng.random() < 0.25 else "grab" if self.rng.random() < 0.1 else "do"
        return self.packed({"kind": kind, "tab": tab, "action": name, "arguments": arguments})

    def meant(self, schema: Any, known: dict[str, Any], depth: int = 0) -> Any:
        """Something of a form that a JSON schema allows."""
        if "$ref" in schema:
            return self.meant(known[schema["$ref"].rpartition("/")[2]], known, depth)
        for of in ("anyOf", "oneOf"):
            if of in schema:
                return self.meant(self.any_of(schema[of]), known, depth)
        if "const" in schema or "enum" in schema:
            return self.any_of(schema.get("enum") or [schema["const"]])
        match schema.get("type"):
            case "object":
                required = schema.get("required", [])
                return {
                    name: self.meant(one, known, depth + 1)
                    for name, one in schema.get("properties", {}).items()
                    if name in required or (depth < 4 and self.rng.random() < 0.4)
                }
            case "array":
                if "prefixItems" in schema:
                    return [self.meant(one, known, depth + 1) for one in schema["prefixItems"]]
                least = schema.get("minItems", 0)
                count = least + int(self.rng.integers(4)) if depth < 6 else least
                return [self.meant(schema.get("items", {}), known, depth + 1) for _ in range(count)]
            case "integer":
                return int(self.any_of([0, 1, 2, 3, 7, 100, 10**6, 10**9, -1]))
            case "number":
                return float(self.any_of([0.0, 1.0, -2.5, 1e-12, 1e12, 1e300]))
            case "string":
                return self.any_of(["m1", "m2", "handle 1", "fixed 1", "auto", "mesh", self.text()])
            case "boolean":
                return bool(self.rng.integers(2))
            case "null":
                return None
        return self.value()

    def broken(self) -> bytes:
        """A sound message with some of its bytes lost, doubled, or others."""
        data = self.action() if self.rng.random() < 0.5 else self.header()
        return mutated(data, int(self.rng.integers(2**31)))

    def arrays(self) -> bytes:
        """Arrays that are huge, not all there, of other types, or of NaN, for any action."""
        (tab, name), (schema, _) = self.any_of(list(self.schemas.items()))
        large = self.rng.random() < 0.005
        shape = [HUGE] if large else self.any_of([[0], [3], [2, 3], [1, 1, 1, 1], [64, 3]])
        dtype = self.any_of(["<f4", "<f8", "<u4", "<i4", "<u2", "u1"])
        values = np.full(shape, np.nan if "f" in dtype else 200).astype(dtype)
        place = self.any_of([*schema.get("properties", {}), "kind", "more"])
        if self.rng.random() < 0.5:
            header = {"kind": "do", "tab": tab, "action": name, "id": self.ident()}
            return encode(header, **{place: values})
        wrong = self.any_of([10**12, -1, "3", None, 2**62, 1.5, [3]])
        table = [[place, self.any_of(["f4", "f8", "c16", "O", 4]), [wrong, 3]]]
        return self.packed({"kind": "do", "tab": tab, "action": name, "arrays": table})

    def ident(self) -> str:
        """Of a message, like no other's."""
        self._count += 1
        return f"damaged {self._count}"

    def packed(self, header: dict[str, Any]) -> bytes:
        """As :func:`encode`, without its checks."""
        text = json.dumps({"id": self.ident(), **header}).encode()
        return len(text).to_bytes(4, "little") + text


def is_clear(message: str) -> bool:
    """Whether it says something, and does not blame henkei."""
    return len(message.split()) >= 3 and "henkei" not in message.replace("henkei studio", "")


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningStudio]:
    with studio_running(tmp_path_factory.mktemp("studio")) as running:
        yield running


def begin(page: Page, client: httpx.Client, folder: Path) -> None:
    """A session with something in every tab, small enough that all is quick."""
    page.do("document", "new")
    for name, surface in (("disk", random_disk(60)), ("cage", cube_cage())):
        path = folder / f"{name}.obj"
        hk.write(path, surface)
        assert "mesh" in upload(client, path.name, path.read_bytes())
    for tab in ("register", "quad", "design", "combine", "deform"):
        page.do("document", "show", name=tab)
    page.do("design", "use", slot="cage", mesh="m2")
    page.do("deform", "use", slot="mesh", mesh="m1")
    bend(page)


def bend(page: Page) -> None:
    """What a person does in a tab, from nothing."""
    for kind, vertices in (("fixed", [0, 1, 2]), ("handles", [30, 31])):
        page.do("deform", "select_vertices", vertices=vertices)
        page.do("deform", "add", kind=kind)


def attack(page: Page, messages: Sequence[bytes]) -> tuple[int, int]:
    """Send messages, and hear an answer to each; how many were refused, and how many done."""
    wanted, anonymous = set(), 0
    for data in messages:
        ident = answered(data)
        if ident is None:
            anonymous += 1
        elif ident:
            wanted.add(ident)
        page.send(data)
    page.say(kind="cancel", job="none", id="last")
    refused = done = 0
    while True:
        message = page.hear()
        ident = message.header.get("id")
        if message.kind == "done":
            if ident == "last":
                break
            wanted.remove(ident)
            done += 1
        elif message.kind == "refused":
            told = message.header["message"]
            assert is_clear(told), told
            refused += 1
            if ident is None:
                anonymous -= 1
            else:
                wanted.remove(ident)
    assert not wanted
    assert anonymous <= 0
    return refused, done


def answered(data: bytes) -> str | None:
    """The id in the answer that a message must get: None for one without; nothing for no answer."""
    try:
        header = decode(data).header
    except InvalidInput:
        return None
    kind, ident = header.get("kind"), header.get("id")
    ...
