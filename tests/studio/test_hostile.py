"""A studio among enemies: no message and no file ends it, each is answered in words, none stays."""

from __future__ import annotations

import json
import os
import random
import re
import string
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from copy import deepcopy
from math import nan
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

import henkei as hk
from driven import RunningStudio, studio_running
from henkei.errors import InvalidInput
from henkei.shapes import cube_cage, random_disk
from henkei.studio.document import TABS
from henkei.studio.document_actions import _KINDS as DOCUMENT
from henkei.studio.link import KINDS
from henkei.studio.messages import decode, encode
from henkei.studio.tabs.base import LongAction
from hostile_files import lies, mutated, sound
from spoken import Page, requesting, speaking, upload

NOTHING = object()  # stands for no answer
MESSAGES = 10_000
FILES = 200 if os.environ.get("HENKEI_THOROUGH") else 60  # each costs half a second
WARM_UP = 2_500  # messages of the same kind, before memory is measured
GROWTH = 1.10
LEVELS = 7  # of a design, at most; such a message is among them
TOGETHER = 50  # messages before their answers are awaited
HUGE = 300_000  # numbers
linux = pytest.mark.skipif(sys.platform != "linux", reason="memory as Linux tells it")
SLOW = {"bomb.vtp"}  # a gigabyte a second is unpacked until the memory that it may have is full


CAMERA = {"position": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0], "aspect": 1.5}
BENT = {
    "fixed": [{"name": "fixed 1", "region": {"vertices": [0, 1, 2]}}],
    "handles": [{"name": "handle 1", "region": {"vertices": [30, 31]}, "weight": 2.0}],
    "pins": [{"point": 40, "to": [0.0, 0.0, 1.0]}],
    "features": [{"name": "flat", "region": {"vertices": [20, 21, 22]}, "scale": 1.5}],
}
DESIGNED = {
    "levels": 2,
    "gamma": 0.5,
    "pins": [{"name": "pin 1", "level": 1, "point": 9, "to": [0.0, 0.0, 1.0]}],
    "curves": [{"level": 1, "path": [0, 8], "to": [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]}],
}
SLOTS = [("combine", "a", "m1"), ("combine", "b", "m3"), ("deform", "mesh", "m1")]
SLOTS += [("design", "cage", "m2"), ("register", "source", "m1"), ("quad", "mesh", "m1")]
SOUND = [
    ("deform", "load", {"recipe": BENT}),
    ("deform", "select", {"outline": {"camera": CAMERA, "polygon": [[-1, -1], [1, -1], [0, 1]]}}),
    ("deform", "add", {"kind": "handles"}),
    ("deform", "move_handle", {"name": "handle 1", "move": {"translation": [0, 0, 0.1]}}),
    ("deform", "set_feature", {"name": "flat", "scale": 2.0}),
    ("deform", "change", {"recipe": {"method": "linear", "about": "flat"}}),
    ("design", "load", {"recipe": DESIGNED}),
    ("design", "move_pin", {"name": "pin 1", "to": [0.0, 1.0, 0.0]}),
    ("design", "draw", {"level": 0, "vertex": 1}),
    ("design", "change", {"gamma": 0.2}),
    ("combine", "load", {"recipe": {"pairs": [[0, 0], [3, 3], [6, 6]], "landmarks": [[30, 30]]}}),
    ("combine", "add_pair", {"kind": "pairs", "a": 5, "b": 5}),
    ("register", "load", {"recipe": {"landmarks": [[0, 0], [1, 1]]}}),
    ("quad", "load", {"recipe": {"quads": 100, "sharp": 30.0}}),
    ("document", "rename", {"mesh": "m1", "name": "another"}),
]


