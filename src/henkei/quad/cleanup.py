"""The connectivity of a quad mesh made more regular, its topology kept.

Operations, each done only if what comes out is a manifold of the same topology and features stay:
a quad's diagonal is collapsed, which also takes away a vertex between two quads only (a doublet);
the edge between two quads is rotated; a chord, a row of quads from side to opposite side, is
collapsed as a whole. Daniels, Silva, Shepherd, Cohen: Quadrilateral mesh simplification (2008);
Tarini, Pietroni, Cignoni, Panozzo, Puppo: Practical quad mesh simplification (2010).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.mesh import Floats, PolygonMesh
from henkei.quad.editing import HIGHEST, QuadEditor, edges_of, valences, wished_valences
from henkei.quad.homeomorphy import homeomorphic
from henkei.topology import Ints

Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]

_CHANGE = 0.03  # share of the quads that may go


@dataclass(frozen=True, eq=False)
class Cleaned:
    """A quad mesh with fewer irregular vertices.

    vertices : (n, 3)
    quads : (q, 4) int32
    features : (k, 2) int64, the feature edges that were given, and the boundary.
    fixed : (n,) bool
    kept : (n,) int64, index that each vertex had before; of vertices that became one the fixed
        one, else the one on a feature, else any.
    kept_quads : (q,) int64, index that each quad had before.
    doublets, diagonals, rotations, chords : how often each was done.
    """

    vertices: Floats
    quads: Ints
    features: Indices
    fixed: Mask
    kept: Indices
    kept_quads: Indices
    doublets: int = 0
    diagonals: int = 0
    rotations: int = 0
    chords: int = 0


def cleaned(
    vertices: ArrayLike,
    quads: NDArray[np.integer],
    *,
    features: NDArray[np.integer] | None = None,
    fixed: Mask | None = None,
    change: float = _CHANGE,
) -> Cleaned:
    """Collapse and rotate where that leaves fewer irregular vertices.

    Irregular is a vertex whose valence is not 4; on the boundary, not what its angle asks for: 3
    where the boundary goes straight on, 2 at a corner.

    Parameters
    ----------
    vertices : (n, 3), each used.
    quads : (q, 4) counter-clockwise, a manifold.
    features : (k, 2) edges that must stay; the boundary counts in any case.
    fixed : (n,) vertices that must stay where they are.
    change : share of the quads that may go; doublets go in any case.
    """
    start = _given(vertices, quads, features, fixed)
    least = int(np.ceil((1 - change) * len(start.quads)))
    mesh = start
    for _ in range(10):
        before = len(mesh.quads), mesh.rotations
        mesh = _collapsed_chords(_edited(mesh, least), least)
        if (len(mesh.quads), mesh.rotations) == before:
            break
    return mesh


def irregular(vertices: Floats, quads: NDArray[np.integer]) -> Mask:
    """Which vertices (n,) have a valence other than they should; see :func:`cleaned`."""
    valence, _ = valences(quads, len(vertices))
    off: Mask = (valence > 0) & (valence != wished_valences(vertices, quads))
    return off


def _given(
    vertices: ArrayLike,
    quads: NDArray[np.integer],
    features: NDArray[np.integer] | None,
    fixed: Mask | None,
) -> Cleaned:
    points = np.array(vertices, dtype=np.float64)
    faces = np.array(quads, dtype=np.int32).reshape(-1, 4)
    edges, times = edges_of(faces)
    given = np.zeros((0, 2), np.int64) if features is None else np.asarray(features, np.int64)
    lines = np.concatenate([np.sort(given.reshape(-1, 2), axis=1), edges[times == 1]])
    held = np.zeros(len(points), bool) if fixed is None else np.array(fixed, bool)
    numbers = np.arange(len(points)), np.arange(len(faces))
    return Cleaned(points, faces, np.unique(lines, axis=0), held, *numbers)


def _compact(mesh: Cleaned) -> Cleaned:
    """Without the vertices that no quad has."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.quads] = True
    number = np.cumsum(used) - 1
    return replace(
        mesh,
        vertices=mesh.vertices[used],
        quads=number[mesh.quads].astype(np.int32),
        features=number[mesh.features],
        fixed=mesh.fixed[used],
        kept=mesh.kept[used],
    )


def _edited(mesh: Cleaned, least: int) -> Cleaned:
    editor = QuadEditor(mesh.vertices, mesh.quads, mesh.features, mesh.fixed, least)
    editor.clean()
    left = [number for number, quad in enumerate(editor.quads) if quad is not None]
    quads = [editor.quads[number] for number in left]
    return _compact(
        replace(
            mesh,
            vertices=editor.points,
            quads=np.array(quads, dtype=np.int32).reshape(-1, 4),
            kept_quads=mesh.kept_quads[left],
            doublets=mesh.doublets + editor.doublets,
            diagonals=mesh.diagonals + editor.diagonals,
            rotations=mesh.rotations + editor.rotations,
        )
    )


