"""Quad vertices moved along the surface until the quads are as square as their connectivity allows.

Fitting squares to all quads at once, then Newton steps vertex by vertex, then a search where a quad
is still bad, are the compiled kernel ``quad_relaxation``; here is what surrounds it: which vertices
keep to which feature lines, and vertices put to where no quad covers the surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from henkei._kernels import QuadRelaxation
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import ClosestPoints, points_on
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, part, silent
from henkei.quad.facing import facing_places
from henkei.quad.feature_lines import Bound, FeatureLines
from henkei.topology import Ints

Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]

_FIT_EVENNESS = 0.6  # share of the step towards the wished size that a fitted square takes
# Sweeps of Newton steps, power of the distortion, squares (0) or rectangles (1), weight of size.
_SMOOTHING = ((10, 2.0, 0.0, 0.15), (10, 3.0, 0.7, 0.15))
_AROUND_PINS = (6, 3.0, 0.5, 0.15)
_RAW, _BEST, _LAST = range(3)  # states that the kernel keeps
_MENDINGS = 9  # times that the neighbourhood of a bad quad is relaxed anew
_RESTARTS, _RESTART = 2, (4, 4.0, 0.7, 0.05)
_FEW = 0.01  # share of quads that may be bad for another try to be of use
_FLOOR, _SEARCHES = 0.3, 10  # scaled Jacobian that is searched for, and how often
_UNCOVERED = 0.45  # distance from the quads, in edges, from which on a point is uncovered
_COVERINGS, _ATTEMPTS = 4, 3
_PINNED = 0.3  # least scaled Jacobian around a vertex that covers a point


@dataclass(frozen=True, eq=False)
class Relaxed:
    """A quad mesh at rest on a surface.

    vertices : (n, 3) float64.
    on_surface : the same as places on the surface.
    worst : the least scaled Jacobian of all quads; negative where one is turned over.
    turned_over : quads that face against the surface at the point nearest to their centre.
    """

    vertices: Floats
    on_surface: SurfacePoints
    worst: float
    turned_over: Indices


def relaxed(
    vertices: ArrayLike,
    quads: NDArray[np.integer],
    surface: Mesh,
    *,
    features: NDArray[np.integer] | None = None,
    feature_lines: NDArray[np.integer] | None = None,
    fixed: Mask | None = None,
    on_surface: SurfacePoints | None = None,
    sizing: Floats | None = None,
    iterations: int = 15,
    seed: int = 0,
    progress: Progress = silent,
) -> Relaxed:
    """Move the vertices of a quad mesh along the surface that it lies on; no quad is changed.

    Vertices of feature edges keep to their line and their order on it; boundary edges are feature
    edges in any case. Where other than two feature edges meet, the vertex stays.

    Parameters
    ----------
    vertices : (n, 3) on the surface.
    quads : (q, 4), counter-clockwise; a manifold, homeomorphic to the surface.
    features : (k, 2) edges of the quad mesh that lie on feature lines.
    feature_lines : (l, 2) edges of the surface: its creases; its boundary counts in any case.
    fixed : (n,) vertices that stay exactly where they are.
    on_surface : where the vertices are on the surface; by default the nearest places.
    sizing : (m,) relative length of quad edges at each vertex of the surface; even by default.
    iterations : how often squares are fitted to all quads. Where quads are bad in the end, it is
        tried without; nor is the result worse than the quads given.
    seed : for the search where quads are bad.
    """
    points = np.array(vertices, dtype=np.float64)
    corners = np.ascontiguousarray(quads, dtype=np.int32)
    if not len(corners):
        nowhere = SurfacePoints(np.full(len(points), -1, np.int32), np.zeros((len(points), 3)))
        return Relaxed(points, on_surface or nowhere, 1.0, np.zeros(0, np.int64))
    edges = with_boundary(corners, features)
    held = np.zeros(len(points), bool) if fixed is None else np.array(fixed, bool)
    held |= np.bincount(corners.ravel(), minlength=len(points)) == 0
    lines = FeatureLines(surface, _with_rim(surface, feature_lines))
    bound = Bound.of(lines, points, edges, held)
    relaxation = _Relaxation(points, corners, surface, lines, bound, edges, on_surface, sizing)
    best = relaxation.fault()
    relaxation.kernel.save(_RAW)
    relaxation.kernel.save(_BEST)
    for number, squares in enumerate(dict.fromkeys((iterations, 0))):
        relaxation.relax(squares, seed, part(progress, number / 2, (number + 1) / 2))
        fault = relaxation.fault()
        if fault <= best:
            best = fault
            relaxation.kernel.save(_BEST)
        if not 0 < best[0] <= _FEW * len(corners):
            break
    relaxation.kernel.restore(_BEST)
    progress("relaxed", 1.0)
    return relaxation.result()


def scaled_jacobians(vertices: Floats, quads: NDArray[np.integer]) -> Floats:
    """Least scaled Jacobian (q,) of the corners of each quad; 1 for a rectangle.

    Of a corner: sine of its angle, seen along the quad's normal, which its diagonals span.
    """
    corners = vertices[quads]
    normals = quad_normals(vertices, quads)
    sides = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(sides, axis=2)
    crosses = np.cross(sides, -np.roll(sides, 1, axis=1))
    sizes = length * np.roll(length, 1, axis=1) * np.linalg.norm(normals, axis=1)[:, None]
    sines = (normals[:, None] * crosses).sum(axis=2)
    least: Floats = (sines / np.where(sizes > 0, sizes, np.inf)).min(axis=1)
    return least


def quad_normals(vertices: Floats, quads: NDArray[np.integer]) -> Floats:
    """Cross products (q, 3) of the diagonals: normals, twice as long as the areas."""
    a, b, c, d = (vertices[quads[:, k]] for k in range(4))
    normals: Floats = np.cross(c - a, d - b)
    return normals


def split_quads(vertices: Floats, quads: NDArray[np.integer]) -> Ints:
    """Two triangles of each quad, along its shorter diagonal: (2 q, 3)."""
    a, b, c, d = (vertices[quads[:, k]] for k in range(4))
    first = np.linalg.norm(c - a, axis=1) <= np.linalg.norm(d - b, axis=1)
    turned = np.where(first[:, None], quads, np.roll(quads, -1, axis=1))
    halves: Ints = turned[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3).astype(np.int32)
    return halves


def with_boundary(quads: Ints, features: NDArray[np.integer] | None) -> Indices:
    """Feature edges and boundary edges (k, 2) of a quad mesh, each once."""
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, times = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    return _joined(features, edges[times == 1])


def _with_rim(surface: Mesh, lines: NDArray[np.integer] | None) -> Indices:
    rim = surface.topology.twin < 0
    return _joined(lines, np.stack([surface.indices, surface.topology.target], axis=1)[rim])


def _joined(given: NDArray[np.integer] | None, more: NDArray[np.integer]) -> Indices:
    first = np.zeros((0, 2), np.int64) if given is None else np.asarray(given, np.int64)
    edges: Indices = np.concatenate([first.reshape(-1, 2), more.astype(np.int64)])
    once: Indices = np.unique(np.sort(edges, axis=1), axis=0)
    return once


class _Relaxation:
    """The kernel made ready for a quad mesh on a surface, and the covering of the surface."""

    def __init__(
        self,
        vertices: Floats,
        quads: Ints,
        surface: Mesh,
        lines: FeatureLines,
        bound: Bound,
        features: Indices,
        on_surface: SurfacePoints | None,
        sizing: Floats | None,
    ) -> None:
        self.vertices, self.quads, self.surface, self.bound = vertices, quads, surface, bound
        self.edge = np.sqrt(surface.face_areas.sum() / len(quads))
        self.lines = bound.held | (bound.line >= 0)
        self.pinned = self.lines.copy()
        self.failures = np.zeros(len(surface.vertices), np.int64)
        self.on_surface = ClosestPoints(surface)
        order = np.argsort(quads.ravel(), kind="stable")
        self._ring_quads = order // 4
        self._ring_start = np.searchsorted(quads.ravel()[order], np.arange(len(vertices) + 1))
        self._corners = SurfacePoints.of_vertices(surface)
        normals = np.zeros((len(vertices), 3))
        np.add.at(normals, quads, quad_normals(vertices, quads)[:, None])
        normals[bound.held] = 0.0  # they stay, so that only the nearest place is theirs
        places = on_surface or facing_places(surface, self.on_surface, vertices, normals)
        places = lines.put(bound, places)
        points = np.where((bound.line >= 0)[:, None], points_on(surface, places), vertices)
        self.kernel = QuadRelaxation(
            surface.vertices,
            surface.faces,
            lines.blocked_twins(surface, bound),
            lines.start,
            lines.points,
            lines.arc,
            lines.half_edge,
            lines.closed,
            quads,
            places.face,
            places.barycentric,
            points,
            bound.held.astype(np.uint8),
            bound.line,
            bound.arc,
            bound.beside,
            bound.limits,
            self._sizes(points, places, sizing),
            self._centres(points, places, features),
        )

    def _centres(self, points: Floats, places: SurfacePoints, features: Indices) -> Ints:
        """A face of the surface near each quad's centre, on its side of all feature lines."""
        free = np.ones(len(points), bool)
        free[features.ravel()] = False
        vertex = self.quads[np.arange(len(self.quads)), free[self.quads].argmax(axis=1)]
        face: Ints = places.face[vertex].astype(np.int32)
        bare = np.flatnonzero(~free[vertex])
        face[bare] = self.on_surface.query(points[self.quads[bare]].mean(axis=1))[0].face
        return face

    def _sizes(self, points: Floats, places: SurfacePoints, sizing: Floats | None) -> Floats:
        if sizing is None:
            area = np.linalg.norm(quad_normals(points, self.quads), axis=1).sum() / 2
            return np.full(len(points), np.sqrt(area / len(self.quads)))
        wished = places.pull(self.surface, np.asarray(sizing, np.float64))
        start, end = self.quads.ravel(), np.roll(self.quads, -1, axis=1).ravel()
        length = np.linalg.norm(points[end] - points[start], axis=1)
        scale: float = length.sum() / wished[start].sum()
        return wished * scale

    def relax(self, iterations: int, seed: int, progress: Progress) -> None:
        """From the quads given to quads at rest."""
        self.failures[:] = 0
        self.kernel.restore(_RAW)
        self.pinned = self.lines.copy()
        progress("evening out the quads", 0.0)
        self.smooth(iterations)
        lost = self.uncovered()
        if len(lost):
            self.kernel.restore(_RAW)
            self.hold(lost)
            self.smooth(iterations)
        progress("searching", 0.4)
        self.untangle(seed)
        for number in range(_COVERINGS):
            progress("covering the surface", 0.6 + 0.3 * number / _COVERINGS)
            if not self.cover():
                break
        self.untangle(seed)
        if 0 < self.fault()[0] <= _FEW * len(self.quads):
            self.kernel.mend(_MENDINGS, seed)

    def smooth(self, iterations: int) -> None:
        """Squares fitted, then Newton steps."""
        self.kernel.fit(iterations, _FIT_EVENNESS)
        for smoothing in _SMOOTHING:
            self.kernel.improve(*smoothing)

    def fault(self) -> tuple[int, float]:
        """How many quads are bad, and how far the worst one is from fair."""
        quality = self.kernel.quality()
        return int(np.count_nonzero(quality <= 0)), max(0.0, _FLOOR - float(quality.min()))

    def uncovered(self) -> Indices:
        """Vertices of the surface that are far from all quads, farthest first."""
        points, _, _ = self.kernel.result()
        quads = Mesh(points, split_quads(points, self.quads))
        distance = ClosestPoints(quads).query(self.surface.vertices)[1]
        far = np.flatnonzero((distance > _UNCOVERED * self.edge) & (self.failures < 2))
        farthest: Indices = far[np.argsort(-distance[far], kind="stable")]
        return farthest

    def hold(self, goals: Indices) -> None:
        """Pins the nearest vertices to vertices of the surface."""
        owner = self._owners()[2]
        taken = self.pinned.copy()
        chosen = []
        for goal in goals.tolist():
            vertex = owner[goal]
            if vertex >= 0 and not taken[vertex]:
                chosen.append((vertex, goal))
                taken[self.quads[self._quads_at(self._near(vertex))]] = True
        if chosen:
            vertices, ends = np.ascontiguousarray(np.array(chosen, np.int32).T)
            at = self._corners.taken(ends)
            self.kernel.pin(vertices, at.face, at.barycentric)
            self.pinned[vertices] = True

    def untangle(self, seed: int) -> None:
        """Searches until no quad is inverted or turned over; smooths in between."""
        self.kernel.untangle(_SEARCHES, _FLOOR, seed)
        bad = np.count_nonzero(self.kernel.quality() <= 0)
        for again in range(_RESTARTS):
            if not 0 < bad <= _FEW * len(self.quads):
                return
            self.kernel.save(_LAST)
            self.kernel.improve(*_RESTART)
            self.kernel.untangle(_SEARCHES, _FLOOR, seed + 1 + again)
            now = np.count_nonzero(self.kernel.quality() <= 0)
            if now > bad:
                self.kernel.restore(_LAST)
            bad = min(now, bad)

    def cover(self) -> bool:
        """Pins vertices to vertices of the surface that are far from all quads, where the quads
        around allow it; whether some were tried."""
        far = self.uncovered()
        if not len(far):
            return False
        path, before, owner = self._owners()
        taken = self.pinned.copy()
        chosen = []
        for goal in far.tolist():
            vertex = owner[goal]
            if vertex < 0 or taken[vertex]:
                continue
            half, end = path[goal] / 2, goal
            while self.failures[goal] and path[end] > half and before[end] < len(path):
                end = before[end]
            chosen.append((vertex, goal, end))
            taken[self.quads[self._quads_at(self._near(vertex))]] = True
        self._pin(np.array(chosen, np.int32).reshape(-1, 3))
        return bool(chosen)

    def _owners(self) -> tuple[Floats, Ints, Ints]:
        """Of each vertex of the surface: length of the way, along edges, from the nearest vertex
        of the quads; the vertex before it on that way; that vertex of the quads, or -1."""
        points, face, _ = self.kernel.result()
        surface, count = self.surface, len(self.surface.vertices)
        edges = surface.topology.edges
        start = np.concatenate([edges[:, 0], count + np.repeat(np.arange(len(points)), 3)])
        end = np.concatenate([edges[:, 1], surface.faces[face].ravel()])
        at = np.concatenate([surface.vertices, points])
        length = np.linalg.norm(at[end] - at[start], axis=1) + 1e-9 * self.edge
        size = count + len(points)
        path, before, source = dijkstra(
            coo_array((length, (start, end)), shape=(size, size)).tocsr(),
            directed=False,
            indices=np.arange(count, size),
            min_only=True,
            return_predecessors=True,
        )
        return path[:count], before[:count], np.maximum(source[:count] - count, -1)

    def _pin(self, chosen: Ints) -> None:
        """chosen : (k, 3) vertex, the vertex of the surface to cover, and the one to go to."""
        places = self._corners
        self.kernel.save(_LAST)
        for _ in range(_ATTEMPTS):
            if not len(chosen):
                return
            vertices, goals, ends = np.ascontiguousarray(chosen.T)
            self.kernel.pin(vertices, places.face[ends], places.barycentric[ends])
            self.kernel.improve(*_AROUND_PINS)
            quality = self.kernel.quality()
            around = [quality[self._quads_at(self._near(v))].min(initial=1) for v in vertices]
            good = np.array(around) > _PINNED
            self.failures[goals[~good]] += 1
            if good.all():
                self.pinned[vertices] = True
                return
            self.kernel.restore(_LAST)
            chosen = chosen[good]

    def _quads_at(self, vertices: Indices) -> Indices:
        """Quads that have one of the vertices."""
        rows = [self._ring_quads[self._ring_start[v] : self._ring_start[v + 1]] for v in vertices]
        return np.unique(np.concatenate(rows))

    def _near(self, vertex: int) -> Indices:
        """Vertices of the quads at a vertex."""
        return np.unique(self.quads[self._quads_at(np.array([vertex]))])

    def result(self) -> Relaxed:
        points, face, weights = self.kernel.result()
        worst = float(scaled_jacobians(points, self.quads).min())
        near, _ = self.on_surface.query(points[self.quads].mean(axis=1))
        normals = quad_normals(points, self.quads)
        against = (normals * self.surface.face_normals[near.face]).sum(axis=1) < 0
        return Relaxed(points, SurfacePoints(face, weights), worst, np.flatnonzero(against))