class Damage:
    """Messages as no page sends them."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self._count = 0
        kinds = {
            (tab, name): kind for tab, one in TABS.items() for name, kind in one.actions.items()
        }
        kinds |= {("document", name): kind for name, kind in DOCUMENT.items()}
        self.actions = [
            (tab, name, kind.model_json_schema(), issubclass(kind, LongAction))
            for (tab, name), kind in kinds.items()
        ]

    def messages(self, count: int) -> Iterator[bytes]:
        """``count`` messages; now and then one that is sound after all."""
        kinds = [self.noise, self.header, self.action, self.changed, self.broken, self.arrays]
        for number in range(count):
            yield kinds[number % len(kinds)]()

    def noise(self) -> bytes:
        """Any bytes."""
        return self.random.randbytes(self.random.randrange(200))

    def header(self) -> bytes:
        """A header in which anything may be anything."""
        known: dict[str, Sequence[Any]] = {
            "kind": [*KINDS, "?"],
            "tab": [*TABS, "document", "nothing"],
            "action": [name for _, name, *_ in self.actions],
            "arguments": [{}],
            "session": [None, "0" * 16],
            "bits": [16, 32],
            "number": [1],
            "job": ["j1"],
        }
        header = {}
        for name, values in known.items():
            chance = self.random.random()
            if chance > 0.15:
                header[name] = self.anything() if chance > 0.7 else self.random.choice(values)
        return self.packed(**header)

    def action(self) -> bytes:
        """An action with arguments of the right form, or nearly."""
        tab, name, schema, long = self.random.choice(self.actions)
        arguments = self.meant(schema, schema.get("$defs", {}))
        if long or self.random.random() < 0.2:
            arguments[self.text() or "more"] = self.anything()
        return self.packed(
            kind=self.kind(), tab=tab, action=name, arguments=self.spoiled(arguments, 0.3)
        )

    def changed(self) -> bytes:
        """A sound action of a person, of which something is lost, doubled or another thing."""
        tab, name, arguments = self.random.choice(SOUND)
        arguments = self.spoiled(arguments, 0.9)
        return self.packed(kind=self.kind(), tab=tab, action=name, arguments=arguments)

    def broken(self) -> bytes:
        """A message with some of its bytes lost, doubled, or others."""
        return mutated(
            self.random.choice([self.action, self.header])(), self.random.randrange(2**31)
        )

    def arrays(self) -> bytes:
        """Arrays that are huge, not all there, of other types, or of NaN, for any action."""
        tab, name, schema, _ = self.random.choice(self.actions)
        place = self.random.choice([*schema.get("properties", {}), "kind", "more"])
        header = {"kind": "do", "tab": tab, "action": name, "id": self.ident()}
        if self.random.random() < 0.5:
            wrong = self.random.choice([10**12, -1, "3", None, 2**62, 1.5, [3]])
            kind = self.random.choice(["f4", "f8", "c16", "O", 4])
            return self.packed(**header, arrays=[[place, kind, [wrong, 3]]])
        large = self.random.random() < 0.01
        shape = [HUGE] if large else self.random.choice([[0], [3], [2, 3], [1, 1, 1, 1], [64, 3]])
        dtype = self.random.choice(["<f4", "<f8", "<u4", "<i4", "<u2", "u1"])
        values = np.full(shape, np.nan if "f" in dtype else 200).astype(dtype)
        return encode(header, **{place: values})

    def kind(self) -> str:
        return self.random.choice(["do", "do", "do", "live", "grab"])

    def text(self, most: int = 30) -> str:
        letters = string.printable + "äß漢\u202e\x00\ud800"
        return "".join(self.random.choices(letters, k=self.random.randrange(most)))

    def anything(self, depth: int = 0) -> Any:
        """Anything that JSON can say, and NaN."""
        chance = self.random.random()
        if depth < 3 and chance < 0.1:
            return [self.anything(depth + 1) for _ in range(self.random.randrange(5))]
        if depth < 3 and chance < 0.2:
            return {self.text(8): self.anything(depth + 1) for _ in range(self.random.randrange(4))}
        return self.random.choice([
            None, True, False, 0, 1, -1, 1e308, 5e-324, 2**31, 2**53, 2**64, 10**30, -0.5, nan,
            "", "m1", "auto", self.text(), "x" * 10_000, [], {}, [0] * 100, ["a", 1, None],
            {"blob": "0" * 32}, {"vertices": [0, 1]}, {"file": "/etc/passwd"},
        ])  # fmt: skip

    def meant(self, schema: Any, known: dict[str, Any], depth: int = 0) -> Any:
        """Something of a form that a JSON schema allows."""
        if "$ref" in schema:
            return self.meant(known[schema["$ref"].rpartition("/")[2]], known, depth)
        for of in ("anyOf", "oneOf"):
            if of in schema:
                return self.meant(self.random.choice(schema[of]), known, depth)
        if "const" in schema or "enum" in schema:
            return self.random.choice(schema.get("enum") or [schema["const"]])
        match schema.get("type"):
            case "object":
                required = schema.get("required", [])
                return {
                    name: self.meant(one, known, depth + 1)
                    for name, one in schema.get("properties", {}).items()
                    if name in required or (depth < 4 and self.random.random() < 0.4)
                }
            case "array":
                if "prefixItems" in schema:
                    return [self.meant(one, known, depth + 1) for one in schema["prefixItems"]]
                count = schema.get("minItems", 0) + (self.random.randrange(4) if depth < 6 else 0)
                return [self.meant(schema.get("items", {}), known, depth + 1) for _ in range(count)]
            case "integer":
                return self.random.choice([0, 1, 2, 3, 7, 100, 10**6, 10**9, -1])
            case "number":
                return self.random.choice([0.0, 1.0, -2.5, 1e-12, 1e12, 1e300])
            case "string":
                names = ["m1", "m2", "handle 1", "fixed 1", "flat", "pin 1", "auto", "mesh", "a"]
                return self.random.choice([*names, self.text()])
            case "boolean":
                return self.random.random() < 0.5
            case "null":
                return None
        return self.anything()

    def spoiled(self, data: Any, chance: float) -> Any:
        """Plain data, by that chance with one thing in it lost, doubled or replaced."""
        if self.random.random() > chance:
            return data
        data = deepcopy(data)
        places = list(_places(data))
        if not places:
            return data
        inside, key = self.random.choice(places)
        match self.random.randrange(4):
            case 0:
                del inside[key]
            case 1 if isinstance(inside, list):
                inside.insert(key, inside[key])
            case 1:
                inside[self.text() or "more"] = inside[key]
            case _:
                inside[key] = self.anything()
        return data

    def ident(self) -> str:
        """Of a message, like no other's."""
        self._count += 1
        return f"damaged {self._count}"

    def packed(self, **header: Any) -> bytes:
        """As :func:`encode`, without its checks."""
        text = json.dumps({"id": self.ident(), **header}).encode()
        return len(text).to_bytes(4, "little") + text


