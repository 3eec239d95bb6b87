"""Multiresolution filtering of subdivision surfaces, by dense matrices and loops over vertices.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000). Only
the numbering of vertices is taken from the package. Also cages of all kinds, made by code.
"""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np

from henkei import shapes
from henkei.design.refinement import Connectivity, connectivity, refined
from henkei.mesh import Mesh, PolygonMesh, Surface
from topologies import TOPOLOGIES, grid, torus, uneven_hull

TAUBIN = 0.33, 1 / (0.1 - 1 / 0.33)  # p and q


# cages


def polygons(vertices, faces: list[list[int]]) -> PolygonMesh:
    offsets = np.cumsum([0, *map(len, faces)])
    return PolygonMesh(np.array(vertices, dtype=float), (np.concatenate(faces), offsets))


def prism(sides: int, height: float = 1.0, lid: bool = True) -> PolygonMesh:
    """Two n-gons and n quads between them; open at the top without its lid."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    points = [np.column_stack([ring, np.full(sides, z)]) for z in (0.0, height)]
    bottom = [list(range(sides))[::-1]]
    walls = [[i, (i + 1) % sides, (i + 1) % sides + sides, i + sides] for i in range(sides)]
    top = [list(range(sides, 2 * sides))] if lid else []
    return polygons(np.concatenate(points), bottom + walls + top)


def quad_torus(around: int = 6, across: int = 4) -> PolygonMesh:
    """A ring of quads; vertex i * across + j is i of the way around and j of its section."""
    u, v = (axis.ravel() for axis in np.indices((around, across)))
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / across
    out = 2 + 0.8 * np.cos(b)
    points = np.column_stack([out * np.cos(a), out * np.sin(a), 0.8 * np.sin(b)])

    def number(i, j):
        return (i % around) * across + j % across

    corners = [number(u, v), number(u + 1, v), number(u + 1, v + 1), number(u, v + 1)]
    return PolygonMesh(points, np.stack(corners, axis=1))


def quad_sheet(columns: int = 3, rows: int = 2) -> PolygonMesh:
    """A wavy open sheet of quads."""
    u, v = (axis.ravel() for axis in np.indices((columns + 1, rows + 1)))
    points = np.column_stack([u, v, 0.3 * np.sin(u) * v])
    first = [i * (rows + 1) + j for i in range(columns) for j in range(rows)]
    return polygons(points, [[k, k + rows + 1, k + rows + 2, k + 1] for k in first])


def mixed_sheet() -> PolygonMesh:
    """An open sheet of one triangle, two quads and a pentagon round an inner vertex."""
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0], [-1, 1, 0.1], [-1, -1, 0], [1, -1, 0.3]]
    faces = [[0, 1, 2, 3], [0, 3, 4], [0, 4, 5, 6], [0, 6, 1]]
    return polygons([*points, [2, 0, 0.4], [2, 1, 0]], [*faces, [1, 6, 7, 8, 2]])


def dual(mesh: Mesh) -> PolygonMesh:
    """A closed cage with a polygon for every vertex, a vertex in the middle of every triangle."""
    ahead = {}
    for number, face in enumerate(mesh.faces.tolist()):
        for turn in range(3):
            vertex, start, end = face[turn:] + face[:turn]
            ahead[vertex, start] = end, number
    polygon_of = []
    for vertex in range(len(mesh.vertices)):
        first = start = next(b for a, b in ahead if a == vertex)
        polygon_of.append([])
        while not polygon_of[-1] or start != first:
            start, number = ahead[vertex, start]
            polygon_of[-1].append(number)
    return polygons(mesh.vertices[mesh.faces].mean(axis=1), polygon_of)


CAGES = {
    "tetrahedron": TOPOLOGIES["tetrahedron"],
    "cube": lambda: shapes.bar(1.0, 1.0, 1, 1, quads=True),
    "icosahedron": TOPOLOGIES["icosahedron"],
    "torus of triangles": lambda: torus(4, 3),
    "torus of quads": lambda: quad_torus(4, 3),
    "hexagonal prism": lambda: prism(6),
    "open prism": lambda: prism(5, lid=False),
    "open sheet of triangles": lambda: grid(3, 3, holes=((1, 1),)),
    "open sheet of quads": quad_sheet,
    "open sheet of polygons": mixed_sheet,
}
WAYS = [(name, not isinstance(cage(), Mesh)) for name, cage in CAGES.items()]  # quads or not
WAYS += [("tetrahedron", True), ("open sheet of triangles", True)]


def random_cage(seed: int, many_sided: bool) -> Surface:
    """The hull of some points, or the dual of one: triangles, or polygons of all sizes."""
    hull = uneven_hull(8 + seed % 7, seed)
    return dual(hull) if many_sided else hull


def levels_of(surface: Surface, finest: int, quads: bool | None = None) -> list[Connectivity]:
    """Levels 0 to ``finest`` of a cage; quads by default unless all faces are triangles."""
    levels = [connectivity(surface)]
    quads = bool((levels[0].sizes != 3).any()) if quads is None else quads
    for _ in range(finest):
        levels.append(refined(levels[-1], quads))
    return levels


def faces_of(c: Connectivity) -> list[list[int]]:
    return [c.indices[a:b].tolist() for a, b in pairwise(c.offsets)]


def pinned(count: int, seed: int, vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows (count, vertices) of hats at random places between three vertices, and targets."""
    random = np.random.default_rng(seed)
    rows = np.zeros((count, vertices))
    for row in rows:
        row[random.choice(vertices, 3, replace=False)] = random.dirichlet(np.ones(3))
    return rows, random.normal(size=(count, 3))


