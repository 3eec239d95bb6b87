"""Nastran bulk data (.bdf, .nas, .dat, .fem): the nodes, elements and sets of a file as a model."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from henkei.errors import InvalidFile
from henkei.io.cells import KINDS
from henkei.io.model import NO_LINKS, Block, Groups, Model, Rows, Source, build
from henkei.io.nastran_cards import Cards, Deck
from henkei.io.numbering import Numbering
from henkei.mesh import Floats

SHELLS = {
    "CTRIA3": "triangle", "CTRIAR": "triangle", "CTRIA6": "triangle6",
    "CQUAD4": "quad", "CQUADR": "quad", "CSHEAR": "quad", "CQUAD8": "quad8",
}  # fmt: skip
SOLIDS = {
    "CTETRA": ("tetra", "tetra10"), "CPYRAM": ("pyramid", "pyramid13"),
    "CPYRA": ("pyramid", "pyramid13"), "CPENTA": ("wedge", "wedge15"),
    "CHEXA": ("hexahedron", "hexahedron20"),
}  # fmt: skip
LINES = ("CBAR", "CBEAM", "CBEND", "CROD", "CTUBE")
JOINING = {  # elements that are not read: where their two nodes stand
    "CONROD": (1, 2), "CELAS1": (2, 4), "CELAS2": (2, 4), "CDAMP1": (2, 4), "CDAMP2": (2, 4),
    "CBUSH": (2, 3), "CBUSH1D": (2, 3), "CGAP": (2, 3), "CVISC": (2, 3), "CFAST": (6, 7),
    "RBAR": (1, 2), "RROD": (1, 2), "PLOTEL": (1, 2),
}  # fmt: skip
OTHERS = ("RBE1", "CQUAD", "CTRIAX", "CTRIAX6", "CWELD", "CSEAM", "CHACAB")
TO_VTK = {  # the upper edges of these come after the vertical ones
    "hexahedron20": [*range(12), *range(16, 20), *range(12, 16)],
    "wedge15": [*range(9), *range(12, 15), *range(9, 12)],
}


def read(path: Path, data: bytes) -> Model:
    """The model in a file of bulk data.

    Raises
    ------
    InvalidFile : damaged, or in a form whose nodes cannot be moved one by one; says the line.
    """
    return _Reader(path, data).model()


def nodes(path: Path, data: bytes) -> Floats:
    """Only the positions of the nodes."""
    return _Reader(path, data).nodes


class _Reader:
    """A deck, card type by card type."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path, self.data = path, data
        self.deck = Deck(path, data)
        grids = self.deck.cards("GRID")
        if not len(grids.first):
            raise InvalidFile(f"{path}: no GRID cards in this file")
        odd = self.deck.first[self.deck.odd & (self.deck.names == b"GRID")]
        if len(odd):
            raise self.deck.fault(
                "a GRID card that goes on in another format, or too far; write it again in one",
                int(odd[0]),
            )
        self.ids = self._integers(grids, 0, 1)[:, 0]
        self._check_numbers(self.ids, grids.first, "GRID")
        self._check_systems(grids)
        self.lines = np.stack([grids.first, grids.last], axis=1)
        places = _padded(grids, 2, 5).reshape(-1, 2)
        self.nodes = self.deck.lines.floats(places).reshape(-1, 3)
        self.numbering = Numbering(self.ids)

    def _integers(self, cards: Cards, first: int, last: int) -> Rows:
        """Fields ``first`` to ``last`` (not with it) of all cards; 0 for a blank one."""
        fields = _padded(cards, first, last)
        return self.deck.lines.integers(fields.reshape(-1, 2)).reshape(len(fields), last - first)

    def _check_numbers(self, ids: Rows, line: Rows, name: str) -> None:
        bad = np.flatnonzero(ids <= 0)
        if len(bad):
            raise self.deck.fault(f"{name} without a number", int(line[bad[0]]))
        if twice := Numbering(ids).twice():
            number, first, second = twice
            raise self.deck.fault(
                f"{name} {number} is already there, on line {line[first] + 1}", int(line[second])
            )

    def _check_systems(self, grids: Cards) -> None:
        system = self._integers(grids, 1, 2)[:, 0]
        default = self._integers(self.deck.cards("GRDSET"), 1, 2)[:, 0]
        blank = _padded(grids, 1, 2)[:, 0]
        if len(default):
            system = np.where(blank[:, 0] == blank[:, 1], default[0], system)
        bad = np.flatnonzero(system > 0)
        if len(bad):
            raise self.deck.fault(
                f"GRID {self.ids[bad[0]]} is given in coordinate system {system[bad[0]]}; write "
                f"its position in the basic system (CP 0); {len(bad)} of {len(system)} are like it",
                int(grids.first[bad[0]]),
            )

    def model(self) -> Model:
        """The model of the deck."""
        self._warn_of_end()
        blocks = self._blocks()
        ids = np.concatenate([NO_LINKS[:, 0], *(block.ids for block in blocks)])
        properties = np.concatenate([NO_LINKS[:, 0], *(block.properties for block in blocks)])
        links, unread = self._links()
        return build(
            Source(self.path, "nastran", self.data, self.lines),
            self.nodes,
            self.ids,
            blocks,
            self._groups(Numbering(ids), properties),
            links=links,
            unread=unread,
            node_values={"node": self.ids},
            element_values={"element": ids, "property": properties},
        )

    def _warn_of_end(self) -> None:
        capitals = self.data.upper()
        if b"BEGIN" in capitals and b"ENDDATA" not in capitals:
            warnings.warn(f"{self.path}: no ENDDATA; the file may be cut off", stacklevel=5)

    def _blocks(self) -> list[Block]:
        found: list[tuple[Rows, Block]] = []
        for name in [*SHELLS, *SOLIDS, *LINES]:
            cards = self.deck.cards(name)
            for kind, rows in self._kinds(name, cards):
                size = KINDS[kind].size
                chosen = Cards(name, cards.first[rows], cards.last[rows], cards.fields[rows])
                numbers = self._integers(chosen, 0, 2 + size)
                nodes = self._rows(kind, numbers, chosen)[:, TO_VTK.get(kind, slice(None))]
                block = Block(kind, name, nodes, numbers[:, 0], numbers[:, 1])
                found.append((chosen.first, block))
        found.sort(key=lambda pair: int(pair[0][0]))
        if found:
            ids = np.concatenate([block.ids for _, block in found])
            self._check_numbers(ids, np.concatenate([line for line, _ in found]), "element")
        return [block for _, block in found]

    def _kinds(self, name: str, cards: Cards) -> list[tuple[str, Rows]]:
        """The kinds of element that a card may be, and the cards that are of each."""
        every = np.arange(len(cards.first))
        if name in SOLIDS:
            first, second = SOLIDS[name]
            more = _padded(cards, 2 + KINDS[first].size, 2 + KINDS[second].size)
            is_second = (more[..., 0] < more[..., 1]).any(axis=1)
            kinds = [(first, every[~is_second]), (second, every[is_second])]
        else:
            kinds = [(SHELLS.get(name, "line"), every)]
        return [(kind, rows) for kind, rows in kinds if len(rows)]

    def _rows(self, kind: str, numbers: Rows, cards: Cards) -> Rows:
        """Nodes of elements as rows; only mid-side nodes may be left out."""
        nodes = numbers[:, 2:]
        rows = self.numbering.rows(nodes)
        missing = rows < 0
        missing[:, KINDS[kind].corners :] &= nodes[:, KINDS[kind].corners :] != 0
        if missing.any():
            element, corner = np.argwhere(missing)[0]
            node = nodes[element, corner]
            what = f"names node {node}, which is not there" if node else "lacks a node"
            raise self.deck.fault(
                f"{cards.name} {numbers[element, 0]} {what}", int(cards.first[element])
            )
        return rows

    def _links(self) -> tuple[Rows, dict[str, int]]:
        """Nodes that further elements join, and how many elements there are of each type."""
        unread, pairs = {}, [NO_LINKS]
        for name in (*JOINING, "RBE2", "RBE3", *OTHERS):
            cards = self.deck.cards(name)
            if not len(cards.first):
                continue
            unread[name] = len(cards.first)
            if name in JOINING:
                first, second = JOINING[name]
                ends = [self._integers(cards, i, i + 1) for i in (first, second)]
                pairs.append(np.concatenate(ends, axis=1))
            elif name in ("RBE2", "RBE3"):
                pairs += [self._spider(name, fields) for fields in cards.fields]
        rows = self.numbering.rows(np.concatenate(pairs))
        return rows[(rows >= 0).all(axis=1) & (rows[:, 0] != rows[:, 1])], unread

    def _spider(self, name: str, fields: Rows) -> Rows:
        """The node in the middle of a rigid element with each of the others."""
        words = [self.deck.lines.data[a:b].decode("latin-1").upper() for a, b in fields.tolist()]
        rigid = name == "RBE2"
        center = words[1] if rigid else words[2]
        legs = _numbers(words[3:]) if rigid else _weighted(words[4:])
        if not center.isdecimal() or len(center) > 18:
            return NO_LINKS
        return np.array([(int(center), leg) for leg in legs], dtype=np.int64).reshape(-1, 2)

    def _groups(self, elements: Numbering, properties: Rows) -> Groups:
        """SET1 (nodes) and SET3 (nodes, elements, or those of properties), named by number."""
        sets: dict[str, dict[str, Rows]] = {"nodes": {}, "elements": {}}
        for name in ("SET1", "SET3"):
            for fields in self.deck.cards(name).fields:
                words = [self.deck.lines.data[a:b].decode("latin-1") for a, b in fields.tolist()]
                what = "GRID" if name == "SET1" else words[1].upper()[:4]
                numbers = np.array(_numbers(words[1 if name == "SET1" else 2 :]), dtype=np.int64)
                if what == "PROP":
                    rows = np.flatnonzero(np.isin(properties, numbers))
                elif what in ("GRID", "ELEM"):
                    rows = (self.numbering if what == "GRID" else elements).rows(numbers)
                else:
                    continue
                part = sets["nodes" if what == "GRID" else "elements"]
                before = part.get(words[0], NO_LINKS[:, 0])
                part[words[0]] = np.unique(np.concatenate([before, rows[rows >= 0]]))
        return Groups(sets["nodes"], sets["elements"])


def _padded(cards: Cards, first: int, last: int) -> Rows:
    """Fields ``first`` to ``last`` (not with it) of all cards; blank where a card has fewer."""
    fields = cards.fields[:, first:last]
    return np.pad(fields, ((0, 0), (0, last - first - fields.shape[1]), (0, 0)))


def _numbers(words: list[str]) -> list[int]:
    """Whole numbers up to the first word that is none; ``1 THRU 5`` is 1, 2, 3, 4, 5."""
    found: list[int] = []
    through = False
    for word in words:
        if word.isdecimal() and len(word) < 19:
            number = int(word)
            if through and found and number - found[-1] < 2**31:
                found += range(found[-1] + 1, number)
            found.append(number)
            through = False
        elif word.upper() == "THRU":
            through = True
        elif word:
            break
    return found


def _weighted(words: list[str]) -> list[int]:
    """The nodes of an RBE3: after each weight (a real) and its components."""
    found: list[int] = []
    skip = False
    for word in filter(None, words):
        if "." in word:
            skip = True
        elif skip:
            skip = False
        elif word.isdecimal() and len(word) < 19:
            found.append(int(word))
        else:
            break
    return found
