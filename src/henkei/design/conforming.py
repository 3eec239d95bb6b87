"""One surface without gaps of levels that refine only some faces.

Each face is shown as fine as it is refined. Where a face lies beside finer ones, their vertices on
its edges become corners of it if it is a polygon; a triangle is cut along them. These vertices lie
on straight edges, so no shape changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.design.levels import Level, Levels
from henkei.design.part import PartialLevel
from henkei.design.refinement import Connectivity
from henkei.mesh import Attributes
from henkei.topology import Ints, following

# Triangles by which of the edges 0, 1, 2 are cut (bits 1, 2, 4), each corner between two: edge i
# leads from corner i to the next.
CUT = {
    0b000: [[(0, 0), (1, 1), (2, 2)]],
    0b111: [
        [(0, 0), (0, 1), (2, 0)],
        [(1, 1), (1, 2), (0, 1)],
        [(2, 2), (2, 0), (1, 2)],
        [(0, 1), (1, 2), (2, 0)],
    ],
}
for _edge in range(3):
    _a, _b, _c = _edge, (_edge + 1) % 3, (_edge + 2) % 3
    CUT[1 << _edge] = [[(_a, _a), (_a, _b), (_c, _c)], [(_a, _b), (_b, _b), (_c, _c)]]
    CUT[0b111 - (1 << _edge)] = [
        [(_b, _c), (_c, _c), (_c, _a)],
        [(_a, _a), (_b, _b), (_b, _c)],
        [(_a, _a), (_b, _c), (_c, _a)],
    ]


@dataclass(frozen=True, eq=False)
class Faces:
    """Faces of a surface and where what they carry comes from.

    corners : (c,) vertices; offsets : where each face starts.
    origin : (c, 2) corners before, of which each is the middle, or twice the same.
    face : (f,) the face before.
    """

    corners: Ints
    offsets: NDArray[np.int64]
    origin: NDArray[np.int64]
    face: NDArray[np.int64]


class Conforming:
    """The surface of a level and, where that does not refine them, of faces of levels before.

    Attributes
    ----------
    numbers : of each level, the vertex of the surface that each of its vertices is. Vertices of
        levels that refine all faces keep their numbers.
    indices, offsets : corners of all faces in a row, and where each face starts.
    """

    def __init__(self, levels: Levels, number: int) -> None:
        self._size = 0
        self.numbers: list[Ints] = []
        cut = [np.empty((0, 3), dtype=np.int64)]
        for level in levels[: number + 1]:
            self.numbers.append(self._numbers(level))
            self._size = max(self._size, int(self.numbers[-1].max()) + 1)
            if isinstance(level, PartialLevel):
                cut.append(_cut_edges(level, self.numbers[-1]))
        self._cut = np.concatenate(cut)
        self._shown = _shown(levels, number)
        self._sizes = [level.connectivity.sizes for level in levels[: number + 1]]
        corners = [
            names[level.connectivity.indices]
            for level, names in zip(levels, self.numbers, strict=False)
        ]
        self.indices: Ints = self._at_corners(corners).astype(np.int32)
        sizes = np.concatenate([s[f] for s, f in zip(self._sizes, self._shown, strict=True)])
        self.offsets = np.concatenate([[0], np.cumsum(sizes)])
        self._passes: list[Faces] = []
        split = _polygons if levels[0].quads else _triangles
        while len(self._cut) and (middle := self._middles()).max() >= 0:
            made = split(self.indices, self.offsets, middle)
            self.indices, self.offsets = made.corners, made.offsets
            self._passes.append(made)

    def at_vertices(self, of_levels: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """What the vertices of all levels carry, each from the finest level that has it."""
        values = np.empty((self._size, *of_levels[0].shape[1:]), of_levels[0].dtype)
        for names, own in zip(self.numbers, of_levels, strict=False):
            values[names] = own
        return values

    def attributes(self, of_levels: Sequence[Attributes]) -> Attributes:
        """What the levels carry, on this surface."""
        last = of_levels[len(self._shown) - 1]
        of_levels = of_levels[: len(self._shown)]
        return Attributes(
            vertex={n: self.at_vertices([a.vertex[n] for a in of_levels]) for n in last.vertex},
            corner={n: self._corner([a.corner[n] for a in of_levels]) for n in last.corner},
            face={n: self._face([a.face[n] for a in of_levels]) for n in last.face},
        )

    def _numbers(self, level: Level) -> Ints:
        if not isinstance(level, PartialLevel):
            return np.arange(level.size, dtype=np.int32)
        new = self._size + np.arange(level.size - len(level.origin), dtype=np.int32)
        return np.concatenate([self.numbers[-1][level.origin], new])

    def _middles(self) -> NDArray[np.int64]:
        """The vertex (c,) in the middle of the edge from each corner to the next; -1 for none."""
        key = _key(self.indices, self.indices[following(self.offsets)], self._size)
        keys = _key(self._cut[:, 0], self._cut[:, 1], self._size)
        order = np.argsort(keys)
        place = order[np.minimum(np.searchsorted(keys[order], key), len(keys) - 1)]
        return np.where(keys[place] == key, self._cut[place, 2], -1)

    def _at_corners(self, of_levels: Sequence[NDArray[Any]]) -> NDArray[Any]:
        every = zip(of_levels, self._shown, self._sizes, strict=True)
        return np.concatenate([own[np.repeat(shown, sizes)] for own, shown, sizes in every])

    def _corner(self, of_levels: Sequence[NDArray[Any]]) -> NDArray[Any]:
        values = self._at_corners(of_levels)
        for one in self._passes:
            first, second = values[one.origin[:, 0]], values[one.origin[:, 1]]
            mixed = values.dtype.kind == "f"
            values = ((first + second) / 2).astype(values.dtype) if mixed else first
        return values

    def _face(self, of_levels: Sequence[NDArray[Any]]) -> NDArray[Any]:
        values = np.concatenate([own[f] for own, f in zip(of_levels, self._shown, strict=True)])
        for one in self._passes:
            values = values[one.face]
        return values


def _shown(levels: Levels, number: int) -> list[NDArray[np.bool_]]:
    """Which faces of each level are on the surface of a level, none being refined there."""
    found = []
    for level, finer in pairwise(levels[: number + 1]):
        refined = np.ones(level.connectivity.face_count, dtype=bool)
        if isinstance(finer, PartialLevel):
            refined = np.isin(np.arange(len(refined)), finer.faces)
        found.append(~refined)
    return [*found, np.ones(levels[number].connectivity.face_count, dtype=bool)]


def _cut_edges(level: PartialLevel, numbers: Ints) -> NDArray[np.int64]:
    """Edges (e, 3) that a level cuts and the faces beside do not: their ends and their middle."""
    halves = level.connectivity.edges[level.rim].reshape(-1, 2, 2)
    ends_and_middle = np.column_stack([halves[:, :, 0], halves[:, 0, 1]])
    return numbers[ends_and_middle].astype(np.int64)


def _key(a: NDArray[Any], b: NDArray[Any], count: int) -> NDArray[np.int64]:
    key: NDArray[np.int64] = np.minimum(a, b).astype(np.int64) * count + np.maximum(a, b)
    return key


def _polygons(corners: Ints, offsets: NDArray[np.int64], middle: NDArray[np.int64]) -> Faces:
    """Polygons with the middles of cut edges as further corners."""
    cut = middle >= 0
    start = np.concatenate([[0], np.cumsum(1 + cut)])
    made = np.empty(start[-1], np.int32)
    origin = np.empty((start[-1], 2), dtype=np.int64)
    every = np.arange(len(corners))
    made[start[:-1]], origin[start[:-1]] = corners, every[:, None]
    between = start[:-1][cut] + 1
    made[between] = middle[cut]
    origin[between] = np.column_stack([every[cut], following(offsets)[cut]])
    return Faces(made, start[offsets], origin, np.arange(len(offsets) - 1))


def _triangles(corners: Ints, offsets: NDArray[np.int64], middle: NDArray[np.int64]) -> Faces:
    """Triangles cut where their edges are."""
    pattern = (middle.reshape(-1, 3) >= 0) @ [1, 2, 4]
    face, origin = [], []
    for cuts, children in CUT.items():
        some = np.flatnonzero(pattern == cuts)
        face.append(np.repeat(some, len(children)))
        origin.append((3 * some[:, None, None, None] + np.array(children)).reshape(-1, 3, 2))
    order = np.argsort(np.concatenate(face), kind="stable")
    pairs = np.concatenate(origin)[order].reshape(-1, 2)
    first, second = pairs.T
    edge = np.where(following(offsets)[first] == second, first, second)
    made = np.where(first == second, corners[first], middle[edge]).astype(np.int32)
    return Faces(made, 3 * np.arange(len(order) + 1), pairs, np.concatenate(face)[order])


def on_part(
    attributes: Attributes, faces: Connectivity, some: NDArray[np.integer]
) -> tuple[Attributes, Connectivity]:
    """The attributes of some faces, and these faces alone."""
    part, vertices = faces.part(some)
    starts = np.repeat(faces.offsets[some] - part.offsets[:-1], part.sizes)
    corners = np.arange(len(part.indices)) + starts
    of_part = Attributes(
        vertex={name: values[vertices] for name, values in attributes.vertex.items()},
        corner={name: values[corners] for name, values in attributes.corner.items()},
        face={name: values[some] for name, values in attributes.face.items()},
    )
    return of_part, part
