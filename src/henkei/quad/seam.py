"""The seam of a half surface, along which its mirror image is joined on, and quads fit for that."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from henkei.errors import Infeasible, some
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import ClosestPoints, points_on
from henkei.mesh import Floats, Mesh, PolygonMesh
from henkei.quad.cleanup import Cleaned
from henkei.quad.isolines import RawQuads
from henkei.topology import Ints

Mask = NDArray[np.bool_]

_NONE = np.empty((0, 2), dtype=np.int32)


@dataclass(frozen=True, eq=False)
class Seam:
    """Where a surface is cut.

    mesh : the surface, open along the cut.
    cut : (3 m,) bool, boundary half-edges on the cut; other boundaries may join on to them.
    """

    mesh: Mesh
    cut: Mask

    def edges(self, vertices: Floats, faces: Ints) -> Ints:
        """The edges (k, 2) on the seam of another mesh of the same surface, as they run round it.

        Boundary loops are matched by where seam and other boundary meet on them: the nearest
        vertices, in order.

        Raises
        ------
        Infeasible : two such places have the same vertex.
        """
        if not self.cut.any():
            return _NONE
        loops = PolygonMesh(vertices, faces).topology.boundary_loops
        state = self._states(vertices, np.concatenate(loops))
        found = []
        for loop in loops:
            known = np.flatnonzero(state[loop] >= 0)
            if len(known):
                last = known[np.searchsorted(known, np.arange(len(loop)), side="right") - 1]
                on_seam = state[loop[last]] == 1
            else:
                on_seam = np.full(len(loop), self._is_seam(vertices[loop]))
            found.append(np.stack([loop, np.roll(loop, -1)], axis=1)[on_seam])
        return np.concatenate(found).astype(np.int32)

    def _states(self, vertices: Floats, border: Ints) -> Ints:
        """At each vertex where a boundary changes, 1 where the seam begins, 0 where it ends; -1 at
        all others."""
        state = np.full(len(vertices), -1)
        ends, begins = self._ends
        if not len(ends):
            return state
        nearest = border[cKDTree(vertices[border]).query(self.mesh.vertices[ends])[1]]
        different, times = np.unique(nearest, return_counts=True)
        if len(different) < len(nearest):
            places = vertices[different[times > 1]].round(6).tolist()
            raise Infeasible(
                "the quads are too large to keep parts of the boundary in the plane of symmetry "
                f"apart, at {some([tuple(p) for p in places], 3)}; ask for more quads"
            )
        state[nearest] = begins
        return state

    @cached_property
    def _ends(self) -> tuple[Ints, Mask]:
        """Vertices where seam and other boundary meet, and whether the seam begins there."""
        border = np.flatnonzero(self.mesh.topology.twin < 0)
        start, end = self.mesh.indices[border], self.mesh.topology.target[border]
        arriving = np.zeros(len(self.mesh.vertices), dtype=bool)
        arriving[end] = self.cut[border]
        changes = arriving[start] != self.cut[border]
        return start[changes], self.cut[border][changes]

    def _is_seam(self, points: Floats) -> bool:
        """Whether a loop without such vertices is a seam: what it is nearest to as a whole."""
        to_seam, to_rim = (
            lines.query(points)[1].max() if lines is not None else np.inf for lines in self._lines
        )
        return bool(to_seam < to_rim)

    @cached_property
    def _lines(self) -> list[ClosestPoints | None]:
        """The seam, and the other boundaries."""
        topology = self.mesh.topology
        lines = []
        for rows in (self.cut, (topology.twin < 0) & ~self.cut):
            ends = np.stack([self.mesh.indices[rows], topology.target[rows]], axis=1)
            segments = Mesh(self.mesh.vertices, ends[:, [0, 1, 1]])
            lines.append(ClosestPoints(segments) if len(ends) else None)
        return lines

    def mended(self, raw: RawQuads, clean: Cleaned, mesh: Mesh) -> tuple[RawQuads, Cleaned]:
        """Quads split where they could not be joined to their mirror image, or not well.

        Other edges from seam to seam would have four quads: the rows of quads they cross are split
        lengthwise. A vertex with one quad between two edges of the seam would have two: then all
        quads along the seam are split into a row beside it and one behind.

        raw, clean : quads, and what clean-up made of them; likewise returned.
        mesh : that the quads lie on, see :attr:`RawQuads.on_mesh`.
        """
        if not self.cut.any():
            return raw, clean
        now = _as_cleaned(raw, clean)
        table = _Edges.of(now.faces)
        seam, on_seam, _ = self._on(now, table)
        across = on_seam[table.ends].all(axis=1) & ~seam
        if across.any():
            now = _split(now, table, table.rows(across), mesh)
            table = _Edges.of(now.faces)
        _, on_seam, inside = self._on(now, table)
        if (inside & (np.bincount(now.faces.ravel(), minlength=len(inside)) == 1)).any():
            now = _split(now, table, on_seam[table.ends].sum(axis=1) == 1, mesh)
        fixed = np.zeros(len(now.vertices), dtype=bool)
        fixed[: len(clean.fixed)] = clean.fixed
        return now, replace(
            clean,
            vertices=now.vertices,
            quads=now.faces,
            features=now.feature.astype(np.int64),
            fixed=fixed,
            kept=np.arange(len(now.vertices)),
            kept_quads=np.arange(len(now.faces)),
        )

    def _on(self, raw: RawQuads, table: _Edges) -> tuple[Mask, Mask, Mask]:
        """Which edges are on the seam, which vertices, and which of these inside of it."""
        edges = self.edges(raw.vertices, raw.faces)
        around = np.bincount(edges.ravel(), minlength=len(raw.vertices))
        return table.marked(edges), around > 0, around == 2


@dataclass(frozen=True, eq=False)
class _Edges:
    """Edges of quads: their ends (e, 2), the lower first, and those of each quad (q, 4)."""

    ends: Ints
    of_quad: Ints

    @classmethod
    def of(cls, quads: Ints) -> _Edges:
        sides = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2), axis=2)
        ends, number = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
        return cls(ends, number.reshape(-1, 4).astype(np.int32))

    def marked(self, edges: Ints) -> Mask:
        """Which edges are among those given (k, 2)."""
        size = int(self.ends.max()) + 1
        wanted = np.sort(edges, axis=1).astype(np.int64) @ [size, 1]
        return np.isin(self.ends.astype(np.int64) @ [size, 1], wanted)

    def rows(self, edges: Mask) -> Mask:
        """The edges opposite to these in their quads, those opposite to them, and so on."""
        start, end = self.of_quad[:, :2].ravel(), self.of_quad[:, 2:].ravel()
        count = len(edges)
        links = coo_array((np.ones(len(start), np.int8), (start, end)), shape=(count, count))
        row = connected_components(links, directed=False)[1]
        return np.isin(row, row[edges])


def _as_cleaned(raw: RawQuads, clean: Cleaned) -> RawQuads:
    return replace(
        raw,
        vertices=clean.vertices,
        faces=clean.quads,
        patch=raw.patch[clean.kept_quads],
        uv=raw.uv[clean.kept_quads],
        on_mesh=raw.on_mesh.taken(clean.kept),
        node=raw.node[clean.kept],
        arc=raw.arc[clean.kept],
        feature=clean.features.astype(np.int32),
    )


def _split(raw: RawQuads, table: _Edges, marked: Mask, mesh: Mesh) -> RawQuads:
    """Quads split at the middles of marked edges: of each quad none, two or all four.

    Quads with two opposite ones become two, those with two at a corner three, with all four.
    """
    count = len(raw.vertices)
    middle = np.where(marked, count + np.cumsum(marked) - 1, -1)
    on_quad = marked[table.of_quad]
    sides = on_quad.sum(axis=1)
    opposite = (sides == 2) & (on_quad[:, 0] == on_quad[:, 2])
    adjacent = (sides == 2) & ~opposite
    centred = adjacent | (sides == 4)
    centre = count + marked.sum() + np.cumsum(centred) - 1
    ends = raw.vertices[table.ends[marked]].mean(axis=1)
    centres = raw.vertices[raw.faces[centred]].mean(axis=1)
    places, _ = ClosestPoints(mesh).query(np.concatenate([ends, centres]))
    # Corners 0 to 3, middles of sides 4 to 7, centre 8; counted from `first`.
    corners = np.concatenate([raw.faces, middle[table.of_quad], centre[:, None]], axis=1)
    uv = np.concatenate(
        [
            raw.uv,
            (raw.uv + np.roll(raw.uv, -1, axis=1)) / 2,
            raw.uv.mean(axis=1, keepdims=True),
        ],
        axis=1,
    )
    both = on_quad & np.roll(on_quad, 1, axis=1)
    pieces = [
        (np.flatnonzero(sides == 0), 0, [[0, 1, 2, 3]]),
        (np.flatnonzero(opposite), on_quad.argmax(axis=1), [[0, 4, 6, 3], [4, 1, 2, 6]]),
        (
            np.flatnonzero(adjacent),
            both.argmax(axis=1),
            [[0, 4, 8, 7], [4, 1, 2, 8], [8, 2, 3, 7]],
        ),
        (
            np.flatnonzero(sides == 4),
            0,
            [[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]],
        ),
    ]
    quads, parent, corner_uv = [], [], []
    for rows, first, template in pieces:
        turn = np.broadcast_to(first, len(sides))[rows, None]
        ring = (turn + np.arange(4)) % 4
        local = np.concatenate([ring, 4 + ring, np.full((len(rows), 1), 8)], axis=1)
        for piece in template:
            pick = local[:, piece]
            quads.append(np.take_along_axis(corners[rows], pick, axis=1))
            corner_uv.append(np.take_along_axis(uv[rows], pick[:, :, None], axis=1))
            parent.append(rows)
    order = np.argsort(np.concatenate(parent), kind="stable")
    nowhere = np.full(len(places), -1, dtype=np.int32)
    return replace(
        raw,
        vertices=np.concatenate([raw.vertices, points_on(mesh, places)]),
        faces=np.concatenate(quads)[order].astype(np.int32),
        patch=raw.patch[np.concatenate(parent)[order]],
        uv=np.concatenate(corner_uv)[order],
        on_mesh=SurfacePoints(
            np.concatenate([raw.on_mesh.face, places.face]).astype(np.int32),
            np.concatenate([raw.on_mesh.barycentric, places.barycentric]),
        ),
        node=np.concatenate([raw.node, nowhere]),
        arc=np.concatenate([raw.arc, nowhere]),
        feature=_halved(raw.feature, table, marked, middle),
    )


def _halved(lines: Ints, table: _Edges, marked: Mask, middle: Ints) -> Ints:
    """Edges (k, 2), those that are split as two."""
    of = np.flatnonzero(table.marked(lines))
    whole, split = of[~marked[of]], of[marked[of]]
    ends, between = table.ends[split], middle[split]
    halves = [np.stack([end, between], axis=1) for end in ends.T]
    return np.concatenate([table.ends[whole], *halves]).astype(np.int32)
