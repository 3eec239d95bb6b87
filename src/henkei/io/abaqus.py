"""Abaqus input files (.inp): read as a model, and written back with only the coordinates changed.

Every part, instance and the assembly number their nodes and elements apart. Coordinates are those
of the part; several parts are therefore read only where no instance moves its part.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.abaqus_keywords import GENERATED, Keyword, keywords, kind_of
from henkei.io.abaqus_sets import EMPTY, Scope, Sets
from henkei.io.cells import KINDS
from henkei.io.fields import Change, Lines, columns, separated, shortest
from henkei.io.model import Block, Groups, Model, Rows, Source, build
from henkei.mesh import Floats

WIDTH = 20  # characters that Abaqus reads of a number
MIDDLE_LAST = [0, 2, 1]  # a beam of three nodes has its middle one second


def read(path: Path, data: bytes) -> Model:
    """The model in an Abaqus input file.

    Raises
    ------
    InvalidFile : damaged, or in a form whose nodes cannot be moved one by one; says the line.
    """
    return _Reader(path, data).model()


def nodes(path: Path, data: bytes) -> Floats:
    """Only the positions of the nodes."""
    return _Reader(path, data).positions()


@dataclass(eq=False)
class _Elements:
    """Elements as they stand in the file: numbers of nodes, and the line of each."""

    scope: Scope
    kind: str
    name: str
    ids: Rows
    nodes: Rows
    line: Rows


class _Reader:
    """A file, keyword by keyword."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path, self.lines = path, Lines(path, data)
        self.scope = Scope("")
        self.scopes = {"": self.scope}
        self.instances: dict[str, Scope] = {}
        self.placed: list[tuple[Keyword, Scope]] = []
        self.coordinates: list[Rows] = []
        self.node_lines: list[Rows] = []
        self.node_count = self.element_count = 0
        self.blocks: list[_Elements] = []
        self.links: list[tuple[Scope, Rows]] = []
        self.unread: dict[str, int] = {}
        self.sets: list[tuple[Scope, Keyword, Rows | None]] = []
        self.sections: list[tuple[Scope, str]] = []
        self.in_assembly = self.normals = False
        for keyword in keywords(self.lines):
            self._take(keyword)

    def _fault(self, keyword: Keyword, message: str) -> InvalidFile:
        return InvalidFile(f"{self.path}, line {keyword.line + 1}: {message}")

    def _take(self, keyword: Keyword) -> None:
        name = keyword.name
        listing = name in ("NODE", "ELEMENT", "NSET", "ELSET")
        if name == "INCLUDE" or (listing and "INPUT" in keyword.parameters):
            other = keyword.parameters.get("INPUT", "another file")
            raise self._fault(
                keyword,
                f"the model goes on in {other!r}; give henkei the file that has nodes and "
                "elements, or put all in one file",
            )
        match name:
            case "SYSTEM" if len(keyword.data):
                raise self._fault(
                    keyword, "*SYSTEM moves the nodes below it; write global coordinates"
                )
            case "PART" | "ASSEMBLY" | "INSTANCE":
                self._enter(keyword)
            case "ENDPART" | "ENDINSTANCE" | "ENDASSEMBLY":
                self.in_assembly = name == "ENDINSTANCE" and self.in_assembly
                self.scope = self._scope("ASSEMBLY" if self.in_assembly else "")
            case "NODE":
                self._nodes(keyword)
            case "ELEMENT":
                self._elements(keyword)
            case "NSET" | "ELSET":
                self.sets.append((self.scope, keyword, None))
            case _ if name in GENERATED:
                raise self._fault(
                    keyword,
                    f"*{name} makes {GENERATED[name]} that the file does not list; write the model "
                    "with all of them listed, as a pre-processor does",
                )
            case _ if name.endswith("SECTION") and "ELSET" in keyword.parameters:
                self.sections.append((self.scope, keyword.label("ELSET")))

    def _scope(self, name: str) -> Scope:
        return self.scopes.setdefault(name, Scope(name))

    def _enter(self, keyword: Keyword) -> None:
        """A part, the assembly or an instance begins."""
        name = keyword.label("NAME")
        if keyword.name == "ASSEMBLY":
            self.in_assembly = True
            self.scope = self._scope("ASSEMBLY")
        elif keyword.name == "PART":
            if f"PART {name}" in self.scopes:
                raise self._fault(keyword, f"there is already a part {name!r}")
            self.scope = self._scope(f"PART {name}")
        else:
            part = keyword.label("PART")
            if part and f"PART {part}" not in self.scopes:
                raise self._fault(keyword, f"there is no part {part!r} above")
            self.scope = self._scope(f"PART {part}" if part else f"INSTANCE {name}")
            self.instances[name] = self.scope
            self.placed.append((keyword, self.scope))

    def _nodes(self, keyword: Keyword) -> None:
        system = keyword.parameters.get("SYSTEM", "R").upper()
        if system != "R":
            raise self._fault(
                keyword, f"nodes in SYSTEM={system} are not read; write Cartesian coordinates"
            )
        fields, offsets = separated(self.lines, keyword.data)
        rows = np.stack([self.lines.start[keyword.data], self.lines.end[keyword.data]], axis=1)
        table = columns(fields, offsets, 4, self.lines.trimmed(rows)[:, 1])
        blank = np.flatnonzero(table[:, 0, 0] == table[:, 0, 1])
        if len(blank):
            raise self.lines.fault("a node without a number", int(table[blank[0], 0, 0]))
        self.normals |= bool(np.any(np.diff(offsets) > 4))
        ids = self.lines.integers(table[:, 0])
        self.scope.add("NSET", ids, self.node_count + np.arange(len(ids)))
        self.coordinates.append(table)
        self.node_lines.append(keyword.data)
        self.node_count += len(ids)
        if "NSET" in keyword.parameters:
            self.sets.append((self.scope, keyword, ids))

    def _elements(self, keyword: Keyword) -> None:
        name = keyword.parameters.get("TYPE", "").upper()
        if not name:
            raise self._fault(keyword, "*ELEMENT needs TYPE=")
        kind = kind_of(name)
        fields, offsets = separated(self.lines, keyword.data)
        leading = np.zeros(len(fields) + 1, dtype=bool)
        leading[offsets[:-1]] = True
        filled = fields[:, 0] < fields[:, 1]
        fields, leading = fields[filled], leading[:-1][filled]
        if not kind:
            self._others(keyword, name, fields, leading)
            return
        numbers = self._records(name, fields, leading, KINDS[kind].size + 1)
        ids, nodes = numbers[:, 0].copy(), numbers[:, 1:]
        place = np.searchsorted(self.lines.start, fields[:: numbers.shape[1], 0], side="right") - 1
        nodes = nodes[:, MIDDLE_LAST] if kind == "line3" else nodes
        self.blocks.append(_Elements(self.scope, kind, name, ids, nodes, place))
        self.scope.add("ELSET", ids, self.element_count + np.arange(len(ids)))
        self.element_count += len(ids)
        if "ELSET" in keyword.parameters:
            self.sets.append((self.scope, keyword, ids))

    def _records(self, name: str, fields: Rows, leading: NDArray[np.bool_], width: int) -> Rows:
        """Rows of ``width`` whole numbers, each of which begins a line."""
        bad = np.flatnonzero(~leading[::width])
        short = len(fields) % width
        if len(bad) or short:
            record = int(bad[0]) - 1 if len(bad) else len(fields) // width
            raise self.lines.fault(
                f"an element of type {name} has a number and {width - 1} nodes, "
                "not what stands here",
                int(fields[max(record, 0) * width, 0]),
            )
        return self.lines.integers(fields).reshape(-1, width)

    def _others(
        self, keyword: Keyword, name: str, fields: Rows, leading: NDArray[np.bool_]
    ) -> None:
        """Elements of a type that is not read: only which nodes they join is kept."""
        rows = np.stack([self.lines.start[keyword.data], self.lines.end[keyword.data]], axis=1)
        last = self.lines.buffer[self.lines.trimmed(rows)[:, 1] - 1]
        begins = np.append(True, last[:-1] != ord(","))[: len(last)]
        self.unread[name] = self.unread.get(name, 0) + int(begins.sum())
        words = [self.lines.data[a:b] for a, b in fields.tolist()]
        if not all(word.isdigit() and len(word) < 19 for word in words):
            return  # nodes of several instances, as PART-1-1.7
        numbers = np.array(words, dtype=np.int64)
        line = np.cumsum(leading) - 1
        record = np.cumsum(begins)[line] if len(line) else line
        inner = np.flatnonzero((record[2:] == record[1:-1]) & (record[1:-1] == record[:-2])) + 1
        self.links.append((self.scope, np.stack([numbers[inner], numbers[inner + 1]], axis=1)))

    def positions(self) -> Floats:
        """(N, 3) of all nodes, in the order of the file."""
        if not self.node_count:
            raise InvalidFile(f"{self.path}: no *NODE with nodes in this file")
        places = np.concatenate(self.coordinates)
        return self.lines.floats(places[:, 1:].reshape(-1, 2)).reshape(-1, 3)

    def model(self) -> Model:
        """The model, when all keywords are taken."""
        positions = self.positions()
        self._number()
        self._check_instances()
        nodes_of = [self._rows(block) for block in self.blocks]
        sets = Sets(self.lines, self.instances, [row for table in nodes_of for row in table])
        for scope, keyword, ids in self.sets:
            kind = "NSET" if keyword.name in ("NODE", "NSET") else "ELSET"
            if ids is None:
                sets.take(keyword, scope)
            else:
                sets.put(kind, scope, keyword.parameters[kind], scope.rows(kind, ids))
        properties = np.zeros(self.element_count, dtype=np.int64)
        for number, (scope, name) in enumerate(self.sections, start=1):
            properties[sets.rows("ELSET", scope, name)] = number
        ends = np.cumsum([0] + [len(table) for table in nodes_of])
        blocks = [
            Block(block.kind, block.name, table, block.ids, properties[first : first + len(table)])
            for block, table, first in zip(self.blocks, nodes_of, ends[:-1], strict=True)
        ]
        self._warn()
        node_ids = self._node_ids()
        element_ids = np.concatenate([EMPTY, *(block.ids for block in blocks)])
        return build(
            Source(self.path, "abaqus", self.lines.data, np.concatenate(self.coordinates)),
            positions,
            node_ids,
            blocks,
            Groups(sets.groups("NSET"), sets.groups("ELSET")),
            links=self._links(),
            unread=self.unread,
            node_values={"node": node_ids},
            element_values={"element": element_ids, "property": properties},
        )

    def _number(self) -> None:
        """Number the nodes and elements of each scope; refuse a number given twice."""
        node_lines = np.concatenate(self.node_lines)
        element_lines = np.concatenate([EMPTY, *(block.line for block in self.blocks)])
        for scope in self.scopes.values():
            scope.number()
            for what, numbering, lines in (
                ("node", scope.nodes, node_lines),
                ("element", scope.elements, element_lines),
            ):
                if twice := numbering.twice():
                    number, first, second = twice
                    raise InvalidFile(
                        f"{self.path}, line {lines[second] + 1}: {what} {number} is already "
                        f"there, on line {lines[first] + 1}"
                    )

    def _node_ids(self) -> Rows:
        ids = np.empty(self.node_count, dtype=np.int64)
        for scope in self.scopes.values():
            for numbers, rows in zip(scope.node_ids, scope.node_rows, strict=True):
                ids[rows] = numbers
        return ids

    def _rows(self, block: _Elements) -> Rows:
        """Nodes of elements as rows; refuses a node that is not there."""
        rows = block.scope.nodes.rows(block.nodes)
        missing = np.argwhere(rows < 0)
        if len(missing):
            element, corner = missing[0]
            raise InvalidFile(
                f"{self.path}, line {block.line[element] + 1}: element {block.ids[element]} names "
                f"node {block.nodes[element, corner]}, which is not there"
            )
        return rows

    def _links(self) -> Rows:
        pairs = [scope.nodes.rows(numbers) for scope, numbers in self.links]
        found = np.concatenate([np.empty((0, 2), dtype=np.int64), *pairs])
        return found[(found >= 0).all(axis=1)]

    def _check_instances(self) -> None:
        """Refuse parts that instances put in places of their own, where there are several."""
        parts = [s for name, s in self.scopes.items() if s.element_ids and name != "ASSEMBLY"]
        seen: set[str] = set()
        for keyword, scope in self.placed:
            moved = len(keyword.data) > 0
            if len(parts) > 1 and (moved or scope.name in seen):
                raise self._fault(
                    keyword,
                    f"instance {keyword.label('NAME')!r} puts its part in another place; with "
                    "several parts, write the model in global coordinates (without parts and "
                    "assemblies), or one part a file",
                )
            if moved:
                warnings.warn(
                    f"{self.path}: positions are those of the part, before instance "
                    f"{keyword.label('NAME')!r} places it",
                    stacklevel=4,
                )
            seen.add(scope.name)

    def _warn(self) -> None:
        if self.normals:
            warnings.warn(
                f"{self.path}: normals given with nodes stay as they are when nodes move",
                stacklevel=4,
            )


