"""Planar refinement of a cage by its connectivity alone (section 2 and fig. 1 of Takahashi, 2000).

A triangle becomes four, or a face of n corners becomes n quads, with new vertices at the midpoints
of edges and the centres of faces. The shape stays as it is. Edges of children follow from those of
their parents, so only the edges of the cage are ever sorted.

Numbers of children. Vertices: the old ones, then midpoints by edge, then (quads) centres by face.
Edges: edge e = (a, b) with midpoint m becomes 2e = (a, m) and 2e + 1 = (b, m); of E edges, those
inside triangle f are 2E + 3f + i = (midpoint from corner i, midpoint from corner i - 1), those of
quads 2E + c = (midpoint from corner c, centre). Faces: triangle f becomes 4f + i at corner i and
4f + 3 in the middle; the quad at corner c is number c.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from henkei._kernels import refined_quads, refined_triangles, refined_vertices
from henkei.errors import DegenerateFaces, InvalidInput, InvalidMesh, some
from henkei.geometry.requirements import ORIENTED, Check, Problem, finite, measurable, problems
from henkei.mesh import Attributes, Floats, Surface
from henkei.topology import Ints, following

LOST = ("normal", "crease")  # attributes that no longer hold on a finer surface


@dataclass(frozen=True, eq=False)
class Connectivity:
    """Faces with their edges, without positions.

    indices, offsets : corners of all faces in a row, and where each face starts.
    edges : (e, 2) vertices; the lower first in a cage, the older first in what is refined.
    corner_edges : the edge from each corner to the next of its face.
    """

    vertex_count: int
    indices: Ints
    offsets: NDArray[np.int64]
    edges: Ints
    corner_edges: Ints

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.offsets) - 1

    @property
    def sizes(self) -> NDArray[np.int64]:
        """Number of corners of each face."""
        return np.diff(self.offsets)

    def part(self, faces: NDArray[np.integer]) -> tuple[Connectivity, Ints]:
        """Only some faces, in the order given, and the vertex each of its vertices was.

        Edges and vertices keep their order.
        """
        sizes = self.sizes[faces]
        offsets = np.concatenate([[0], np.cumsum(sizes)])
        corners = np.arange(offsets[-1]) + np.repeat(self.offsets[faces] - offsets[:-1], sizes)
        vertices, indices = _renumbered(self.indices[corners], self.vertex_count)
        kept, corner_edges = _renumbered(self.corner_edges[corners], len(self.edges))
        edges = np.searchsorted(vertices, self.edges[kept]).astype(np.int32)
        return Connectivity(len(vertices), indices, offsets, edges, corner_edges), vertices


def connectivity(surface: Surface) -> Connectivity:
    """The faces of a cage: triangles or polygons, closed or open, of any genus.

    Raises
    ------
    NotFinite, DegenerateFaces, NotManifold, NotOriented; InvalidMesh for no faces, extreme scales
    and vertices without a face
    """
    for problem in problems(surface, CAGE):
        raise problem.error()
    topology = surface.topology
    edges = topology.edges.astype(np.int64)
    ends = np.stack([surface.indices, topology.target]).astype(np.int64)
    keys = ends.min(axis=0) * topology.vertex_count + ends.max(axis=0)
    corner_edges = np.searchsorted(edges @ [topology.vertex_count, 1], keys)
    return Connectivity(
        len(surface.vertices),
        surface.indices,
        surface.offsets,
        topology.edges,
        corner_edges.astype(np.int32),
    )


def counts(coarse: Connectivity, quads: bool, levels: int) -> list[tuple[int, int, int]]:
    """Number of vertices, edges and faces at levels 0 to `levels`, without refining."""
    vertices, edges = coarse.vertex_count, len(coarse.edges)
    faces, corners = coarse.face_count, len(coarse.indices)
    found = [(vertices, edges, faces)]
    for _ in range(levels):
        vertices, edges = vertices + edges + quads * faces, 2 * edges + corners
        faces, corners = corners if quads else 4 * faces, 4 * corners
        found.append((vertices, edges, faces))
    return found


def refined(coarse: Connectivity, quads: bool) -> Connectivity:
    """The children of all faces: quads, or four triangles of each triangle.

    Raises
    ------
    InvalidInput : a face is no triangle where triangles are asked for, or the children are too
        many for indices of 32 bits.
    """
    _require_refinable(coarse, quads)
    c = coarse
    if quads:
        children = refined_quads(c.vertex_count, c.indices, c.offsets, c.edges, c.corner_edges)
    else:
        children = refined_triangles(c.vertex_count, c.indices, c.edges, c.corner_edges)
    vertices, _, faces = counts(coarse, quads, 1)[1]
    sides = 4 if quads else 3
    offsets = np.arange(0, sides * faces + 1, sides)
    return Connectivity(vertices, children[0], offsets, *children[1:])


def prolongation(coarse: Connectivity, quads: bool) -> csr_array:
    """P = [1; N] (finer vertices, vertices): what refinement does to positions (eq. 6)."""
    ends = np.sort(coarse.edges, axis=1).ravel()
    sizes = [np.ones(coarse.vertex_count, np.int64), np.full(len(coarse.edges), 2)]
    indices = [np.arange(coarse.vertex_count, dtype=np.int32), ends]
    if quads:
        sizes.append(coarse.sizes)
        indices.append(_sorted_corners(coarse))
    entries = np.concatenate(sizes)
    start = np.concatenate([[0], np.cumsum(entries)]).astype(np.int32)
    shape = (len(entries), coarse.vertex_count)
    return csr_array((np.repeat(1 / entries, entries), np.concatenate(indices), start), shape=shape)


def refined_positions(coarse: Connectivity, quads: bool, positions: Floats) -> Floats:
    """P times the positions (n, d) of the vertices."""
    if not quads:
        return refined_vertices(positions, coarse.edges, coarse.indices[:0], coarse.offsets[:1])
    return refined_vertices(positions, coarse.edges, coarse.indices, coarse.offsets)


def carried(attributes: Attributes, coarse: Connectivity, quads: bool) -> Attributes:
    """The attributes of a surface on its refinement.

    Numbers at vertices and corners are interpolated, within each face at corners, so that seams of
    texture coordinates survive. Integers are never mixed: a new vertex takes those of the first end
    of its edge or the first corner of its face, a corner those of its child's old corner. Normals
    and creases are left out.
    """
    for name in LOST:
        attributes = attributes.without(name)
    children = coarse.sizes if quads else 4
    return Attributes(
        vertex={n: _at_vertices(a, coarse, quads) for n, a in attributes.vertex.items()},
        corner={n: _at_corners(a, coarse, quads) for n, a in attributes.corner.items()},
        face={n: np.repeat(a, children, axis=0) for n, a in attributes.face.items()},
    )


def _require_refinable(coarse: Connectivity, quads: bool) -> None:
    if not quads and len(coarse.indices) != 3 * coarse.face_count:
        others = np.flatnonzero(coarse.sizes != 3)
        raise InvalidInput(
            f"faces {some(others)} are no triangles: refine this cage into quads instead"
        )
    vertices, edges, faces = counts(coarse, quads, 1)[1]
    if max(vertices, 2 * edges, 4 * faces) > np.iinfo(np.int32).max:
        raise InvalidInput(
            f"the next level has {faces:,} faces, more than indices of 32 bits can number: "
            "use fewer levels"
        )


def _sorted_corners(coarse: Connectivity) -> Ints:
    """The corners of all faces, ascending in each."""
    sizes = coarse.sizes
    if (sizes == sizes[0]).all():  # many times as fast
        return np.sort(coarse.indices.reshape(-1, sizes[0]), axis=1).ravel()
    face = np.repeat(np.arange(coarse.face_count), sizes)
    return coarse.indices[np.lexsort((coarse.indices, face))]


def _before(coarse: Connectivity) -> NDArray[np.int64]:
    """The corner before each corner of its face."""
    before = np.arange(-1, len(coarse.indices) - 1)
    before[coarse.offsets[:-1]] = coarse.offsets[1:] - 1
    return before


def _at_vertices(values: NDArray[Any], coarse: Connectivity, quads: bool) -> NDArray[Any]:
    if values.dtype.kind == "f":
        table = values.reshape(len(values), -1).astype(np.float64)
        finer = refined_positions(coarse, quads, table)
        return finer.astype(values.dtype).reshape(-1, *values.shape[1:])
    new = [values, values[coarse.edges[:, 0]]]
    if quads:
        new.append(values[coarse.indices[coarse.offsets[:-1]]])
    return np.concatenate(new)


def _at_corners(values: NDArray[Any], coarse: Connectivity, quads: bool) -> NDArray[Any]:
    ahead = behind = centre = values
    if values.dtype.kind == "f":
        sizes = coarse.sizes.reshape(-1, *[1] * (values.ndim - 1))
        centres = np.add.reduceat(values, coarse.offsets[:-1]) / sizes
        ahead = (values + values[following(coarse.offsets)]) / 2
        behind = ahead[_before(coarse)]
        centre = np.repeat(centres, coarse.sizes, axis=0).astype(values.dtype)
    around = [values, ahead, centre, behind] if quads else [values, ahead, behind]
    children = np.stack(around, axis=1)
    if not quads:
        corners = children.reshape(-1, 3, *children.shape[1:])
        middle = ahead.reshape(-1, 1, 3, *values.shape[1:])
        children = np.concatenate([corners, middle], axis=1)
    return children.reshape(-1, *values.shape[1:])


def _renumbered(numbers: Ints, count: int) -> tuple[Ints, Ints]:
    """Those of `count` numbers that occur, ascending, and the place of each number among them."""
    occurs = np.zeros(count, bool)
    occurs[numbers] = True
    place = np.cumsum(occurs, dtype=np.int32) - 1
    return np.flatnonzero(occurs).astype(np.int32), place[numbers].astype(np.int32)


def _has_faces(surface: Surface) -> Problem | None:
    if surface.face_count:
        return None
    return Problem(InvalidMesh, "the cage has no faces", "give a mesh of triangles or polygons")


def _corners_enough(surface: Surface) -> Problem | None:
    bad = np.flatnonzero(np.diff(surface.offsets) < 3)
    if not len(bad):
        return None
    return Problem(
        DegenerateFaces,
        f"these faces have fewer than three corners: {some(bad)}",
        "henkei.without_degenerate_faces(mesh) removes them",
    )


def _vertices_used(surface: Surface) -> Problem | None:
    unused = surface.topology.unused_vertices
    if not len(unused):
        return None
    return Problem(
        InvalidMesh,
        f"these vertices belong to no face: {some(unused)}",
        "henkei.without_unused_vertices(mesh) removes them",
    )


CAGE: list[list[Check]] = [
    [_has_faces, _corners_enough],
    [_vertices_used, finite],
    [measurable],
    *ORIENTED,
]
