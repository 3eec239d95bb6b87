"""Undoes refinement: the cage of a mesh whose faces came from cutting those of a coarser one.

After G. Taubin: Detecting and reconstructing subdivision connectivity (2002): faces are put
together in tiles, four triangles to a triangle or the quads about a vertex to a polygon. The place
of one face in its tile decides that of its neighbours, so each connected piece has but four ways to
be tiled, and all of them are tried.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import permutations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from henkei.design.refinement import CAGE, Connectivity, connectivity, refined
from henkei.design.settings import checked_count
from henkei.errors import Infeasible, InvalidInput, some
from henkei.geometry.requirements import problems
from henkei.mesh import Floats, Mesh, PolygonMesh, Surface, simplest
from henkei.topology import BOUNDARY, Ints, Topology

OLD, MIDDLE, CENTRE = 1, 2, 4  # kinds of vertices: of the coarser level, of its edges, of its faces
INNER = 3  # place of the triangle in the middle of its tile; others are named by their old corner

PERMUTATIONS = np.array(list(permutations(range(4))), np.uint8)  # of places; the first is identity
NUMBER = np.zeros((4, 4, 4, 4), np.uint8)  # of each permutation
NUMBER[tuple(PERMUTATIONS.T)] = np.arange(len(PERMUTATIONS))
COMPOSED = NUMBER[tuple(np.moveaxis(PERMUTATIONS[:, PERMUTATIONS], 2, 0))]  # the second comes first

KINDS = {  # (place, corner)
    3: np.where(np.arange(4)[:, None] == np.arange(3), OLD, MIDDLE).astype(np.uint8),
    4: np.array([np.roll([OLD, MIDDLE, CENTRE, MIDDLE], p) for p in range(4)], np.uint8),
}
TILES = {3: ("four triangles to one", 6, 3), 4: ("quads about a vertex to a face", 4, 2)}
NO_MESH = "its cage would have double edges or faces that repeat a vertex"

Bools = NDArray[np.bool_]
Numbers = NDArray[np.integer[Any]]


@dataclass(frozen=True, eq=False)
class Unrefined:
    """How a mesh arose by refinement.

    cage : the coarsest level, its vertices where the given mesh has them; no attributes.
    levels : how often the cage is refined.
    quads : into quads, not into triangles.
    order : (n,) the vertex of the given mesh that is each vertex of the finest level.
    corners : (c,) the corner of the given mesh that is each corner of the finest level.
    """

    cage: Mesh | PolygonMesh
    levels: int
    quads: bool
    order: Ints
    corners: Ints


def unrefined(surface: Surface, levels: int | None = None) -> Unrefined:
    """The cage of a mesh of triangles, each in four, or of quads, n to a face of n corners.

    Vertices and faces may come in any order. Where a mesh has more than one cage, as closed quads
    come from a cage and from its dual, one of those with most levels is found: one whose vertices
    come before all others in their connected piece, as they do after henkei's refinement, or else
    that with more quads.

    Parameters
    ----------
    levels : how many levels to find; as many as there are by default.

    Raises
    ------
    InvalidInput : the number of levels is not positive.
    Infeasible : the faces are not those of any refinement, or of fewer levels.
    NotFinite, DegenerateFaces, NotManifold, NotOriented; InvalidMesh for no faces, extreme scales
    and vertices without a face
    """
    if levels is not None and checked_count(levels, "levels") == 0:
        raise InvalidInput("levels must be 1 or more, or None for as many as there are")
    for problem in problems(surface, CAGE):
        raise problem.error()
    sides = _sides(surface)
    tilings = _Tilings(surface.topology, sides)
    steps = _steps(tilings, levels)
    if not steps:
        raise Infeasible(tilings.refusal())
    if levels is not None and len(steps) < levels:
        raise Infeasible(
            f"the mesh comes from {len(steps)} level(s) of refinement, not from {levels}: its cage "
            f"of {len(steps[-1].coarse.offsets) - 1:,} faces has no coarser one"
        )
    return _traced(surface, steps, sides)


@dataclass(frozen=True, eq=False)
class _Step:
    """One level less.

    coarse : the faces of the tiles.
    first : at each corner of these, the corner of the finer face there that has the same vertex.
    vertices : of the finer level, that are vertices of the coarser one.
    """

    coarse: Topology
    first: Ints
    vertices: Ints


class _Tilings:
    """All ways to put the faces of one level together in tiles, for each connected piece.

    Each face has a place (f, 4) in its tile, for each of the four ways; these are fitting
    (4, pieces) if no face contradicts its neighbours.
    """

    def __init__(self, fine: Topology, sides: int) -> None:
        self._fine, self.sides = fine, sides
        self._neighbours = fine.twin.reshape(-1, sides)
        self._kinds = KINDS[sides]
        self._crossing = _crossing(sides)
        self._piece = fine.face_component
        self._places = self._spread()
        self._fitting = np.stack([self._none(self._misfits(way)) for way in range(4)])

    def coarser(self, refinable: bool) -> _Step | None:
        """The preferred tiling of each piece whose tiles are a mesh; None if a piece has none.

        refinable : and that may again come from refinement.
        """
        able = self._fitting & (self._quads == 1) if refinable else self._fitting.copy()
        while able.any(axis=0).all():
            way = np.where(able, self._preference, -1).argmax(axis=0)
            places = self._places[np.arange(len(self._piece)), way[self._piece]]
            step = _tiled(self._fine, self.sides, places)
            improper = self._piece[_improper(self._fine, self.sides, step) // self.sides]
            if not len(improper):
                return step
            able[way[improper], improper] = False
        return None

    def refusal(self) -> str:
        """Why there is no coarser level."""
        misfits = [self._misfits(way) for way in range(4)]
        counts = np.stack([np.bincount(self._piece, misfit) for misfit in misfits])
        piece = int(counts.min(axis=0).argmax())
        faces = np.flatnonzero(self._piece == piece)
        bad = faces[misfits[int(counts[:, piece].argmin())][faces]]
        tiles, regular, at_boundary = TILES[self.sides]
        return (
            f"the mesh does not come from refinement: the piece of {len(faces):,} faces with face "
            f"{faces[0]} cannot be put together, {tiles}, so that all vertices within edges have "
            f"{regular} faces, or {at_boundary} at a boundary; "
            + (f"it comes nearest but for faces {some(bad)}" if len(bad) else NO_MESH)
            + ". Quadrangulate the surface, or refine a cage of it and take positions from it"
        )

    @cached_property
    def _preference(self) -> Floats:
        """(4, pieces) what decides between tilings: old vertices before all others, then quads."""
        if (self._fitting.sum(axis=0) <= 1).all():
            return np.zeros(self._fitting.shape)
        return 2 * np.stack([self._in_order(way) for way in range(4)]) + self._quads

    def _in_order(self, way: int) -> Bools:
        """(pieces,) whether all old vertices come before all others."""
        old = np.zeros(self._fine.vertex_count, bool)
        old[self._fine.indices] = (self._kinds[self._places[:, way]] == OLD).ravel()
        piece = self._piece[self._corner // self.sides]
        last, first = np.zeros((2, len(np.bincount(piece))), np.int64)
        last[piece[old]] = np.flatnonzero(old)
        first[piece[~old][::-1]] = np.flatnonzero(~old)[::-1]
        return last < first

    @cached_property
    def _quads(self) -> Floats:
        """(4, pieces) what part of the faces is in quads; 1 for triangles."""
        if self.sides == 3:
            return np.ones(self._fitting.shape)
        four = (np.bincount(self._fine.indices) == 4)[self._fine.indices].reshape(-1, 4)
        faces = np.arange(len(four))
        counts = [np.bincount(self._piece, four[faces, p]) for p in (self._places.T + 2) % 4]
        return np.stack(counts) / np.bincount(self._piece)

    def _none(self, faces: Bools) -> Bools:
        """For each piece, whether none of its faces is among these."""
        return np.asarray(np.bincount(self._piece, faces) == 0)

    def _spread(self) -> NDArray[np.uint8]:
        """Places (f, 4) of all faces from those of one face of each piece, along a tree.

        In the first way, the lowest vertex of each piece is an old one.
        """
        sides, count = self.sides, len(self._piece)
        lowest = np.unique(self._piece[self._corner // sides], return_index=True)[1]
        corners = self._corner[lowest]
        roots = corners // sides
        ahead = _tree(self._neighbours // sides, roots)
        side = (self._neighbours // sides == ahead[:, None]).argmax(axis=1)
        there = self._neighbours[np.arange(count), side]
        ways = NUMBER[tuple(np.moveaxis(self._crossing, 2, 0))][there % sides, side]
        ahead[roots], ways[roots] = roots, 0
        while not np.array_equal(ahead, roots[self._piece]):
            ways = COMPOSED[ways, ways[ahead]]
            ahead = ahead[ahead]
        start = (corners[:, None] + np.arange(4)) % sides
        start[:, 3] = np.where(sides == 3, INNER, start[:, 3])
        return np.asarray(np.take_along_axis(PERMUTATIONS[ways], start[self._piece], axis=1))

    @cached_property
    def _corner(self) -> Numbers:
        """The first corner at each vertex."""
        corner = np.empty(self._fine.vertex_count, np.int64)
        corner[self._fine.indices[::-1]] = np.arange(len(self._fine.indices))[::-1]
        return corner

    @cached_property
    def _possible(self) -> NDArray[np.uint8]:
        """(f, sides) kinds that the vertex at each corner may be."""
        border = self._fine.twin == BOUNDARY
        open_ = np.zeros(self._fine.vertex_count, bool)
        open_[self._fine.indices[border]] = True
        faces = np.bincount(self._fine.indices)
        _, inside, at_boundary = TILES[self.sides]
        regular = faces == np.where(open_, at_boundary, inside)
        possible = OLD + MIDDLE * regular + CENTRE * (~open_ & (faces >= 3))
        table: NDArray[np.uint8] = possible.astype(np.uint8)[self._fine.indices]
        return table.reshape(-1, self.sides)

    def _misfits(self, way: int) -> Bools:
        """(f,) faces that cannot be where they are, or whose neighbours cannot."""
        places = self._places[:, way]
        kinds = self._kinds[places]
        misfit: Bools = ((self._possible & kinds) == 0).any(axis=1)
        for side in range(self.sides):
            there = self._neighbours[:, side]
            neighbour = self._crossing[side, there % self.sides, places]
            along_edge = ((kinds[:, side] | kinds[:, (side + 1) % self.sides]) & OLD) > 0
            fits = np.where(there == BOUNDARY, along_edge, places[there // self.sides] == neighbour)
            misfit |= ~fits
        return misfit


def _sides(surface: Surface) -> int:
    sizes = np.diff(surface.offsets)
    sides = 3 if sizes[0] == 3 else 4
    others = np.flatnonzero(sizes != sides)
    if len(others):
        raise Infeasible(
            "refined faces are all triangles or all quads: face 0 has "
            f"{sizes[0]} corners, faces {some(others)} have {some(np.unique(sizes[others]))}"
        )
    return sides


def _crossing(sides: int) -> NDArray[np.uint8]:
    """(side, side of the neighbour, place) the place of the neighbour across a side.

    Sides are numbered by the corner that they start from.
    """
    table = np.empty((sides, sides, 4), np.uint8)
    for here, there, place in product(range(sides), range(sides), range(4)):
        if place == INNER and sides == 3:
            neighbour = (there + 2) % 3
        elif place == (here + 2) % 3 and sides == 3:
            neighbour = INNER
        else:  # the same of the two vertices is old, or opposite to the old one
            neighbour = (here + there + 1 - place) % sides
        table[here, there, place] = neighbour
    return table


def _tree(neighbours: Numbers, roots: Numbers) -> Numbers:
    """(f,) the face from which each is reached first, starting from some.

    neighbours : (f, sides), negative where there is none.
    """
    count = len(neighbours)
    linked = neighbours >= 0
    links = np.concatenate([neighbours[linked], roots])
    start = np.concatenate([[0], np.cumsum(linked.sum(axis=1)), [len(links)]])
    graph = csr_array((np.ones(len(links)), links, start), shape=(count + 1, count + 1))
    return np.asarray(breadth_first_order(graph, count)[1][:count])


def _tiled(fine: Topology, sides: int, places: NDArray[np.uint8]) -> _Step:
    """The tiles of faces whose places in them are known."""
    make = _triangles if sides == 3 else _polygons
    first, offsets = make(fine, places)
    is_old = np.zeros(fine.vertex_count, bool)
    is_old[fine.indices[first]] = True
    indices = (np.cumsum(is_old, dtype=np.int32) - np.int32(1))[fine.indices[first]]
    vertices = np.flatnonzero(is_old).astype(np.int32)
    return _Step(Topology(len(vertices), indices, offsets), first.astype(np.int32), vertices)


def _triangles(fine: Topology, places: NDArray[np.uint8]) -> tuple[Numbers, NDArray[np.int64]]:
    """Old corners about all inner triangles; where each tile starts."""
    inner = np.flatnonzero(places == INNER)
    opposite = fine.twin[3 * inner[:, None] + [2, 0, 1]].ravel()
    return _after(opposite, 2, 3), np.arange(0, 3 * len(inner) + 1, 3)


def _polygons(fine: Topology, places: NDArray[np.uint8]) -> tuple[Numbers, NDArray[np.int64]]:
    """Old corners of all quads, about centres in ascending order, each from its first quad on;
    where each tile starts."""
    quads = np.arange(len(places))
    corners = 4 * quads + places
    centre = fine.indices[_after(corners, 2, 4)]
    following = fine.twin[_after(corners, 1, 4)] // 4
    head = np.empty(fine.vertex_count, np.int64)  # the first quad about a centre
    head[centre[::-1]] = quads[::-1]
    ends = following == head[centre]
    rest = (~ends).astype(np.int64)
    ahead: Numbers = np.where(ends, quads, following)
    while rest[ahead].any():  # after j rounds, the quads up to 2^j ahead are counted
        rest += rest[ahead]
        ahead = ahead[ahead]
    sizes = np.bincount(centre, minlength=fine.vertex_count)
    end = np.cumsum(sizes)
    first = np.empty_like(corners)
    first[end[centre] - 1 - rest] = corners
    return first, np.concatenate([[0], end[sizes > 0]])


def _improper(fine: Topology, sides: int, step: _Step) -> Numbers:
    """Corners of the finer level in tiles that repeat a vertex, or that have an edge between the
    same two vertices as another edge."""
    coarse = step.coarse
    start, end = coarse.indices.astype(np.int64), coarse.target.astype(np.int64)
    middle = fine.indices[_after(step.first, 1, sides)]
    edge = np.minimum(start, end) * coarse.vertex_count + np.maximum(start, end)
    order = np.argsort(edge, kind="stable")
    same = edge[order[1:]] == edge[order[:-1]]
    double = order[1:][same & (middle[order[1:]] != middle[order[:-1]])]
    again = coarse.degenerate_faces if sides == 4 else np.flatnonzero(start == end) // 3
    return np.asarray(step.first[np.concatenate([double, coarse.offsets[again]])])


def _steps(tilings: _Tilings, most: int | None) -> list[_Step]:
    """From fine to coarse; none if there is no coarser level."""
    step = tilings.coarser(refinable=True) if most != 1 else None
    if step is not None:
        most = None if most is None else most - 1
        deeper = _steps(_Tilings(step.coarse, tilings.sides), most)
        if deeper:
            return [step, *deeper]
    last = tilings.coarser(refinable=False)
    return [] if last is None else [last]


def _traced(surface: Surface, steps: list[_Step], sides: int) -> Unrefined:
    """Follows corners from the cage to the finest level, and compares all faces."""
    vertices = np.arange(len(surface.vertices))
    for step in steps:
        vertices = vertices[step.vertices]
    faces = steps[-1].coarse.indices, steps[-1].coarse.offsets
    cage = simplest(PolygonMesh(surface.vertices[vertices], faces))
    level = connectivity(cage)
    corners: Ints = np.arange(len(level.indices), dtype=np.int32)
    finer = [surface.topology, *(step.coarse for step in steps[:-1])]
    for step, fine in zip(reversed(steps), reversed(finer), strict=True):
        corners = _children(step.first[corners], fine, sides)
        level = refined(level, quads=sides == 4)
    order = np.empty(level.vertex_count, np.int32)
    order[level.indices] = surface.indices[corners]
    _verify(surface, level, order, corners)
    return Unrefined(cage, len(steps), sides == 4, order, corners)


def _children(first: Ints, fine: Topology, sides: int) -> Ints:
    """The corners of the children of all faces, from the first of the child at each corner."""
    around = np.stack([_after(first, k, sides) for k in range(sides)], axis=1)
    if sides == 3:
        outer = around.reshape(-1, 3, 3)
        inner = fine.twin[np.roll(outer[:, :, 1], -1, axis=1)]
        around = np.concatenate([outer, inner[:, None]], axis=1)
    return around.reshape(-1)


def _verify(surface: Surface, level: Connectivity, order: Ints, corners: Ints) -> None:
    once = np.array_equal(np.sort(corners), np.arange(len(surface.indices)))
    once = once and np.array_equal(np.sort(order), np.arange(len(surface.vertices)))
    if not (once and np.array_equal(order[level.indices], surface.indices[corners])):
        raise Infeasible(
            "the cage that was found, refined, does not give the faces of the mesh: this is an "
            "error of henkei; please report it with the mesh"
        )


def _after(corners: Any, steps: int, sides: int) -> Any:
    """The corners so many steps on in their faces."""
    return corners - corners % sides + (corners + steps) % sides