# the method


def prolongation(coarse: Connectivity, fine: Connectivity) -> np.ndarray:
    """P: midpoints of edges, and centres of faces if they were cut into quads."""
    rows = list(np.eye(coarse.vertex_count))
    rows += [np.eye(coarse.vertex_count)[edge].mean(axis=0) for edge in coarse.edges]
    if fine.sizes[0] == 4:
        rows += [np.eye(coarse.vertex_count)[face].mean(axis=0) for face in faces_of(coarse)]
    return np.array(rows)


def hat_products(c: Connectivity, level: int, quads: bool) -> np.ndarray:
    """I by quadrature of the hats, exact for their products."""
    found = np.zeros((c.vertex_count,) * 2)
    for face in faces_of(c):
        size, hats = len(face), np.eye(len(face))
        after, before = (
            (hats + np.roll(hats, -1, axis=0)) / 2,
            (hats + np.roll(hats, 1, axis=0)) / 2,
        )
        values, weight = after, 1 / 3  # at the middles of edges
        if quads:
            centre = np.tile(hats.mean(axis=0), (size, 1))
            split = np.stack([hats, after, centre, before], axis=1)
            near, far = 0.5 - 12**-0.5, 0.5 + 12**-0.5  # Gauss
            inside = [[(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]
                      for u in (near, far) for v in (near, far)]  # fmt: skip
            values, weight = np.einsum("pa,cai->cpi", inside, split).reshape(-1, size), 1 / 16
        found[np.ix_(face, face)] += weight / 4**level * (values.T @ values)
    return found


def within(coarse: Connectivity, fine: Connectivity, support: int | None) -> np.ndarray:
    """Whether an old vertex is in the support of a new one, (old, new); a negative one is empty."""
    old = coarse.vertex_count
    found = np.zeros((old, fine.vertex_count - old), dtype=bool)
    for new, parents in enumerate(prolongation(coarse, fine)[old:]):
        reached = set(np.flatnonzero(parents))
        for _ in range(support or 0):
            reached |= {v for face in faces_of(coarse) if reached & set(face) for v in face}
        if support is None or support >= 0:
            found[range(old) if support is None else list(reached), new] = True
    return found


def lifting(
    coarse: Connectivity, fine: Connectivity, level: int, support: int | None
) -> np.ndarray:
    """alpha, hat after hat (eq. 9)."""
    quads, old = bool(fine.sizes[0] == 4), coarse.vertex_count
    products = hat_products(coarse, level, quads)
    mixed = hat_products(fine, level + 1, quads) @ prolongation(coarse, fine)
    rho = within(coarse, fine, support)
    alpha, inverse = np.zeros(rho.shape), np.linalg.inv(products)
    for new, hats in enumerate(rho.T):
        local = inverse if hats.all() else np.linalg.inv(products[np.ix_(hats, hats)])
        alpha[hats, new] = local @ mixed[old + new, hats]
    return alpha


def analysis(coarse: Connectivity, fine: Connectivity, level: int, support: int | None):
    """A and B: the inverse of [P Q] (eq. 5), Q by eq. 10."""
    alpha, synthesis = lifting(coarse, fine, level, support), prolongation(coarse, fine)
    middles = synthesis[coarse.vertex_count :]
    wavelets = np.vstack([-alpha, np.eye(len(middles)) - middles @ alpha])
    inverse = np.linalg.inv(np.hstack([synthesis, wavelets]))
    return inverse[: coarse.vertex_count], inverse[coarse.vertex_count :]


def stacked(levels: list[Connectivity], rows: list, support: int | None) -> list[np.ndarray]:
    """Mhat of each level, every product from its own level on (eq. 30)."""
    steps = [analysis(c, f, k, support)[0] for k, (c, f) in enumerate(pairwise(levels))]
    found = []
    for k in range(len(levels)):
        blocks = [np.zeros((0, levels[k].vertex_count))]
        for j in range(k + 1):
            if rows[j] is not None:
                blocks.append(np.linalg.multi_dot([rows[j], np.eye(rows[j].shape[1]), *steps[j:k]]))
        found.append(np.vstack(blocks))
    return found


def means(c: Connectivity) -> np.ndarray:
    """What takes the mean of the neighbours of each vertex, of those on the boundary along it."""
    sides = Counter(
        frozenset(side)
        for face in faces_of(c)
        for side in zip(face, face[1:] + face[:1], strict=True)
    )
    border = {v for side, count in sides.items() if count == 1 for v in side}
    found = np.zeros((c.vertex_count,) * 2)
    for side, count in sides.items():
        for v in side:
            if v not in border or count == 1:
                found[v, list(side - {v})] = 1
    return found / found.sum(axis=1, keepdims=True)


def filtered(c: Connectivity, start, rows, right, steps: int) -> np.ndarray:
    """Steps of eq. 16 to 18."""
    inverse, mean = np.linalg.pinv(rows, rcond=1e-5), means(c)
    values = start + inverse @ (right - rows @ start)
    for _ in range(steps):
        for factor in TAUBIN:
            values = values + factor * (mean @ values - values)
        values = values + inverse @ (right - rows @ values)
    return values


def surface_by_blending(
    levels: list[Connectivity], rows: list, targets: list, weights, steps: int, support
) -> np.ndarray:
    """The last surface: ``(1 - w) (P f + h) + w g`` level after level, where g smooths the surface
    so far, P f, and h what it lacks, from zero."""
    matrices = stacked(levels, rows, support)
    wanted = [np.vstack(targets[: k + 1]) for k in range(len(levels))]
    surface = np.zeros((levels[0].vertex_count, 3))
    surface = filtered(levels[0], surface, matrices[0], wanted[0], steps)
    for k, (coarse, fine) in enumerate(pairwise(levels), start=1):
        up = prolongation(coarse, fine) @ surface
        w = weights[k] / weights[: k + 1].sum(axis=0)
        g = filtered(fine, up, matrices[k], wanted[k], steps)
        h = filtered(fine, 0 * up, matrices[k], wanted[k] - matrices[k] @ up, steps)
        surface = w * g + (1 - w) * (up + h)
    return surface