def _collapsed_chords(mesh: Cleaned, least: int) -> Cleaned:
    """Chords are collapsed, best first, as long as each takes irregular vertices away."""
    while True:
        better = None
        for chord in _promising(mesh):
            size = int(chord.quads.sum())
            if len(mesh.quads) - size < least:
                continue
            candidate = _without(mesh, chord)
            if candidate is None:
                continue
            fall = _count(mesh) - _count(candidate)
            if fall > 0:
                better = replace(candidate, chords=mesh.chords + 1)
                break
        if better is None:
            return mesh
        mesh = better


@dataclass(frozen=True, eq=False)
class _Chord:
    """quads : (q,) bool. rungs : (r, 2) edges that are collapsed."""

    quads: Mask
    rungs: Indices


def _count(mesh: Cleaned) -> int:
    return int(irregular(mesh.vertices, mesh.quads).sum())


def _promising(mesh: Cleaned) -> list[_Chord]:
    """Chords in the order of irregular vertices taken away per quad, as far as foreseen."""
    quads, count = mesh.quads, len(mesh.vertices)
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, which = np.unique(np.sort(ends.astype(np.int64), axis=1), axis=0, return_inverse=True)
    side = which.reshape(-1, 4)
    opposite = coo_array(
        (
            np.ones(2 * len(quads), np.int8),
            (side[:, :2].ravel(), side[:, 2:].ravel()),
        ),
        shape=(len(edges), len(edges)),
    )
    chords, of_edge = connected_components(opposite, directed=False)
    valence, rim = valences(quads, count)
    wished = wished_valences(mesh.vertices, quads)
    off = valence - wished
    a, b = edges.T
    both = rim[a] & rim[b]
    after = np.where(rim[a] | rim[b], valence[a] + valence[b] - np.where(both, 3, 4), 0)
    inner = ~(rim[a] | rim[b])
    after = np.where(inner, valence[a] + valence[b] - 4, after)
    goal = np.where(rim[a], wished[a], wished[b])
    fall = (off[a] != 0).astype(float) + (off[b] != 0) - (after != goal)
    gain = np.bincount(of_edge, fall, chords)
    length = np.bincount(of_edge, minlength=chords)
    good = np.flatnonzero(gain > 0)
    found = []
    for chord in good[np.argsort(-gain[good] / length[good], kind="stable")]:
        rung = of_edge == chord
        found.append(_Chord(rung[side].any(axis=1), edges[rung]))
    return found


def _without(mesh: Cleaned, chord: _Chord) -> Cleaned | None:
    """The mesh with a chord collapsed, or None if that does harm."""
    count = len(mesh.vertices)
    graph = coo_array((np.ones(len(chord.rungs), np.int8), chord.rungs.T), shape=(count, count))
    group = connected_components(graph, directed=False)[1]
    rank = np.zeros(count, np.int64)
    rank[mesh.features.ravel()] = 1
    rank[mesh.fixed] = 2
    if (np.bincount(group, rank > 0) > 1).any() or (np.bincount(group) > 4).any():
        return None
    order = np.lexsort((np.arange(count), -rank, group))
    first = order[np.diff(group[order], prepend=-1) > 0]  # of each group: fixed, or lowest
    total = np.stack([np.bincount(group, mesh.vertices[:, i]) for i in range(3)], axis=1)
    middle = total / np.bincount(group)[:, None]
    points = np.where(rank[first][:, None] > 0, mesh.vertices[first], middle)
    quads = group[mesh.quads[~chord.quads]].astype(np.int32)
    made = replace(
        mesh,
        vertices=points,
        quads=quads,
        features=np.unique(np.sort(group[mesh.features], axis=1), axis=0),
        fixed=mesh.fixed[first],
        kept=mesh.kept[first],
        kept_quads=mesh.kept_quads[~chord.quads],
    )
    return _compact(made) if _same_topology(mesh, made) else None


def _same_topology(mesh: Cleaned, made: Cleaned) -> bool:
    if not len(made.quads):
        return False
    before = PolygonMesh(mesh.vertices, mesh.quads).topology
    after = PolygonMesh(made.vertices, made.quads).topology
    valence, rim = valences(made.quads, len(made.vertices))
    old, _ = valences(mesh.quads, len(mesh.vertices))
    used = valence > 0
    return bool(
        homeomorphic(before, after)
        and valence[used].max() <= max(HIGHEST, old.max())
        and valence[used & ~rim].min(initial=4) >= 3
    )
