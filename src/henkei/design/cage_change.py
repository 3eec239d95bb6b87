"""A design on another cage that is mostly the same: only what is near the change is smoothed anew.

Wished for in section 9 of S. Takahashi: Designing subdivision surfaces via multiresolution-based
local filtering (2000).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from henkei.design.constraints import Constraint, Curve, Derivative, Direction, Pin
from henkei.design.levels import Levels
from henkei.design.local_refinement import faces_around
from henkei.design.multilevel import Shape
from henkei.design.part import parents, whole
from henkei.design.paths import Place
from henkei.design.refinement import Connectivity
from henkei.errors import InvalidInput
from henkei.mesh import Floats

if TYPE_CHECKING:
    from henkei.design.designer import Designer

Numbers = NDArray[np.int64]

LOST = -1


@dataclass(frozen=True, eq=False)
class Match:
    """What of one level is on the same level of another cage.

    corners, vertices : the number there of each corner and vertex; -1 for none.
    """

    old: Connectivity
    new: Connectivity
    corners: Numbers
    vertices: Numbers

    @classmethod
    def of(cls, old: Connectivity, new: Connectivity, corners: Numbers) -> Match:
        """By corners alone."""
        vertices = np.full(old.vertex_count, LOST, np.int64)
        kept = corners != LOST
        vertices[old.indices[kept]] = new.indices[corners[kept]]
        return cls(old, new, corners, vertices)

    def vertex(self, vertex: int) -> int | None:
        """Where a vertex is; None if it is lost."""
        there = int(self.vertices[vertex])
        return None if there == LOST else there

    def face(self, face: int, values: Sequence[float]) -> tuple[int, tuple[float, ...]] | None:
        """Where a face is, and values of its corners as they follow there; None if it is lost."""
        corners = self.corners[self.old.offsets[face] : self.old.offsets[face + 1]]
        if (corners == LOST).any():
            return None
        there = int(np.searchsorted(self.new.offsets, corners.min(), side="right")) - 1
        return there, tuple(np.asarray(values)[np.argsort(corners)].tolist())

    def place(self, place: Place) -> Place | None:
        """Where a vertex, or a face and the weights of its corners, is; None if it is lost."""
        return self.vertex(place) if isinstance(place, int) else self.face(*place)


def matches(old: Levels, new: Levels, vertices: Numbers) -> list[Match]:
    """What two cages have in common on all levels, by the vertex (m,) of the new cage that each of
    the old one is."""
    found = [_match(old[0].connectivity, new[0].connectivity, vertices)]
    for coarse, fine, other in zip(old, old[1:], new[1:], strict=False):
        children = _children(found[-1], coarse.quads)
        found.append(Match.of(fine.connectivity, other.connectivity, children))
    return found


def same_vertices(old: Floats, new: Floats) -> Numbers:
    """The vertex of a new cage (m,) that each of an old one is: where it is, or of its number."""
    places: defaultdict[bytes, list[int]] = defaultdict(list)
    for vertex, position in enumerate(new + 0.0):  # no negative zeros
        places[position.tobytes()].append(vertex)
    found = np.full(len(old), LOST, np.int64)
    for vertex, position in enumerate(old + 0.0):
        here = places[position.tobytes()]
        if here:
            found[vertex] = here.pop(here.index(vertex) if vertex in here else 0)
    free = np.setdiff1d(np.arange(len(new)), found)
    moved = np.intersect1d(np.flatnonzero(found == LOST), free)
    found[moved] = moved
    return found


def _match(old: Connectivity, new: Connectivity, vertices: Numbers) -> Match:
    there = {}
    for start, end in zip(new.offsets[:-1], new.offsets[1:], strict=True):
        key, first = _turned(new.indices[start:end].astype(np.int64))
        there[key] = (start, first)
    corners = np.full(len(old.indices), LOST, np.int64)
    for start, end in zip(old.offsets[:-1], old.offsets[1:], strict=True):
        key, first = _turned(vertices[old.indices[start:end]])
        if key in there:
            begin, turned = there[key]
            size = end - start
            corners[start:end] = begin + (np.arange(size) - first + turned) % size
    return Match.of(old, new, corners)


def _turned(face: Numbers) -> tuple[tuple[int, ...], int]:
    """A face from its lowest vertex on, and which corner that is."""
    first = int(np.argmin(face))
    return tuple(np.roll(face, -first).tolist()), first


def _children(match: Match, quads: bool) -> Numbers:
    """The corners of children, by those of their parents."""
    if quads:
        children = 4 * match.corners[:, None] + np.arange(4)
        return np.where(match.corners[:, None] == LOST, LOST, children).ravel()
    corners = match.corners.reshape(-1, 3)
    face, turn = corners // 3, corners % 3
    outer = 3 * (4 * face + turn)[:, :, None] + np.arange(3)
    middle = 3 * (4 * face + 3) + turn
    children = np.concatenate([outer, middle[:, None]], axis=1)
    return np.where((corners[:, 0] == LOST)[:, None, None], LOST, children).ravel()


def with_cage(designer: Designer, cage: Any, rings: int) -> tuple[Designer, list[Constraint]]:
    """The same design on another cage, and the constraints that have no place there.

    Raises
    ------
    InvalidInput : some levels refine only parts.
    """
    levels = designer._levels
    if whole(levels) < designer.levels:
        raise InvalidInput("the cage can't change under levels that refine only some faces")
    settings = designer._live.settings
    made = type(designer)(
        cage,
        designer.levels,
        steps=settings.steps,
        support=designer.support,
        interpolating=designer.interpolating,
        refinement=designer.refinement,
    )
    made._live.settings = settings
    vertices = same_vertices(designer.cage.vertices, made.cage.vertices)
    common = matches(levels, made._levels, vertices)
    let_go = common[0].vertices[~designer.pinned]
    if (let_go != LOST).any():
        made.unpin(let_go[let_go != LOST])
    lost = [one for one in designer.constraints if not _carried(one, made, common[one.level])]
    _hold_the_rest(designer, made, common, lost, rings)
    return made, lost


def _carried(one: Constraint, made: Designer, match: Match) -> bool:
    """Give a constraint to another designer, if what it acts on is there."""
    if isinstance(one, Curve):
        path = [match.place(place) for place in one.path]
        if None in path:
            return False
        made.curve(one.level, path, one.target, name=one.name, cutoff=one.cutoff)
        return True
    assert isinstance(one, Pin | Derivative)
    place = match.place(one.place)
    if place is None:
        return False
    if isinstance(one, Pin):
        made.pin(one.level, place, one.target, name=one.name)
        return True
    towards = _direction(one, match)
    if towards is None:
        return False
    made.derivative(one.level, place, towards, one.target, name=one.name)
    return True


def _direction(one: Derivative, match: Match) -> Direction | None:
    if isinstance(one.place, int) or isinstance(one.direction, int):
        assert isinstance(one.direction, int)
        return match.vertex(one.direction)
    there = match.face(one.place[0], one.direction)
    return None if there is None else there[1]


def _hold_the_rest(
    designer: Designer, made: Designer, common: list[Match], lost: list[Constraint], rings: int
) -> None:
    """Take over the shapes of all levels away from the change, and smooth only near it."""
    changed = _changed(designer, made, common[0], lost)
    faces = made._levels[0].connectivity
    near = faces_around(faces, changed, 1 + rings)
    if len(near) == faces.face_count:
        return
    shapes = []
    for number, (shape, match) in enumerate(zip(designer._live.shapes(), common, strict=True)):
        positions = made._meshes.flat(number).copy()
        kept = match.vertices != LOST
        positions[match.vertices[kept]] = shape.positions[kept]
        shapes.append(Shape(positions, np.empty((0, 3))))
    made._live.take(shapes, near if len(near) else np.arange(faces.face_count), not len(near))


def _changed(
    designer: Designer, made: Designer, match: Match, lost: list[Constraint]
) -> NDArray[np.integer]:
    """The vertices of the new cage around which the surface is not what it was."""
    before = [match.old.indices[match.corners == LOST]]
    for one in lost:
        faces = faces_around(designer._levels[one.level].connectivity, one.rows.indices, 1)
        for number in range(one.level, 0, -1):
            faces = parents(designer._levels[number], designer._levels[number - 1])[faces]
        of_lost = np.isin(np.arange(match.old.face_count), faces)
        before.append(match.old.indices[np.repeat(of_lost, match.old.sizes)])
    kept = np.flatnonzero(match.vertices != LOST)
    moved = designer.cage.vertices[kept] != made.cage.vertices[match.vertices[kept]]
    before.append(kept[moved.any(axis=1)])
    after = match.vertices[np.concatenate(before)]
    new = np.ones(len(match.new.indices), dtype=bool)
    new[match.corners[match.corners != LOST]] = False
    return np.union1d(after[after != LOST], match.new.indices[new])
