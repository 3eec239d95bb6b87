"""A model of a simulation code as data: its nodes, its elements, and the surface to deform."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile, some
from henkei.io.assemble import assemble
from henkei.io.cells import KINDS
from henkei.io.skin import faces_of
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh

Rows = NDArray[np.int64]
Arrays = Mapping[str, NDArray[Any]]
SET = "set "  # before the name of a set, as an attribute
NO_LINKS: Rows = np.empty((0, 2), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Block:
    """Elements of one kind that follow each other in a file.

    kind : as in :data:`henkei.io.cells.KINDS`, or ``polygon``.
    name : the type as the file calls it: S4R, CTETRA, tetra10.
    nodes : (k, nodes of an element) rows of ``Model.nodes``; -1 for a mid-side node left out.
    ids : (k,) the numbers that the file gives them.
    properties : (k,) property of each, 0 for none; see :func:`henkei.io.cae.read_model`.
    """

    kind: str
    name: str
    nodes: Rows
    ids: Rows
    properties: Rows

    @property
    def dimension(self) -> int:
        """1 for lines, 2 for shells, 3 for solids."""
        return 2 if self.kind == "polygon" else KINDS[self.kind].dimension

    @property
    def corners(self) -> Rows:
        """(k, corners of an element) rows of ``Model.nodes``."""
        return self.nodes if self.kind == "polygon" else self.nodes[:, : KINDS[self.kind].corners]


@dataclass(frozen=True, eq=False)
class Groups:
    """Sets by the names that the file gives them.

    nodes : name -> rows of ``Model.nodes``.
    elements : name -> numbers of elements, counted over all blocks of ``Model.blocks``.
    """

    nodes: Mapping[str, Rows] = field(default_factory=dict)
    elements: Mapping[str, Rows] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("nodes", "elements"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))


@dataclass(frozen=True, eq=False)
class Source:
    """The file of a model and where its coordinates stand.

    path : the file.
    format : ``abaqus``, ``nastran``, ``gmsh`` (its text files) or ``meshio``.
    content : the bytes of a text file; meshio's mesh and the first bytes of another.
    places : where the text has each node: for Gmsh the bytes ``(N, 3, 2)`` from and to of its
        coordinates, for Abaqus ``(N, 4, 2)`` with its number first, for
        Nastran the first and last line ``(N, 2)`` of its card.
    """

    path: Path
    format: str
    content: Any
    places: Rows | None = None


@dataclass(frozen=True, eq=False)
class Model:
    """What a file of a simulation code holds, as far as moving its nodes needs it.

    surface : the shell elements as they are, and the skin of the solid elements; only corners of
        elements are vertices. Attributes are described at :func:`henkei.io.cae.read_model`.
    surface_nodes : (n,) row of ``nodes`` for each vertex of the surface.
    surface_elements : (m,) number of the element of each face, counted over all blocks.
    nodes : (N, 3) positions of all nodes, mid-side and interior ones too.
    node_ids : (N,) the numbers that the file gives them.
    blocks : the elements: lines, shells and solids.
    links : (k, 2) rows of nodes that beams, springs, rigid and unknown elements join.
    groups : node sets and element sets.
    unread : element types that stay untouched in the file, and how many of each.
    source : what is needed to write the file back.
    """

    surface: Mesh | PolygonMesh
    surface_nodes: Rows
    surface_elements: Rows
    nodes: Floats
    node_ids: Rows
    blocks: tuple[Block, ...]
    links: Rows
    groups: Groups
    unread: Mapping[str, int]
    source: Source

    def __repr__(self) -> str:
        elements = sum(len(block.ids) for block in self.blocks)
        return (
            f"Model({self.source.path.name}: {len(self.nodes)} nodes, {elements} elements, "
            f"surface of {self.surface.face_count} faces)"
        )


def build(
    source: Source,
    nodes: Floats,
    node_ids: Rows,
    blocks: list[Block],
    groups: Groups,
    *,
    links: Rows | None = None,
    unread: Mapping[str, int] | None = None,
    node_values: Arrays | None = None,
    element_values: Arrays | None = None,
) -> Model:
    """The model of a file, with the surface of its shells and solids.

    ``node_values`` and ``element_values`` have a row for each node and each element; they become
    attributes of the surface's vertices and faces, before the groups.

    Raises
    ------
    InvalidFile : no shell or solid element, or coordinates that are not finite.
    """
    indices, sizes, elements = faces_of(nodes, [(b.kind, b.corners) for b in blocks])
    if not len(sizes):
        kinds = sorted({block.name for block in blocks} | set(unread or {}))
        raise InvalidFile(
            f"{source.path}: no shell and no solid elements, only {some(kinds) or 'nodes'}"
        )
    chosen = np.unique(indices)
    place = np.full(len(nodes), -1, dtype=np.int64)
    place[chosen] = np.arange(len(chosen))
    total = sum(len(block.ids) for block in blocks)
    on_nodes = {**(node_values or {}), **_masks(groups.nodes, len(nodes), chosen)}
    on_elements = {**(element_values or {}), **_masks(groups.elements, total, elements)}
    attributes = Attributes(
        vertex={name: values[chosen] for name, values in on_nodes.items()},
        face={name: values[elements] for name, values in on_elements.items()},
    )
    surface = assemble(source.path, nodes[chosen], place[indices], sizes, attributes)
    assert isinstance(surface, Mesh | PolygonMesh)
    for array in (nodes, node_ids, chosen, elements):
        array.setflags(write=False)
    return Model(
        surface,
        chosen,
        elements,
        nodes,
        node_ids,
        tuple(blocks),
        np.concatenate([*_lines(blocks), links if links is not None else NO_LINKS]),
        groups,
        MappingProxyType(dict(unread or {})),
        source,
    )


def _lines(blocks: list[Block]) -> list[Rows]:
    """Which nodes the line elements join."""
    tables = [block.nodes for block in blocks if block.dimension == 1]
    orders = [[0, 1] if table.shape[1] == 2 else [0, 2, 1] for table in tables]
    return [
        table[:, order[i : i + 2]]
        for table, order in zip(tables, orders, strict=True)
        for i in range(len(order) - 1)
    ]


def _masks(sets: Mapping[str, Rows], count: int, seen: Rows) -> dict[str, NDArray[np.int8]]:
    """1 in the set and 0 outside, of the sets that have a part in the surface."""
    masks = {}
    for name, members in sets.items():
        mask = np.zeros(count, dtype=np.int8)
        mask[members] = 1
        if mask[seen].any():
            masks[SET + name] = mask
    return masks