def changes(source: Source, before: Floats, after: Floats) -> list[Change]:
    """What to replace in the file where coordinates changed; every other byte is as it was.

    A number has at most 20 characters, which is what Abaqus reads. Float64 survives that exactly
    from 0.01 on and to 5e-19 below.
    """
    assert source.places is not None
    content: bytes = source.content
    at = source.places
    differ = before != after
    letters = np.frombuffer(content + b"\n", dtype=np.uint8)
    absent = (at[:, 1:, 0] == at[:, 1:, 1]) & (letters[at[:, 1:, 0]] != ord(","))
    short = absent.any(axis=1) & differ.any(axis=1)
    single = np.argwhere(differ & ~short[:, None])
    values = after[single[:, 0], single[:, 1]].tolist()
    places = at[single[:, 0], single[:, 1] + 1].tolist()
    found = [
        (start, end, shortest(value, WIDTH).encode("ascii"))
        for (start, end), value in zip(places, values, strict=True)
    ]
    for node in np.flatnonzero(short).tolist():
        kept = [content[slice(*at[node, axis + 1])] for axis in range(3)]
        texts = [
            old if old and not differ[node, axis] else shortest(value, WIDTH).encode("ascii")
            for axis, (old, value) in enumerate(zip(kept, after[node].tolist(), strict=True))
        ]
        found.append((int(at[node, 0, 1]), int(at[node, 3, 1]), b", " + b", ".join(texts)))
    return sorted(found)
