"""A part of a surface on all of its levels, as levels of its own.

Its numbering is its own; operators are those of the whole surface as far as vertices that may move
are concerned. So what is computed costs as much as the part has vertices.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from henkei.design.levels import Level, Levels, Mask, compact, times
from henkei.design.refinement import Connectivity
from henkei.design.settings import checked_indices
from henkei.errors import InvalidInput
from henkei.mesh import Floats
from henkei.topology import Ints

Faces = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, kw_only=True)
class PartialLevel(Level):
    """A level that refines only some faces of the one before.

    faces : those faces, ascending.
    origin : the vertex of the level before that each of its old vertices was.
    rim : (e,) which of its edges end the refined part inside the surface.
    """

    faces: Ints
    origin: Ints
    rim: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, kw_only=True)
class Pins(Level):
    """Those hats of the cage that end within a part, as a level before the cage.

    among : (m, m) their inner products.
    """

    among: csr_array

    @property
    def products(self) -> csr_array:
        return self.among


def parents(level: Level, coarse: Level) -> Ints:
    """The face of the level before that each face of a level is in."""
    faces: Ints = np.arange(coarse.connectivity.face_count, dtype=np.int32)
    if isinstance(level, PartialLevel):
        faces = level.faces
    found: Ints = np.repeat(faces, coarse.connectivity.sizes[faces] if level.quads else 4)
    return found


def whole(levels: Levels) -> int:
    """The number of the finest level that refines all faces."""
    return sum(not isinstance(level, PartialLevel) for level in levels) - 1


class Part:
    """Some faces of a level with all that is below and above them.

    Parameters
    ----------
    levels : of the whole surface.
    number : of the level the faces are on.

    Attributes
    ----------
    vertices : of each level, those of faces that are in the part at least partly, ascending.
    loose : of each level (m,), whether one of these vertices may move without changing the surface
        outside: all faces around it are in the part.
    free : the same, but for those that follow the level before (see :class:`Level`).
    levels : what these faces are on, after a first level of :class:`Pins`; level k is number k + 1.
    """

    def __init__(self, levels: Levels, number: int, faces: NDArray[np.integer]) -> None:
        self.number = number
        inside, touched = _on_all_levels(levels, number, faces)
        self.vertices: list[Ints] = []
        self.loose: list[Mask] = []
        self.free: list[Mask] = []
        made: list[Level] = []
        coarse: Connectivity | None = None
        for level, whole, met in zip(levels, inside, touched, strict=True):
            connectivity, vertices = level.connectivity.part(np.flatnonzero(met))
            loose = _within(level.connectivity, whole)[vertices]
            free = loose if level.free is None else loose & level.free[vertices]
            if level.prolongation is None:
                between = compact(eye_array(len(vertices)).tocsc()[:, np.flatnonzero(free)])
                pins = vertices[free > 0]
                among = compact(level.products[pins][:, pins])
                made.append(Pins(0, _without_faces(len(pins)), level.quads, among=among))
            else:
                between = compact(level.prolongation[vertices][:, self.vertices[-1]])
            made.append(Level(level.number, connectivity, level.quads, between, free, coarse))
            coarse = connectivity
            self.vertices.append(vertices)
            self.loose.append(loose)
            self.free.append(free)
        self.levels = Levels(made)

    def moving(self, number: int) -> Ints:
        """The vertices of a level that may move, by their numbers on the whole surface."""
        return self.vertices[number][self.free[number] > 0]

    def inside(self, number: int) -> Ints:
        """The vertices of a level that may be elsewhere, by their numbers on the whole surface."""
        return self.vertices[number][self.loose[number] > 0]

    def within(self) -> Floats:
        """The integral (m,) of each hat of the cage over what may move, on the level with most."""
        most = np.zeros(len(self.vertices[0]))
        for number, free in enumerate(self.free):
            inner = times(self.levels[number + 1].products, free[:, None].astype(np.float64))
            for level in self.levels[number + 1 : 1 : -1]:
                inner = times(level.summed, inner)
            most = np.maximum(most, inner[:, 0])
        return most


def checked_faces(levels: Levels, number: int, faces: Any) -> NDArray[np.integer]:
    """Faces of a level, ascending.

    Raises
    ------
    InvalidInput : none, or faces that the level does not have.
    """
    count = levels[number].connectivity.face_count
    given = checked_indices(faces, count, "faces", f"level {number}")
    if not len(given):
        raise InvalidInput(f"faces of level {number} are a list of whole numbers, not an empty one")
    return given


def _on_all_levels(
    levels: Levels, number: int, faces: NDArray[np.integer]
) -> tuple[list[Faces], list[Faces]]:
    """The faces (f,) of each level that are in a part as a whole, and those that are partly."""
    chosen = np.zeros(levels[number].connectivity.face_count, dtype=bool)
    chosen[faces] = True
    inside, touched = [chosen], [chosen]
    for k in range(number, 0, -1):
        coarse = levels[k - 1]
        parent, count = parents(levels[k], coarse), coarse.connectivity.face_count
        children = np.bincount(parent, minlength=count)
        within = np.bincount(parent[inside[0]], minlength=count)
        inside.insert(0, (within == children) & (children > 0))
        touched.insert(0, np.bincount(parent[touched[0]], minlength=count) > 0)
    for k in range(number + 1, len(levels)):
        inside.append(inside[-1][parents(levels[k], levels[k - 1])])
        touched.append(inside[-1])
    return inside, touched


def _within(connectivity: Connectivity, inside: Faces) -> Mask:
    """Which vertices (m,) have no face around them outside."""
    within = np.ones(connectivity.vertex_count, np.uint8)
    within[connectivity.indices[np.repeat(~inside, connectivity.sizes)]] = 0
    return within


def _without_faces(count: int) -> Connectivity:
    none = np.empty(0, np.int32)
    return Connectivity(count, none, np.zeros(1, np.int64), none.reshape(0, 2), none)
