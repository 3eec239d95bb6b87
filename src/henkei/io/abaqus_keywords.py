"""Abaqus input as keywords, each with its parameters and its lines of data."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from henkei.io.fields import Lines
from henkei.io.text import Positions

STAR = ord("*")
SHELL = re.compile(
    r"(?:S|DS|STRI|M3D|R3D|SFM3D|CPS|CPEG?|CG?AX|DC2D|DCAX|AC2D|ACAX)(3|4|6|8|9)[A-Z]*\d?"
)
SOLID = re.compile(r"(?:D|DC|A|E|Q|EM)?C3D(4|5|6|8|10|15|20)(?!V)[A-Z]*|SC([68])[A-Z]*|CSS(8)")
LINE = re.compile(r"(?:T2D|T3D|B2|B3|PIPE2|PIPE3)(1|2|3)[A-Z]*")
SHELLS = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
SOLIDS = {
    4: "tetra", 5: "pyramid", 6: "wedge", 8: "hexahedron",
    10: "tetra10", 15: "wedge15", 20: "hexahedron20",
}  # fmt: skip
GENERATED = {
    "NGEN": "nodes", "NFILL": "nodes", "NCOPY": "nodes", "NMAP": "nodes",
    "ELGEN": "elements", "ELCOPY": "elements",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Keyword:
    """A keyword in capitals without blanks, its parameters, and where it stands.

    parameters : name in capitals -> value as it is, "" where there is none.
    line : its first line, counted from 0.
    data : the lines of data under it, without blank ones and comments.
    """

    name: str
    parameters: dict[str, str]
    line: int
    data: Positions

    def label(self, parameter: str) -> str:
        """The value of a parameter as a label: in capitals unless it is quoted."""
        return label(self.parameters.get(parameter, ""))


def label(text: str) -> str:
    """A label as Abaqus compares it: in capitals, or as it is between quotes."""
    text = text.strip()
    quoted = len(text) > 1 and text[0] == text[-1] == '"'
    return text[1:-1] if quoted else text.upper()


def keywords(lines: Lines) -> Iterator[Keyword]:
    """All keywords of a file; comments (``**``) are passed over."""
    content = lines.trimmed(np.stack([lines.start, lines.end], axis=1))
    filled = content[:, 0] < content[:, 1]
    letter = lines.buffer[np.where(filled, content[:, 0], 0)]
    second = lines.buffer[np.minimum(content[:, 0] + 1, len(lines.buffer) - 1)]
    starred = filled & (letter == STAR)
    comment = starred & (second == STAR) & (content[:, 1] > content[:, 0] + 1)
    begins = starred & ~comment
    data = filled & ~starred
    starts = np.append(np.flatnonzero(begins), len(lines))
    for line, following in zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True):
        text, last = lines.text(line).strip(), line
        while text.endswith(",") and last + 1 < following:
            last += 1
            if not comment[last]:
                text += lines.text(last).strip()
        rows = last + 1 + np.flatnonzero(data[last + 1 : following])
        yield _keyword(text, line, rows)


def _keyword(text: str, line: int, data: NDArray[np.int64]) -> Keyword:
    name, *rest = text[1:].split(",")
    parameters = {}
    for item in rest:
        key, _, value = item.partition("=")
        if key.strip():
            parameters[re.sub(r"\s", "", key).upper()] = value.strip()
    return Keyword(re.sub(r"\s", "", name).upper(), parameters, line, data)


def kind_of(name: str) -> str:
    """The kind of element that a type of Abaqus is; "" if it is none that is read."""
    if name in ("STRI3", "STRI65"):
        return "triangle" if name == "STRI3" else "triangle6"
    if found := SHELL.fullmatch(name):
        return SHELLS[int(found[1])]
    if found := SOLID.fullmatch(name):
        return SOLIDS[int(next(group for group in found.groups() if group))]
    if found := LINE.fullmatch(name):
        nodes = int(found[1]) if name.startswith("T") else {"1": 2, "2": 3, "3": 2}[found[1]]
        return {2: "line", 3: "line3"}.get(nodes, "")
    return ""
