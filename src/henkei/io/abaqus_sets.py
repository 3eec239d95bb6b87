"""Sets of an Abaqus file: what they are called, and which nodes or elements they have."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from henkei.errors import InvalidFile
from henkei.io.abaqus_keywords import Keyword, label
from henkei.io.fields import Lines, separated
from henkei.io.numbering import Numbering, Rows

EMPTY: Rows = np.empty(0, dtype=np.int64)


@dataclass(eq=False)
class Scope:
    """Nodes and elements that are numbered together: those of a part, an instance, the assembly."""

    name: str
    node_ids: list[Rows] = field(default_factory=list)
    node_rows: list[Rows] = field(default_factory=list)
    element_ids: list[Rows] = field(default_factory=list)
    element_rows: list[Rows] = field(default_factory=list)

    def number(self) -> None:
        """To be called when all nodes and elements are there."""
        self.nodes = Numbering(
            np.concatenate([EMPTY, *self.node_ids]), np.concatenate([EMPTY, *self.node_rows])
        )
        self.elements = Numbering(
            np.concatenate([EMPTY, *self.element_ids]),
            np.concatenate([EMPTY, *self.element_rows]),
        )

    def add(self, kind: str, ids: Rows, rows: Rows) -> None:
        """Nodes (``NSET``) or elements (``ELSET``) that the file lists."""
        (self.node_ids if kind == "NSET" else self.element_ids).append(ids)
        (self.node_rows if kind == "NSET" else self.element_rows).append(rows)

    def rows(self, kind: str, ids: Rows) -> Rows:
        """Rows of nodes (``NSET``) or elements (``ELSET``); those that are not there left out."""
        found = (self.nodes if kind == "NSET" else self.elements).rows(ids)
        return found[found >= 0]


class Sets:
    """The sets of a file.

    A set that is named in several scopes has each scope's name before its own: ``PART-1.HOOD``.
    """

    def __init__(self, lines: Lines, instances: dict[str, Scope], corners: list[Rows]) -> None:
        self.lines, self.instances, self.corners = lines, instances, corners
        self.members: dict[tuple[str, str, str], list[Rows]] = {}
        self.spelled: dict[str, str] = {}

    def put(self, kind: str, scope: Scope, name: str, rows: Rows) -> None:
        """Rows that belong to a set; several calls add up."""
        self.spelled.setdefault(label(name), name.strip().strip('"'))
        self.members.setdefault((kind, scope.name, label(name)), []).append(rows)

    def take(self, keyword: Keyword, scope: Scope) -> None:
        """What ``*NSET`` or ``*ELSET`` says."""
        kind = keyword.name
        name = keyword.parameters.get(kind, "")
        if not name:
            raise self._fault(keyword, f"*{kind} needs {kind}=")
        within = scope
        if "INSTANCE" in keyword.parameters:
            within = self._instance(keyword, keyword.label("INSTANCE"))
        if kind == "NSET" and "ELSET" in keyword.parameters:
            elements = self.rows("ELSET", within, keyword.label("ELSET"))
            tables = [self.corners[i] for i in elements.tolist()]
            self.put(kind, scope, name, np.unique(np.concatenate([EMPTY, *tables])))
            return
        fields = separated(self.lines, keyword.data)[0]
        fields = fields[fields[:, 0] < fields[:, 1]]
        if "GENERATE" in keyword.parameters:
            self.put(kind, scope, name, within.rows(kind, self._generated(keyword)))
            return
        numeric = np.isin(self.lines.buffer[fields[:, 0]], list(b"0123456789"))
        words = [self.lines.data[a:b].decode("latin-1") for a, b in fields[~numeric].tolist()]
        plain = self.lines.integers(fields[numeric])
        rows = [within.rows(kind, plain), *(self._named(keyword, within, word) for word in words)]
        self.put(kind, scope, name, np.concatenate([EMPTY, *rows]))

    def rows(self, kind: str, scope: Scope, name: str) -> Rows:
        """The members of a set so far; none if there is no such set."""
        return np.concatenate([EMPTY, *self.members.get((kind, scope.name, name), [])])

    def groups(self, kind: str) -> dict[str, Rows]:
        """All sets of nodes (``NSET``) or elements (``ELSET``), each member once."""
        keys = [key for key in self.members if key[0] == kind]
        found = {}
        for key in keys:
            rows = np.unique(np.concatenate(self.members[key]))
            alone = sum(other[2] == key[2] for other in keys) == 1
            place = key[1].rpartition(" ")[2] or "MODEL"
            name = self.spelled[key[2]]
            found[name if alone else f"{place}.{name}"] = rows
        return found

    def _generated(self, keyword: Keyword) -> Rows:
        fields, offsets = separated(self.lines, keyword.data)
        parts = [EMPTY]
        for line, first, last in zip(keyword.data, offsets[:-1], offsets[1:], strict=True):
            values = self.lines.integers(fields[first:last]).tolist()
            start, stop, step = (*values, 1)[:3] if len(values) == 2 else (*values, 0, 0, 0)[:3]
            if len(values) not in (2, 3) or step < 1 or stop < start or stop - start > 2**31:
                raise self.lines.fault(
                    "GENERATE needs first, last and step, rising", int(self.lines.start[line])
                )
            parts.append(np.arange(start, stop + 1, step, dtype=np.int64))
        return np.concatenate(parts)

    def _named(self, keyword: Keyword, scope: Scope, word: str) -> Rows:
        """Another set, or ``instance.number``, or ``instance.set``."""
        kind = keyword.name
        name = label(word)
        if (kind, scope.name, name) in self.members:
            return self.rows(kind, scope, name)
        instance, dot, rest = name.rpartition(".")
        if dot and instance in self.instances:
            inside = self.instances[instance]
            if rest.isdecimal():
                return inside.rows(kind, np.array([int(rest)], dtype=np.int64))
            if (kind, inside.name, rest) in self.members:
                return self.rows(kind, inside, rest)
        raise self._fault(keyword, f"there is no set {word!r} above")

    def _instance(self, keyword: Keyword, name: str) -> Scope:
        if name not in self.instances:
            raise self._fault(keyword, f"there is no instance {name!r} above")
        return self.instances[name]

    def _fault(self, keyword: Keyword, message: str) -> InvalidFile:
        return InvalidFile(f"{self.lines.path}, line {keyword.line + 1}: {message}")
