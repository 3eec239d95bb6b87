"""Small cages of all kinds, surfaces refined from them, and constraints at random."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from henkei.design import Constraint, Curve, Designer, Pin
from henkei.design.refinement import Connectivity, connectivity, refined, refined_positions
from henkei.mesh import Mesh, PolygonMesh, Surface
from henkei.shapes import cube_cage, icosphere, sheet_cage, tetrahedron_cage, torus_cage
from topologies import grid, torus, uneven_hull


def faces_of(surface: Surface | Connectivity) -> list[list[int]]:
    return [face.tolist() for face in np.split(surface.indices, surface.offsets[1:-1])]


def polygon(sides: int) -> PolygonMesh:
    """A single face, flat."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    return PolygonMesh.from_faces(ring, [list(range(sides))])


def prism(sides: int, lid: bool = True) -> PolygonMesh:
    """Two n-gons, bottom and lid, and n quads between them; open at the top without its lid."""
    ring = polygon(sides).vertices
    bottom, top = list(range(sides)), list(range(sides, 2 * sides))
    walls = [[i, (i + 1) % sides, sides + (i + 1) % sides, sides + i] for i in bottom]
    faces = [bottom[::-1], *[top] * lid, *walls]
    return PolygonMesh.from_faces(np.concatenate([ring, ring + np.array([0, 0, 1])]), faces)


def hexagonal_prism() -> PolygonMesh:
    """Two hexagons, five quads, and a side of two triangles."""
    whole = prism(6)
    *faces, (a, b, c, d) = faces_of(whole)
    return PolygonMesh.from_faces(whole.vertices, [*faces, [a, b, c], [a, c, d]])


def mixed_sheet() -> PolygonMesh:
    """An open sheet of one triangle, two quads and a pentagon round an inner vertex."""
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0], [-1, 1, 0.1], [-1, -1, 0], [1, -1, 0.3]]
    faces = [[0, 1, 2, 3], [0, 3, 4], [0, 4, 5, 6], [0, 6, 1], [1, 6, 7, 8, 2]]
    return PolygonMesh.from_faces([*points, [2, 0, 0.4], [2, 1, 0]], faces)


def together(*surfaces: Surface) -> PolygonMesh:
    """Several surfaces as one, side by side."""
    points = [surface.vertices + 5 * number for number, surface in enumerate(surfaces)]
    starts = np.cumsum([0, *map(len, points)]).tolist()
    faces = [
        [vertex + start for vertex in face]
        for start, surface in zip(starts, surfaces, strict=False)
        for face in faces_of(surface)
    ]
    return PolygonMesh.from_faces(np.concatenate(points), faces)


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
    return PolygonMesh.from_faces(mesh.vertices[mesh.faces].mean(axis=1), polygon_of)


CAGES: dict[str, Callable[[], Surface]] = {
    "tetrahedron": tetrahedron_cage,
    "cube": cube_cage,
    "icosahedron": lambda: icosphere(0),
    "torus of triangles": lambda: torus(4, 3),
    "torus of quads": lambda: torus_cage(4, 3),
    "hexagonal prism": hexagonal_prism,
    "open prism": lambda: prism(5, lid=False),
    "open sheet of triangles": lambda: grid(3, 3, holes=((1, 1),)),
    "open sheet of quads": lambda: sheet_cage(3, 2),
    "open sheet of polygons": mixed_sheet,
    "two pieces": lambda: together(tetrahedron_cage(), polygon(5)),
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


def fine(cage: Surface, levels: int, quads: bool | None = None) -> Surface:
    """The cage refined but not smoothed, as a surface of triangles or quads, as above."""
    if not levels:
        return cage
    *coarser, finest = levels_of(cage, levels, quads)
    sides, positions = int(finest.sizes[0]), cage.vertices
    for level in coarser:
        positions = refined_positions(level, sides == 4, positions)
    faces = finest.indices.reshape(-1, sides)
    return Mesh(positions, faces) if sides == 3 else PolygonMesh(positions, faces)


def shuffled(surface: Surface, seed: int) -> Surface:
    """Vertices and faces in any order, faces from any of their corners."""
    rng = np.random.default_rng(seed)
    number, order = rng.permutation(len(surface.vertices)), rng.permutation(surface.face_count)
    sizes = np.diff(surface.offsets)[order]
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    turned = np.arange(offsets[-1]) + np.repeat(rng.integers(sizes) - offsets[:-1], sizes)
    corners = np.repeat(surface.offsets[order], sizes) + turned % np.repeat(sizes, sizes)
    vertices, indices = surface.vertices[np.argsort(number)], number[surface.indices[corners]]
    if isinstance(surface, Mesh):
        return Mesh(vertices, indices.reshape(-1, 3))
    return PolygonMesh(vertices, (indices, offsets))


def pinned(count: int, seed: int, vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows (count, vertices) of hats at random places between three vertices, and targets."""
    random = np.random.default_rng(seed)
    rows = np.zeros((count, vertices))
    for row in rows:
        row[random.choice(vertices, 3, replace=False)] = random.dirichlet(np.ones(3))
    return rows, random.normal(size=(count, 3))


def ask_again(designer: Designer, one: Constraint, target: np.ndarray | None = None) -> None:
    """Ask of a designer what a constraint asks of another, or the same with another target."""
    to = one.target if target is None else target
    if isinstance(one, Pin):
        designer.pin(one.level, one.place, to, name=one.name)
    elif isinstance(one, Curve):
        designer.curve(one.level, one.path, to, name=one.name)
    else:
        designer.derivative(one.level, one.place, one.direction, to, name=one.name)


def constrained(designer: Designer, seed: int, each: int = 3, first: int = 1) -> Designer:
    """A curve, a derivative and ``each`` pins at random, on every level from ``first`` on."""
    rng = np.random.default_rng(seed)
    for level in range(first, designer.levels + 1):
        flat = designer.flat(level)
        starts = rng.choice(flat.face_count, min(each + 2, flat.face_count), replace=False)
        for number, face in enumerate(starts.tolist()):
            corners = flat.indices[flat.offsets[face] : flat.offsets[face + 1]]
            if number == 0:
                path = corners[:3]
                target = flat.vertices[path] + rng.normal(scale=0.1, size=3)
                designer.curve(level, path.tolist(), target)
            elif number == 1:
                slope = flat.vertices[corners[1]] - flat.vertices[corners[0]]
                turned = slope + rng.normal(scale=0.02, size=3)
                designer.derivative(level, int(corners[0]), int(corners[1]), turned)
            else:
                weights = rng.dirichlet(np.ones(len(corners)))
                target = weights @ flat.vertices[corners] + rng.normal(scale=0.2, size=3)
                designer.pin(level, (face, weights), target)
    return designer