def _places(data: Any) -> Iterator[tuple[Any, Any]]:
    """All things in plain data, each as what it is in and its key there."""
    if isinstance(data, dict | list):
        for key, value in list(data.items() if isinstance(data, dict) else enumerate(data)):
            yield data, key
            yield from _places(value)


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningStudio]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MALLOC_ARENA_MAX", "1")  # what threads hold in reserve is no growth
        with studio_running(tmp_path_factory.mktemp("studio")) as running:
            yield running


def is_clear(message: str) -> bool:
    """Whether it says something, and nothing of a failure of henkei's own."""
    return len(message.split()) >= 3 and not re.search(r"fault|inside henkei|Traceback", message)


def begin(page: Page, client: httpx.Client, folder: Path) -> str:
    """Open meshes so small that all is quick; the id of the session."""
    surfaces = random_disk(0, 60), cube_cage(), random_disk(1, 60)
    for number, surface in enumerate(surfaces, start=1):
        path = folder / f"{number}.obj"
        hk.write(path, surface)
        assert upload(client, path.name, path.read_bytes()) == {"mesh": f"m{number}"}
    for tab in TABS:
        page.do("document", "show", name=tab)
    return str(page.state["session"])


def work(page: Page) -> None:
    """What a person does, in all tabs."""
    for tab, slot, mesh in SLOTS:
        page.do(tab, "use", slot=slot, mesh=mesh)
    for tab, action, arguments in SOUND:
        page.do(tab, action, **arguments)


def come_back(page: Page, session: str) -> None:
    """To the session with its meshes, whatever was done to it."""
    if page.state["session"] != session:
        page.do("document", "restore", session=session)
    while len(page.state["meshes"]) < 3:
        assert page.ask("undo").kind == "done"


