"""From two surfaces to two triangulations of one polygon, on integers (Sections 3 and 4.6)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from henkei._kernels import not_positive
from henkei.errors import Infeasible, some
from henkei.geometry.disk import (
    Flattening,
    Refined,
    boundary_parameter,
    flattenings,
    no_flattening,
    polygon_points,
    split_chords,
)
from henkei.geometry.landmark_flow import flowed
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress
from henkei.topology import Ints

COINCIDENT = 1e-11  # of a side: boundary vertices of a and b nearer than this become one
# Bits: a coarser grid unites what only rounding errors keep apart, so the coarsest one that serves
# is taken. Floats have no more than 52 bits below 1.
CLEARANCE = 1 << 16  # units that faces stand out from the sides, where points are rounded, too
RESOLUTIONS = (30, 34, 38, 42, 46, 50, 52)


@dataclass(frozen=True, eq=False)
class Side:
    """One of the two surfaces, with its place on the common polygon.

    name : what messages call it.
    refined : the surface with its chords split.
    loop : its boundary vertices in order, the first at the polygon's first corner.
    parameter : (k,) where they lie on the polygon, see :func:`boundary_parameter`.
    """

    name: str
    refined: Refined
    loop: Ints
    parameter: Floats

    @classmethod
    def of(cls, name: str, mesh: Mesh, loop: Ints, corners: NDArray[np.integer]) -> Side:
        """Prepare a disk whose boundary loop starts with a corner."""
        parameter = boundary_parameter(mesh, loop, corners)
        return cls(name, split_chords(mesh, loop, corners), loop, parameter)


@dataclass(frozen=True, eq=False)
class Polygon:
    """The boundary that both triangulations share.

    nodes : (k, 2) vertex of a and vertex of b, -1 where the other has none, counter-clockwise.
    parameter : (k,) where they lie.
    sides : number of sides.
    """

    nodes: Ints
    parameter: Floats
    sides: int


@dataclass(frozen=True, eq=False)
class CommonPlane:
    """Two injective triangulations of one polygon.

    points_a, points_b : (n, 2) int64, in units of 2^-bits.
    flat_a, flat_b : the flattenings that they are rounded from.
    """

    polygon: Polygon
    points_a: NDArray[np.int64]
    points_b: NDArray[np.int64]
    flat_a: Flattening
    flat_b: Flattening
    bits: int


def common_polygon(a: Side, b: Side) -> Polygon:
    """Merge the boundary vertices of both along each side of the polygon (4.2, Fig. 7)."""
    sides = int(a.parameter[-1]) + 1
    nodes: list[tuple[int, int]] = []
    parameter: list[float] = []
    for side in range(sides):
        on_a, on_b = (
            list(zip(s.parameter[on], s.loop[on], strict=True))
            for s in (a, b)
            for on in [np.floor(s.parameter) == side]
        )
        for where, vertex_a, vertex_b in _merged(on_a, on_b):
            parameter.append(where)
            nodes.append((vertex_a, vertex_b))
    return Polygon(np.array(nodes, dtype=np.int32), np.array(parameter), sides)


def _merged(
    on_a: list[tuple[float, int]], on_b: list[tuple[float, int]]
) -> Iterator[tuple[float, int, int]]:
    """Both lists in one; each starts with the side's corner, which they share."""
    i = j = 0
    while i < len(on_a) or j < len(on_b):
        here_a, vertex_a = on_a[i] if i < len(on_a) else (np.inf, -1)
        here_b, vertex_b = on_b[j] if j < len(on_b) else (np.inf, -1)
        if i == j == 0 or (i and j and abs(here_a - here_b) <= COINCIDENT):
            yield here_a, vertex_a, vertex_b
            i, j = i + 1, j + 1
        elif here_a < here_b:
            yield here_a, vertex_a, -1
            i += 1
        else:
            yield here_b, -1, vertex_b
            j += 1


def common_planes(a: Side, b: Side, landmarks: Ints, progress: Progress) -> Iterator[CommonPlane]:
    """Flatten both surfaces into the common polygon and round them to one grid, injectively.

    The most faithful maps come first, on ever finer grids; then others that spread what these
    crowd. ``landmarks`` (k, 2)
    are vertices of a and of b that are brought to one place, halfway between their own.

    Raises
    ------
    Infeasible : no weights and no resolution keep all triangles of a surface upright.
    """
    polygon = common_polygon(a, b)
    for spread in (False, True):
        progress("flattening a", 0.0)
        flat_a = _injective(a, polygon, 0, spread)
        progress("flattening b", 0.5)
        flat_b = _injective(b, polygon, 1, spread)
        if len(landmarks):
            progress("bringing the landmarks together", 0.9)
            flat_a, flat_b = _brought_together(a, b, flat_a, flat_b, landmarks, polygon.sides)
        yield from _on_one_grid(a, b, polygon, flat_a, flat_b)


