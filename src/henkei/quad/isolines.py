"""The quads of mapped patches: vertices where integer isolines cross, glued along the arcs.

Okabe and Sugihara (2009), step 7 (their "temperature contours"). Which vertices and quads there are
follows from the lengths of the arcs alone; the maps only say where on the surface they lie.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.errors import Infeasible, some
from henkei.geometry.correspondence import SurfacePoints
from henkei.mesh import Floats, Mesh, PolygonMesh
from henkei.quad.domains import shares
from henkei.quad.lengths import Lengths
from henkei.quad.location import located
from henkei.quad.metamesh import Indices, MetaMesh, ragged
from henkei.quad.patch_maps import PatchMaps
from henkei.topology import Ints


class TooFew(Infeasible):
    """Quads of these patches have no room to be apart.

    patches : those around the places where quads touch themselves or each other.
    """

    def __init__(self, message: str, patches: Ints) -> None:
        super().__init__(message)
        self.patches = patches


@dataclass(frozen=True, eq=False)
class RawQuads:
    """Quads as they come from the maps.

    vertices : (n, 3)
    faces : (q, 4) counter-clockwise like the surface.
    patch : (q,) patch of each quad.
    uv : (q, 4, 2) corners of each quad in the domain of its patch.
    on_mesh : place of each vertex on the mesh of the maps.
    node : (n,) node of the meta-mesh at a vertex, -1 where there is none; of nodes that an arc of
        length zero joins, the one at which most arcs end, features first.
    arc : (n,) arc inside of which a vertex lies, -1 where none.
    feature : (k, 2) vertices of the edges along features.
    """

    vertices: Floats
    faces: Ints
    patch: Ints
    uv: Floats
    on_mesh: SurfacePoints
    node: Ints
    arc: Ints
    feature: Ints

    @cached_property
    def mesh(self) -> PolygonMesh:
        """The quads as a mesh."""
        return PolygonMesh(self.vertices, self.faces)


def quads_of(maps: PatchMaps, lengths: Lengths) -> RawQuads:
    """The quads of all patches.

    Vertices on arcs are spaced equally by wished length; those of rectangles lie at integer
    coordinates, those of other polygons on the bilinear grids of their blocks.

    Raises
    ------
    Infeasible : the quads do not have the topology of the surface, since arcs are too short to keep
        edges apart; :class:`TooFew` where this can be seen at some patches.
    """
    meta, mesh = maps.meta, maps.mesh
    skeleton = _Skeleton.of(meta, lengths)
    tiles = _tiles(maps, lengths, skeleton)
    inner = located(maps.uv, meta.face_patch, tiles.points, tiles.point_patch)
    places = [SurfacePoints.of_vertices(mesh).taken(meta.nodes[skeleton.nodes])]
    places += [_on_arcs(meta, lengths.arcs), inner]
    on_mesh = SurfacePoints(
        np.concatenate([place.face for place in places]),
        np.concatenate([place.barycentric for place in places]),
    )
    node, arc = (np.full(len(on_mesh), -1, dtype=np.int32) for _ in range(2))
    node[: len(skeleton.nodes)] = skeleton.nodes
    arc[len(skeleton.nodes) : skeleton.count] = ragged(np.maximum(lengths.arcs - 1, 0))[0]
    quads = RawQuads(
        vertices=on_mesh.pull(mesh, mesh.vertices),
        faces=tiles.faces,
        patch=tiles.patch,
        uv=tiles.uv,
        on_mesh=on_mesh,
        node=node,
        arc=arc,
        feature=skeleton.edges(np.flatnonzero(meta.arc_feature)),
    )
    quads = _without_folded(quads)
    _check_topology(mesh, quads)
    return quads


def _without_folded(quads: RawQuads) -> RawQuads:
    """Without quads folded on themselves around a vertex that no other quad has.

    They stand where a patch has a corner at a node of no other patch; their neighbours meet.
    """
    while True:
        a, b, c, d = quads.faces.T
        once = (a != b) & (b != c) & (c != d) & (d != a)
        kept = ~(once & ((a == c) != (b == d)))
        if kept.all():
            return quads
        used = np.zeros(len(quads.vertices), dtype=bool)
        used[quads.faces[kept]] = True
        number = np.cumsum(used) - 1
        whole = used[quads.feature].all(axis=1)
        quads = RawQuads(
            vertices=quads.vertices[used],
            faces=number[quads.faces[kept]].astype(np.int32),
            patch=quads.patch[kept],
            uv=quads.uv[kept],
            on_mesh=quads.on_mesh.taken(used),
            node=quads.node[used],
            arc=quads.arc[used],
            feature=number[quads.feature[whole]].astype(np.int32),
        )


@dataclass(frozen=True, eq=False)
class _Skeleton:
    """The vertices of the quads on nodes and arcs.

    nodes : node of each of the first vertices.
    vertex : (k,) vertex of each node.
    arcs : (a, 2) node at the start and at the end of each arc.
    length : (a,) number of quad edges.
    first : (a,) first vertex inside of each arc.
    count : how many vertices.
    """

    nodes: Indices
    vertex: Indices
    arcs: Ints
    length: Indices
    first: Indices
    count: int

    @classmethod
    def of(cls, meta: MetaMesh, lengths: Lengths) -> _Skeleton:
        nodes, vertex = _joined_nodes(meta, lengths.arcs)
        inside = np.maximum(lengths.arcs - 1, 0)
        first = len(nodes) + np.cumsum(inside) - inside
        count = len(nodes) + int(inside.sum())
        return cls(nodes, vertex, meta.arc_nodes, lengths.arcs, first, count)

    def steps(
        self, arcs: NDArray[np.integer], forward: NDArray[np.bool_]
    ) -> tuple[Indices, Indices]:
        """Vertices where the quad edges along arcs begin; first which of the arcs each is of."""
        length = self.length[arcs]
        entry, step = ragged(length)
        forward, arc = forward[entry], arcs[entry]
        start = self.vertex[self.arcs[arc, np.where(forward, 0, 1)]]
        inside = self.first[arc] + np.where(forward, step, length[entry] - step) - 1
        return entry, np.where(step == 0, start, inside)

    def edges(self, arcs: NDArray[np.integer]) -> Ints:
        """Quad edges (k, 2) along arcs."""
        entry, start = self.steps(arcs, np.ones(len(arcs), dtype=bool))
        end = np.roll(start, -1)
        last = np.flatnonzero(np.diff(entry, append=-1))
        end[last] = self.vertex[self.arcs[arcs[entry[last]], 1]]
        return np.stack([start, end], axis=1).astype(np.int32)


def _joined_nodes(meta: MetaMesh, length: Indices) -> tuple[Indices, Indices]:
    """Nodes that arcs of length zero do not join, one for each group that they do; and the place in
    that list of every node's group."""
    count = len(meta.nodes)
    ends = meta.arc_nodes[length == 0].T
    links = coo_array((np.ones(ends.shape[1], dtype=np.int8), tuple(ends)), shape=(count, count))
    group = connected_components(links, directed=False)[1]
    features = np.bincount(meta.arc_nodes[meta.arc_feature].ravel(), minlength=count)
    arcs = np.bincount(meta.arc_nodes.ravel(), minlength=count)
    order = np.lexsort((np.arange(count), -arcs, -features, group))
    return order[np.flatnonzero(np.diff(group[order], prepend=-1))], group.astype(np.int64)


