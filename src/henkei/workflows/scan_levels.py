"""A scan's surface as the levels of a quad cage: refined, put onto the scan and evened out in turn.

Displaced refinement after A. Lee, H. Moreton, H. Hoppe: Displaced subdivision surfaces (2000), with
free points in place of displacements along normals.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.csgraph import connected_components

from henkei.design.refinement import Connectivity, connectivity, refined, refined_positions
from henkei.errors import Infeasible
from henkei.geometry.distance import ClosestPoints, points_on
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, part
from henkei.quad.cage import on_edges
from henkei.quad.facing import facing_places
from henkei.quad.feature_lines import Bound, FeatureLines
from henkei.quad.features import feature_half_edges
from henkei.quad.pipeline import quadrangulate
from henkei.quad.relaxation import quad_normals, relaxed, scaled_jacobians, with_boundary
from henkei.quad.wishes import Wish
from henkei.solve.factor import factor_spd
from henkei.topology import Ints

COUNTS = (250, 500, 1000, 2000)  # quads of cages that are tried in turn where none is said
FARTHEST = 0.04  # of the diagonal: how far such a cage and the scan may be apart
POOR = 0.05  # scaled Jacobian below which a quad is bad
RELAXED = 60_000  # quads of a level up to which they are evened out; finer ones are even by then
RINGS = 10  # around folded quads, up to which the surface may leave the scan to be without folds

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Scan:
    """What quads are put onto.

    lines : (l, 2) edges along creases and boundaries.
    """

    mesh: Mesh
    places: ClosestPoints
    lines: Ints

    @classmethod
    def of(cls, mesh: Mesh, quads: int) -> Scan:
        """A scan on which creases are those that so many quads keep."""
        feature = feature_half_edges(mesh, None, Wish.of(mesh, quads, None, None).sizes)
        ends = np.stack([mesh.indices, mesh.topology.target], axis=1)
        return cls(mesh, ClosestPoints(mesh), ends[feature | (mesh.topology.twin < 0)])


@dataclass(frozen=True, eq=False)
class LaidLevel:
    """The quads of a level on the scan.

    points : (n, 3)
    creased : (e,) edges that keep to creases or boundaries of the scan.
    """

    faces: Connectivity
    points: Floats
    creased: Mask

    @property
    def quads(self) -> Ints:
        """Corners (q, 4)."""
        return self.faces.indices.reshape(-1, 4)

    @property
    def crease_edges(self) -> Ints:
        """Vertices (k, 2) of the creased edges."""
        edges: Ints = self.faces.edges[self.creased]
        return edges

    def folded(self, scan: Scan, off: Mask | None = None) -> Mask:
        """Which quads are folded, or face against the scan where they are on it.

        off : (n,) vertices that are not on it.
        """
        near, _ = scan.places.query(self.points[self.quads].mean(axis=1))
        normals = scan.mesh.face_normals[near.face]
        against = (quad_normals(self.points, self.quads) * normals).sum(axis=1) < 0
        if off is not None:
            against &= ~off[self.quads].any(axis=1)
        folded: Mask = against | (scaled_jacobians(self.points, self.quads) <= 0)
        return folded

    def bad(self, scan: Scan) -> int:
        """How many quads are folded, or so nearly that their children may be."""
        poor = scaled_jacobians(self.points, self.quads) < POOR
        return int(np.count_nonzero(poor | self.folded(scan)))


def first_levels(
    mesh: Mesh, quads: int | None, seed: int, progress: Progress
) -> tuple[Scan, list[LaidLevel]]:
    """A cage on a scan, and its first refinement: the coarsest of those tried that keeps near the
    scan and has no bad quads, else that with fewest.

    Raises
    ------
    Infeasible : there are no such quads; see :func:`henkei.quadrangulate`.
    """
    best: tuple[tuple[int, float], Scan, list[LaidLevel]] | None = None
    failure: Infeasible | None = None
    counts = COUNTS if quads is None else (quads,)
    for number, count in enumerate(counts):
        within = part(progress, number / len(counts), (number + 1) / len(counts))
        try:
            made = quadrangulate(mesh, quads=count, seed=seed, progress=part(within, 0.0, 0.6))
        except Infeasible as error:
            failure = error
            continue
        scan, faces = Scan.of(mesh, count), connectivity(made.mesh)
        creased = np.empty(len(faces.edges), bool)
        creased[faces.corner_edges] = on_edges(faces.indices.reshape(-1, 4), made.features).ravel()
        cage = LaidLevel(faces, made.mesh.vertices, creased)
        finer = next_level(scan, cage, seed, part(within, 0.6, 1.0))
        bad = sum(one.bad(scan) for one in (cage, finer))
        far = max(made.quality.distance_to_input, made.quality.distance_from_input)
        if best is None or (bad, far) < best[0]:
            best = (bad, far), scan, [cage, finer]
        if not bad and far <= FARTHEST:
            break
    if best is None:
        assert failure is not None, "there is always a count"
        raise failure
    return best[1:]


def next_level(scan: Scan, coarse: LaidLevel, seed: int, progress: Progress) -> LaidLevel:
    """The refinement of a level, put onto the scan where it faces the same way."""
    faces = refined(coarse.faces, quads=True)
    inner = np.zeros(len(faces.edges) - 2 * len(coarse.creased), bool)
    creased = np.concatenate([np.repeat(coarse.creased, 2), inner])
    flat = refined_positions(coarse.faces, True, coarse.points)
    level = LaidLevel(faces, flat, creased)
    if faces.face_count > RELAXED:
        return _put(scan, level)
    rest = relaxed(
        flat,
        level.quads,
        scan.mesh,
        features=level.crease_edges,
        feature_lines=scan.lines,
        seed=seed,
        progress=progress,
    )
    return replace(level, points=rest.vertices)


def without_folds(scan: Scan, level: LaidLevel) -> tuple[LaidLevel, Mask]:
    """A level that leaves the scan where its quads are folded there, and the vertices (n,) that do.

    In rings around such quads, as few as will do, vertices come to lie amid their neighbours.
    """
    now, off, folded = level, np.zeros(len(level.points), bool), level.folded(scan)
    held = np.zeros(len(off), bool)
    held[level.crease_edges] = True
    for rings in range(1, RINGS + 1):
        for vertices in _pieces(level, _around(level, folded, rings) & ~held):
            points, left = now.points.copy(), off.copy()
            points[vertices] = _amid_neighbours(level.faces.edges, points, vertices)
            left[vertices] = True
            trial = replace(now, points=points)
            found = trial.folded(scan, left)
            if np.count_nonzero(found) < np.count_nonzero(folded):
                now, off, folded = trial, left, found
    return now, off


def _around(level: LaidLevel, quads: Mask, rings: int) -> Mask:
    """The vertices (n,) of so many rings of quads around some."""
    near = np.zeros(len(level.points), bool)
    for _ in range(rings):
        near[level.quads[quads | near[level.quads].any(axis=1)]] = True
    return near


def _put(scan: Scan, level: LaidLevel) -> LaidLevel:
    """Each vertex at the nearest place that faces the same way, or on its crease."""
    normals = np.zeros_like(level.points)
    np.add.at(normals, level.quads, quad_normals(level.points, level.quads)[:, None])
    places = facing_places(scan.mesh, scan.places, level.points, normals)
    lines = FeatureLines(scan.mesh, scan.lines)
    edges = with_boundary(level.quads, level.crease_edges)
    bound = Bound.of(lines, level.points, edges, np.zeros(len(level.points), bool))
    return replace(level, points=points_on(scan.mesh, lines.put(bound, places)))


def _pieces(level: LaidLevel, free: Mask) -> Iterator[Ints]:
    """Free vertices, those that edges connect together."""
    edges = level.faces.edges[free[level.faces.edges].all(axis=1)]
    shape = (len(free), len(free))
    graph = coo_array((np.ones(len(edges)), tuple(edges.T)), shape=shape)
    label = connected_components(graph, directed=False)[1]
    for one in np.unique(label[free]):
        yield np.flatnonzero(free & (label == one)).astype(np.int32)


def _amid_neighbours(edges: Ints, points: Floats, vertices: Ints) -> Floats:
    """Where vertices (k,) are each the mean of their neighbours, all others staying."""
    number = np.full(len(points), -1)
    number[vertices] = np.arange(len(vertices))
    both = np.concatenate([edges, edges[:, ::-1]])
    row, at = number[both[:, 0]], number[both[:, 1]]
    inner, rim = (row >= 0) & (at >= 0), (row >= 0) & (at < 0)
    size = len(vertices)
    links = coo_array((np.ones(inner.sum()), (row[inner], at[inner])), shape=(size, size))
    degree = np.bincount(row[row >= 0], minlength=size).astype(np.float64)
    pull = np.zeros((size, 3))
    np.add.at(pull, row[rim], points[both[rim, 1]])
    solved: Floats = factor_spd(csc_array(diags_array(degree) - links)).solve(pull)
    return solved