def _brought_together(
    a: Side, b: Side, flat_a: Flattening, flat_b: Flattening, landmarks: Ints, sides: int
) -> tuple[Flattening, Flattening]:
    of_a, of_b = landmarks.T
    try:
        return _flowed(a, b, flat_a, flat_b, landmarks, sides)
    except Infeasible as error:
        misfit = _misfit(flat_a.positions[of_a], flat_b.positions[of_b])
        worst = np.argsort(-misfit, kind="stable")[:4]
        named = some([f"{i}-{j}" for i, j in landmarks[worst].tolist()])
        raise Infeasible(
            f"the landmarks cannot be brought together: {error}. Those that fit the others least "
            f"are {named} (vertices of a and b): check whether two are exchanged"
        ) from None


def _misfit(there: Floats, here: Floats) -> Floats:
    """How far each point is from where an affine map of the others takes it: least absolute
    deviations, by reweighted least squares."""
    frame = np.column_stack([there, np.ones(len(there))])
    away = np.ones(len(there))
    for _ in range(20):
        root = 1 / np.sqrt(np.maximum(away, 1e-9))[:, None]
        fit = np.linalg.lstsq(root * frame, root * here, rcond=None)[0]
        away = np.linalg.norm(here - frame @ fit, axis=1)
    return away


def _flowed(
    a: Side, b: Side, flat_a: Flattening, flat_b: Flattening, landmarks: Ints, sides: int
) -> tuple[Flattening, Flattening]:
    of_a, of_b = landmarks.T
    halfway = (flat_a.positions[of_a] + flat_b.positions[of_b]) / 2
    moved_a = flowed(flat_a.positions, a.refined.mesh.faces, of_a, halfway, sides)
    moved_b = flowed(flat_b.positions, b.refined.mesh.faces, of_b, halfway, sides)
    return replace(flat_a, positions=moved_a), replace(flat_b, positions=moved_b)


def _on_one_grid(
    a: Side, b: Side, polygon: Polygon, flat_a: Flattening, flat_b: Flattening
) -> Iterator[CommonPlane]:
    for bits in RESOLUTIONS:
        points_a, points_b = _snap(flat_a.positions, bits), _snap(flat_b.positions, bits)
        folded = len(_folded(a, polygon, 0, points_a, bits))
        if not folded and not len(_folded(b, polygon, 1, points_b, bits)):
            yield CommonPlane(polygon, points_a, points_b, flat_a, flat_b, bits)


def _injective(side: Side, polygon: Polygon, column: int, spread: bool) -> Flattening:
    """The first flattening that turns no triangle over at one of the resolutions."""
    own = polygon.nodes[:, column] >= 0
    boundary = polygon.nodes[own, column]
    positions = polygon_points(polygon.parameter, polygon.sides)[own]
    folded: NDArray[np.integer] = np.empty(0, dtype=np.int32)
    for flat in flattenings(side.refined.mesh, boundary, positions, spread):
        if flat is None or not (np.abs(flat.positions) <= 1).all():
            continue  # rounding, or negative weights, took vertices out of the polygon
        for bits in RESOLUTIONS:
            points = _snap(flat.positions, bits)
            folded = _folded(side, polygon, column, points, bits)
            if not len(folded):
                return flat
    raise no_flattening(side.name, side.refined.face[folded])


def _snap(positions: Floats, bits: int) -> NDArray[np.int64]:
    return np.rint(np.ldexp(positions, bits)).astype(np.int64)


def _folded(
    side: Side, polygon: Polygon, column: int, points: NDArray[np.int64], bits: int
) -> NDArray[np.integer]:
    """Faces not strictly upright, decided exactly, and those that hardly stand out from the
    boundary with the other's vertices inserted."""
    mesh = side.refined.mesh
    faces = not_positive(points, mesh.faces)
    border, face = _border_triangles(mesh, polygon, column)
    nodes = _snap(polygon_points(polygon.parameter, polygon.sides), bits)
    along_border = np.flatnonzero(_heights(np.vstack([points, nodes]), border) < CLEARANCE)
    return np.unique(np.concatenate([faces, face[along_border]]))


def _heights(points: NDArray[np.int64], triangles: Ints) -> Floats:
    """Signed height of each triangle over its first edge, in units of the grid."""
    p, q, r = (points[triangles[:, corner]] for corner in range(3))
    (x, y), (u, v) = (q - p).T.astype(np.float64), (r - p).T.astype(np.float64)
    heights: Floats = (x * v - y * u) / np.maximum(np.hypot(x, y), 1)
    return heights


def _border_triangles(mesh: Mesh, polygon: Polygon, column: int) -> tuple[Ints, Ints]:
    """A triangle on each piece of the boundary, with the apex of the face that it belongs to.

    Boundary nodes are numbered after the mesh's vertices. Also gives the face of each triangle.
    """
    topology = mesh.topology
    leaving = np.full(len(mesh.vertices), -1, dtype=np.int64)
    border = np.flatnonzero(topology.twin < 0)
    leaving[topology.indices[border]] = border
    vertex = polygon.nodes[:, column]
    last = np.maximum.accumulate(np.where(vertex >= 0, np.arange(len(vertex)), 0))
    half_edge = leaving[vertex[last]]
    node = len(mesh.vertices) + np.arange(len(vertex))
    apex = topology.target[topology.next[half_edge]]
    triangles = np.stack([node, np.roll(node, -1), apex], axis=1).astype(np.int32)
    return triangles, topology.face[half_edge]