def _on_arcs(meta: MetaMesh, length: Indices) -> SurfacePoints:
    """Places of the vertices inside of arcs, at equal steps of wished length."""
    of, _ = ragged(np.diff(meta.arc_start))
    steps = shares(meta.layout.length[meta.arc_half_edges], of)
    reach = np.cumsum(steps)  # rises by one along every arc
    arc, step = ragged(np.maximum(length - 1, 0))
    target = arc + (step + 1) / length[arc]
    at = np.searchsorted(reach, target)
    at = np.clip(at, meta.arc_start[arc], meta.arc_start[arc + 1] - 1)
    share = np.clip(1 - (reach[at] - target) / steps[at], 0, 1)
    face, corner = np.divmod(meta.arc_half_edges[at], 3)
    weights = np.zeros((len(face), 3))
    row = np.arange(len(face))
    weights[row, corner] = 1 - share
    weights[row, (corner + 1) % 3] = share
    return SurfacePoints(face, weights)


@dataclass(frozen=True, eq=False)
class _Tiles:
    """Quads of all patches, and the vertices inside of patches in their domains."""

    faces: Ints
    patch: Ints
    uv: Floats
    points: Floats
    point_patch: Ints


def _tiles(maps: PatchMaps, lengths: Lengths, skeleton: _Skeleton) -> _Tiles:
    domains, sides = maps.domains, maps.domains.sides
    entry, rim = skeleton.steps(sides.arc, sides.forward)
    start = np.searchsorted(sides.patch[entry], np.arange(maps.meta.patch_count + 1))
    pieces = []
    count = skeleton.count
    for patch in range(maps.meta.patch_count):
        own = slice(*sides.side_start[patch : patch + 2].tolist())
        ring = rim[start[patch] : start[patch + 1]]
        spokes = lengths.spokes[slice(*lengths.spoke_start[patch : patch + 2].tolist())]
        if len(spokes):
            piece = _polygon(ring, spokes, domains.corners[own], count)
        else:
            n, k = domains.length[own][:2].tolist()
            piece = _rectangle(ring, n, k, count)
        count += len(piece.points)
        pieces.append(piece)
    return _Tiles(
        faces=np.concatenate([piece.faces for piece in pieces]).astype(np.int32),
        patch=np.repeat(np.arange(len(pieces)), [len(p.faces) for p in pieces]).astype(np.int32),
        uv=np.concatenate([piece.uv for piece in pieces]),
        points=np.concatenate([piece.points for piece in pieces]),
        point_patch=np.repeat(np.arange(len(pieces)), [len(p.points) for p in pieces]).astype(
            np.int32
        ),
    )


@dataclass(frozen=True, eq=False)
class _Piece:
    """Quads of one patch and its inner vertices."""

    faces: Indices
    uv: Floats
    points: Floats