def attack(page: Page, messages: Sequence[bytes]) -> Counter[str]:
    """Send messages and hear an answer to each; how many were refused, and how many done."""
    waiting = Counter(map(answer_to, messages))
    for data in messages:
        page.send(data)
    page.say(kind="cancel", job="none", id="last")
    told: Counter[str] = Counter()
    while (message := page.hear()).header.get("id") != "last":
        if message.kind == "refused":
            assert is_clear(message.header["message"]), message.header["message"]
        if message.kind in ("refused", "done"):
            told[message.kind] += 1
            waiting[message.header["id"]] -= 1
    del waiting[NOTHING]
    assert not [ident for ident, count in waiting.items() if count > 0 or (ident and count)]
    return told


def answer_to(data: bytes) -> Any:
    """The id that the answer to a message has; None where it can have none."""
    try:
        header = decode(data).header
    except InvalidInput:
        return None
    kind, ident = header.get("kind"), header.get("id")
    if kind in ("ack", "live") or (kind in KINDS and ident is None):
        return NOTHING
    number = type(ident) is int and abs(ident) < 2**53
    usable = number or (isinstance(ident, str) and len(ident) <= 64)
    sound = kind in KINDS and (kind != "hello" or header.get("bits", 32) in (16, 32))
    return ident if usable and sound else None


def attack_all(page: Page, session: str, damage: Damage, count: int) -> Counter[str]:
    told: Counter[str] = Counter()
    for _ in range(count // TOGETHER):
        told += attack(page, list(damage.messages(TOGETHER)))
        come_back(page, session)
    return told


def resident_at_most(page: Page, studio: RunningStudio) -> float:
    """The same with as large a surface as any message makes."""
    page.do("document", "show", name="design")
    page.do("design", "load", recipe=DESIGNED)
    page.do("design", "set_levels", levels=LEVELS)
    found = resident(studio)
    page.do("design", "set_levels", levels=DESIGNED["levels"])
    return found


def resident(studio: RunningStudio) -> float:
    """Memory of the studio's process, in MB."""
    status = Path(f"/proc/{studio.process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s*(\d+) kB", status)[1]) / 1000


@linux
def test_messages_are_answered_and_leave_nothing_behind(
    studio: RunningStudio, tmp_path: Path
) -> None:
    damage = Damage(seed=0)
    with speaking(studio) as page, requesting(studio) as client:
        session = begin(page, client, tmp_path)
        work(page)
        attack_all(page, session, damage, WARM_UP)
        before = resident_at_most(page, studio)
        told = attack_all(page, session, damage, MESSAGES)
        after = resident_at_most(page, studio)
        assert told["refused"] > MESSAGES / 2
        assert told["done"] > MESSAGES / 100
        assert after < GROWTH * before
        work(page)
    with speaking(studio) as another:
        assert another.state["meshes"] == page.state["meshes"]
        assert another.tabs["deform"]["state"]["recipe"]["handles"]


@linux
def test_files_are_answered_and_leave_nothing_behind(studio: RunningStudio, tmp_path: Path) -> None:
    made = {name: data for name, data in lies().items() if name not in SLOW}
    originals = list(sound(tmp_path).items())
    for seed in range(FILES - len(made)):
        name, data = originals[seed % len(originals)]
        made[f"{seed}-{name}"] = mutated(data, seed)
    opened = 0
    with speaking(studio) as page, requesting(studio) as client:
        page.do("document", "new")
        for number, (name, data) in enumerate(made.items()):
            if number == FILES // 10:
                before = resident(studio)
            answer = upload(client, name, data)
            if "mesh" in answer:
                opened += 1
                page.do("document", "remove", mesh=answer["mesh"])
            else:
                assert answer["message"].startswith(name)
                assert is_clear(answer["message"]), answer
        assert not page.state["meshes"]
        assert 0 < opened < FILES - len(lies())
        assert resident(studio) < GROWTH * before
        page.do("document", "new")
        begin(page, client, tmp_path)
        work(page)
