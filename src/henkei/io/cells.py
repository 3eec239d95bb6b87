"""Kinds of elements: corners, faces, and which corners a mid-side node lies between.

Names and orders of nodes are those of meshio and VTK, but wedges have their first triangle seen
counter-clockwise from the second, as in Abaqus and Nastran.
"""

from __future__ import annotations

from dataclasses import dataclass

Corners = tuple[int, ...]


@dataclass(frozen=True)
class Kind:
    """A kind of element.

    dimension : 1 for lines, 2 for shells, 3 for solids.
    corners : number of corners; they come first.
    faces : corners of each face, counter-clockwise seen from outside; of solids only.
    between : for each further node the corners of the edge, face or solid in whose middle it lies.
    """

    dimension: int
    corners: int
    faces: tuple[Corners, ...] = ()
    between: tuple[Corners, ...] = ()

    @property
    def size(self) -> int:
        """Number of nodes."""
        return self.corners + len(self.between)


def _ring(count: int) -> tuple[Corners, ...]:
    return tuple((i, (i + 1) % count) for i in range(count))


TETRA = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
PYRAMID = ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))
WEDGE = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
HEXAHEDRON = (
    (0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7),
)  # fmt: skip
ON_TETRA = (*_ring(3), (0, 3), (1, 3), (2, 3))
ON_PYRAMID = (*_ring(4), (0, 4), (1, 4), (2, 4), (3, 4))
ON_WEDGE = (*_ring(3), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
ON_HEXAHEDRON = (*_ring(4), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
IN_HEXAHEDRON = (
    (0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7),
    (0, 1, 2, 3, 4, 5, 6, 7),
)  # fmt: skip

KINDS = {
    "line": Kind(1, 2),
    "line3": Kind(1, 2, between=((0, 1),)),
    "triangle": Kind(2, 3),
    "triangle6": Kind(2, 3, between=_ring(3)),
    "triangle7": Kind(2, 3, between=(*_ring(3), (0, 1, 2))),
    "quad": Kind(2, 4),
    "quad8": Kind(2, 4, between=_ring(4)),
    "quad9": Kind(2, 4, between=(*_ring(4), (0, 1, 2, 3))),
    "tetra": Kind(3, 4, TETRA),
    "tetra10": Kind(3, 4, TETRA, ON_TETRA),
    "pyramid": Kind(3, 5, PYRAMID),
    "pyramid13": Kind(3, 5, PYRAMID, ON_PYRAMID),
    "wedge": Kind(3, 6, WEDGE),
    "wedge15": Kind(3, 6, WEDGE, ON_WEDGE),
    "wedge18": Kind(3, 6, WEDGE, ON_WEDGE + WEDGE[2:]),
    "hexahedron": Kind(3, 8, HEXAHEDRON),
    "hexahedron20": Kind(3, 8, HEXAHEDRON, ON_HEXAHEDRON),
    "hexahedron27": Kind(3, 8, HEXAHEDRON, ON_HEXAHEDRON + IN_HEXAHEDRON),
}
"""By name. A ``polygon`` is a shell with any number of corners and is treated apart."""