def _rectangle(ring: Indices, n: int, k: int, first: int) -> _Piece:
    """Quads at integer coordinates of [0, n] x [0, k]; ``first`` is the first inner vertex."""
    grid = np.empty((n + 1, k + 1), dtype=np.int64)
    ring = np.append(ring, ring[0])
    grid[:, 0] = ring[: n + 1]
    grid[n] = ring[n : n + k + 1]
    grid[::-1, k] = ring[n + k : 2 * n + k + 1]
    grid[0, ::-1] = ring[2 * n + k :]
    grid[1:n, 1:k] = first + np.arange((n - 1) * (k - 1)).reshape(n - 1, k - 1)
    uv = np.indices(grid.shape).transpose(1, 2, 0).astype(np.float64)
    return _Piece(_cells(grid), _cells(uv), uv[1:n, 1:k].reshape(-1, 2))


def _polygon(ring: Indices, spokes: Indices, corners: Floats, first: int) -> _Piece:
    """Quads of one block per corner, between the spokes (m,) from the middle to the sides."""
    m = len(spokes)
    previous, following = np.roll(spokes, 1), np.roll(spokes, -1)
    starts = np.cumsum(previous + following) - previous - following
    share = previous / (previous + following)
    ends = corners + share[:, None] * (np.roll(corners, -1, axis=0) - corners)
    centre = _centre(corners, spokes)
    points, count = [centre[None]], first + 1
    inner: list[Indices] = []  # vertices along each spoke, from its side to the centre
    for i in range(m):
        between = count + np.arange(spokes[i] - 1)
        inner.append(np.concatenate([[ring[starts[i] + previous[i]]], between, [first]]))
        part = np.arange(1, spokes[i])[:, None] / spokes[i]
        points.append(ends[i] + part * (centre - ends[i]))
        count += len(between)
    faces, uv = [], []
    for i in range(m):
        n, k = int(spokes[i - 1]), int(spokes[i])
        grid = np.empty((n + 1, k + 1), dtype=np.int64)
        grid[:, 0] = ring[starts[i] + np.arange(n + 1)]
        grid[0] = ring[(starts[i] - np.arange(k + 1)) % len(ring)]
        grid[n] = inner[i]
        grid[:, k] = inner[i - 1]
        grid[1:n, 1:k] = count + np.arange((n - 1) * (k - 1)).reshape(n - 1, k - 1)
        x, y = np.arange(n + 1)[:, None, None] / n, np.arange(k + 1)[:, None] / k
        low = corners[i] + x * (ends[i] - corners[i])
        high = ends[i - 1] + x * (centre - ends[i - 1])
        flat = low + y * (high - low)
        count += (n - 1) * (k - 1)
        faces.append(_cells(grid))
        uv.append(_cells(flat))
        points.append(flat[1:n, 1:k].reshape(-1, 2))
    return _Piece(np.concatenate(faces), np.concatenate(uv), np.concatenate(points))


def _centre(corners: Floats, spokes: Indices) -> Floats:
    """Where the spokes meet: about as far from each side as its spoke is long.

    By E. Wachspress' coordinates of a point at these distances from the sides.
    """
    weights = 1 / (spokes * np.roll(spokes, 1))
    centre: Floats = weights @ corners / weights.sum()
    return centre


def _cells(grid: NDArray[np.generic]) -> NDArray:  # type: ignore[type-arg]
    """The four corners of each cell of a grid (n + 1, k + 1, ...), counter-clockwise."""
    corners = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2)
    return corners.reshape(-1, *corners.shape[2:])


def _check_topology(mesh: Mesh, quads: RawQuads) -> None:
    """Refuse quads that do not make a manifold surface like that of the mesh."""
    made, given = quads.mesh.topology, mesh.topology
    faults = {
        "quads that repeat a vertex": made.degenerate_faces,
        "edges with too many quads": made.nonmanifold_edges,
        "vertices where parts of the surface touch": made.nonmanifold_vertices,
        "edges with quads wound against each other": made.misoriented_edges,
    }
    found = [f"{name}: {some(places.tolist())}" for name, places in faults.items() if len(places)]
    if found:
        touched = [quads.faces[made.degenerate_faces], made.nonmanifold_edges]
        touched += [made.misoriented_edges, made.nonmanifold_vertices]
        vertices = np.concatenate([np.ravel(some_touched) for some_touched in touched])
        around = np.isin(quads.faces, vertices).any(axis=1)
        raise TooFew(
            f"the quads are not a surface like the input's ({'; '.join(found)}): the arcs there "
            "are too short to keep vertices apart; ask for more quads",
            np.unique(quads.patch[around]),
        )
    figures = {
        "Euler number": (made.euler_characteristic, given.euler_characteristic),
        "number of boundary loops": (len(made.boundary_loops), len(given.boundary_loops)),
        "number of components": (made.component_count, given.component_count),
    }
    for name, (now, wanted) in figures.items():
        if now != wanted:
            raise Infeasible(
                f"the {name} of the quads is {now}, but {wanted} on the surface: some arcs are "
                "too short to keep its parts distinct; ask for more quads"
            )
