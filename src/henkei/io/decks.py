"""New Abaqus and Nastran files of a model that was read from another format, or of a surface."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput, some
from henkei.io.assemble import warn_of_dropped
from henkei.io.fields import shortest
from henkei.io.model import SET, Block, Groups, Model, Rows, Source, build
from henkei.io.nastran import TO_VTK
from henkei.io.numbering import Numbering
from henkei.mesh import Floats, Surface

ABAQUS = {
    "line": "T3D2", "line3": "T3D3", "triangle": "S3", "quad": "S4", "triangle6": "STRI65",
    "quad8": "S8R", "quad9": "S9R5", "tetra": "C3D4", "tetra10": "C3D10", "pyramid": "C3D5",
    "wedge": "C3D6", "wedge15": "C3D15", "hexahedron": "C3D8", "hexahedron20": "C3D20",
}  # fmt: skip
NASTRAN = {
    "line": "CROD", "triangle": "CTRIA3", "quad": "CQUAD4", "triangle6": "CTRIA6",
    "quad8": "CQUAD8", "tetra": "CTETRA", "tetra10": "CTETRA", "pyramid": "CPYRAM",
    "pyramid13": "CPYRAM", "wedge": "CPENTA", "wedge15": "CPENTA", "hexahedron": "CHEXA",
    "hexahedron20": "CHEXA",
}  # fmt: skip
A_LINE = 8  # numbers of a set or an element on a line


def encode(path: Path, model: Model, nodes: Floats) -> Iterator[bytes]:
    """A model as .inp or .bdf with the numbers that it has.

    Nodes or elements that several parts number alike are numbered anew. Abaqus gets the sets, and
    an element set ``PROPERTY_n`` for each property; Nastran the properties. Materials, loads and
    what else a deck has are not there.

    Raises
    ------
    InvalidInput : an element that the format does not have.
    """
    abaqus = path.suffix.lower() == ".inp"
    names = ABAQUS if abaqus else NASTRAN
    blocks = [_simple(block) for block in model.blocks if len(block.ids)]
    unknown = sorted({block.name for block in blocks if block.kind not in names})
    if unknown:
        raise InvalidInput(f"cannot write {path}: it does not hold elements {some(unknown)}")
    if model.unread:
        listed = some(sorted(model.unread))
        warnings.warn(f"elements of type {listed} are not written to {path}", stacklevel=5)
    node_ids = _unique(model.node_ids)
    ids = _unique(np.concatenate([block.ids for block in blocks]))
    text = _abaqus if abaqus else _nastran
    for part in text(path, model, nodes, blocks, node_ids, ids):
        yield part.encode("ascii", "backslashreplace")


def of_surface(path: Path, surface: Surface) -> Model:
    """A model with a surface's faces as shells.

    Its face attributes ``element``, ``property`` and ``set NAME`` and its vertex attributes
    ``node`` and ``set NAME`` become numbers, properties and sets; a warning names the others.
    """
    given = surface.attributes
    face = {n for n in given.face if n in ("element", "property") or n.startswith(SET)}
    vertex = {n for n in given.vertex if n == "node" or n.startswith(SET)}
    warn_of_dropped(path.suffix, given, vertex=vertex, face=face)
    count = surface.face_count
    ids = _integers(given.face.get("element"), np.arange(1, count + 1))
    properties = _integers(given.face.get("property"), np.zeros(count, dtype=np.int64))
    sizes = np.diff(surface.offsets)
    blocks = []
    for run in np.split(np.arange(count), np.flatnonzero(np.diff(sizes)) + 1):
        corners = surface.indices[surface.offsets[run][:, None] + np.arange(sizes[run[0]])]
        table = corners.astype(np.int64)
        blocks.append(Block("polygon", "polygon", table, ids[run], properties[run]))
    return build(
        Source(path, "surface", None),
        surface.vertices.copy(),
        _integers(given.vertex.get("node"), np.arange(1, len(surface.vertices) + 1)),
        blocks,
        Groups(_sets(given.vertex), _sets(given.face)),
    )


def _integers(values: NDArray[Any] | None, otherwise: Rows) -> Rows:
    plain = values is not None and values.dtype.kind in "iu" and values.ndim == 1
    return values.astype(np.int64) if values is not None and plain else otherwise


def _sets(values: Mapping[str, NDArray[Any]]) -> dict[str, Rows]:
    masks = {n: v for n, v in values.items() if n.startswith(SET) and v.ndim == 1}
    return {name.removeprefix(SET): np.flatnonzero(mask) for name, mask in masks.items()}


def _simple(block: Block) -> Block:
    """Polygons of three or four corners as triangles or quads."""
    kind = {3: "triangle", 4: "quad"}.get(block.nodes.shape[1], "polygon")
    kind = kind if block.kind == "polygon" else block.kind
    return Block(kind, block.name, block.nodes, block.ids, block.properties)


def _unique(ids: Rows) -> Rows:
    plain = len(ids) == 0 or (ids.min() > 0 and Numbering(ids).twice() is None)
    return ids if plain else np.arange(1, len(ids) + 1)


def _listed(numbers: NDArray[Any]) -> str:
    words = [str(number) for number in numbers.tolist()]
    rows = [", ".join(words[i : i + A_LINE]) for i in range(0, len(words), A_LINE)]
    return ",\n".join(rows)


def _abaqus(
    path: Path, model: Model, nodes: Floats, blocks: list[Block], node_ids: Rows, ids: Rows
) -> Iterator[str]:
    yield "*HEADING\nhenkei\n*NODE\n"
    for number, (x, y, z) in zip(node_ids.tolist(), nodes.tolist(), strict=True):
        yield f"{number}, {shortest(x, 20)}, {shortest(y, 20)}, {shortest(z, 20)}\n"
    first = 0
    for block in blocks:
        if (block.nodes < 0).any():
            raise InvalidInput(f"cannot write {path}: {block.name} without its mid-side nodes")
        yield f"*ELEMENT, TYPE={ABAQUS[block.kind]}\n"
        order = [0, 2, 1] if block.kind == "line3" else slice(None)
        for number, row in zip(
            ids[first : first + len(block.ids)], node_ids[block.nodes][:, order], strict=True
        ):
            yield _listed(np.append(number, row)) + "\n"
        first += len(block.ids)
    properties = np.concatenate([block.properties for block in blocks])
    sets = {f"PROPERTY_{p}": np.flatnonzero(properties == p) for p in np.unique(properties) if p}
    for name, rows in {**model.groups.elements, **sets}.items():
        if len(rows):
            yield f'*ELSET, ELSET="{name}"\n{_listed(ids[rows])}\n'
    for name, rows in model.groups.nodes.items():
        if len(rows):
            yield f'*NSET, NSET="{name}"\n{_listed(node_ids[rows])}\n'


def _nastran(
    path: Path, model: Model, nodes: Floats, blocks: list[Block], node_ids: Rows, ids: Rows
) -> Iterator[str]:
    if model.groups.nodes or model.groups.elements:
        warnings.warn(f"{path} holds properties, but not the model's sets", stacklevel=6)
    if max(node_ids.max(), ids.max()) > 99_999_999:
        raise InvalidInput(f"cannot write {path}: Nastran's numbers end at 99999999")
    yield "$ henkei\nBEGIN BULK\n"
    for number, values in zip(node_ids.tolist(), nodes.tolist(), strict=True):
        x, y, z = (shortest(value, 16).rjust(16) for value in values)
        yield f"GRID*   {number:>16}{'':16}{x}{y}\n*       {z}\n"
    first = 0
    for block in blocks:
        name, own = NASTRAN[block.kind], slice(first, first + len(block.ids))
        order = np.argsort(TO_VTK[block.kind]) if block.kind in TO_VTK else slice(None)
        numbers = np.where(block.nodes >= 0, node_ids[block.nodes], 0)[:, order]
        for number, kept, row in zip(ids[own], block.properties, numbers, strict=True):
            words = [number, max(int(kept), 1), *row.tolist()]
            fields = [f"{word:>8}" if word else " " * 8 for word in words]
            lines = ["".join(fields[i : i + 8]) for i in range(0, len(fields), 8)]
            yield name.ljust(8) + "\n        ".join(lines) + "\n"
        first += len(block.ids)
    yield "ENDDATA\n"
