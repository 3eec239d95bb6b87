"""Cages: coarse control polyhedra for :class:`henkei.Designer`, after Takahashi (2000).

All are manifold and oriented outward; +y is up and faces look toward +z.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, pairwise

import numpy as np

from henkei.errors import InvalidInput
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh
from henkei.shapes.clay import Point
from henkei.topology import Ints

Corner = tuple[str, int, int, int]
"""Part of a head, column from the middle (negative on the right), row from below, layer from
behind."""

Place = tuple[float, float]
Face = list[tuple[Corner, Place]]
"""Corners with where they lie on the unfolded head."""

_ROWS = 4
_UNFOLDED, _ORIGIN = np.array([14.0, 8.0]), np.array([6.5, 2.0])  # its size, and where 0, 0 is
_RING = [(1, 2), (2, 2), (3, 2), (3, 1), (3, 0), (2, 0), (1, 0)]  # left half: columns, layers
_EYE = [(1, 2, 2), (2, 2, 2), (2, 3, 2), (1, 3, 2)]
_EAR = [(3, 2, 1), (3, 2, 0), (3, 3, 0), (3, 3, 1)]
_NOSE = [(1, 2, 2), (1, 3, 2)]
_NECK = [(1, 0, 1), (2, 0, 1), (2, 0, 0), (1, 0, 0)]

_TETRAHEDRON = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
_HOLLOW = 0.55  # of a tetrahedron, by its size

# Places on the left, in the order of the patches above and of the ring, row by row from below.
_HEAD: dict[str, Sequence[Sequence[Point]]] = {
    "front": [
        [(0.9, -5.6, 4.2), (2.3, -5.3, 3.5), (3.5, -4.6, 1.6), (3.8, -4.1, -0.9)],
        [(1.0, -3.3, 5.3), (2.7, -3.1, 4.6), (4.2, -2.6, 2.4), (4.7, -2.4, -0.7)],
        [(1.0, -1.1, 5.6), (2.9, -0.9, 5.0), (4.5, -0.7, 2.7), (5.0, -0.6, -0.5)],
        [(0.8, 2.1, 5.3), (2.9, 2.2, 4.7), (4.3, 2.2, 2.6), (4.8, 2.2, -0.6)],
        [(1.0, 4.9, 4.1), (2.5, 4.7, 3.5), (3.6, 4.4, 2.0), (3.9, 4.5, -0.8)],
    ],
    "back": [
        [(3.0, -3.5, -3.0), (1.9, -3.5, -3.9), (0.7, -3.5, -4.1)],
        [(3.8, -2.0, -3.5), (2.3, -2.0, -4.7), (0.8, -2.0, -5.1)],
        [(4.2, -0.1, -3.9), (2.5, 0.2, -5.3), (0.9, 0.2, -5.8)],
        [(4.1, 2.6, -3.9), (2.5, 2.8, -5.2), (0.9, 2.8, -5.7)],
        [(3.3, 4.6, -3.3), (2.1, 4.9, -4.3), (0.8, 5.0, -4.7)],
    ],
    "top": [[(1.0, 6.4, -0.5), (2.5, 5.9, -0.5)]],
    "bottom": [[(0.9, -5.7, 0.5), (2.2, -5.3, 0.2)]],
    "eye": [[(1.35, -0.4, 5.1), (2.65, -0.3, 4.6), (2.65, 1.6, 4.5), (1.3, 1.6, 4.9)]],
    "ear": [[(5.4, -1.2, -0.9), (6.4, -1.1, -2.6), (7.4, 3.1, -2.9), (6.0, 3.1, -0.9)]],
    "nose": [[(0.95, -1.2, 6.9), (0.65, 0.2, 6.8)]],
    "neck": [[(0.9, -8.6, 1.2), (2.4, -8.2, 0.5), (2.2, -8.2, -3.5), (0.8, -8.6, -4.2)]],
}

_PIG: dict[str, Sequence[Sequence[Point]]] = {
    "front": [
        [(1.2, -4.6, 3.6), (2.7, -4.3, 2.8), (3.8, -3.8, 1.0), (4.0, -3.6, -1.0)],
        [(1.5, -3.2, 5.0), (3.1, -2.7, 4.2), (4.6, -2.0, 2.0), (5.1, -1.7, -0.8)],
        [(1.6, -1.8, 5.5), (3.3, -0.8, 4.6), (4.8, 0.2, 2.4), (5.3, 0.8, -0.6)],
        [(1.0, 1.9, 5.3), (2.9, 2.5, 4.4), (4.2, 2.8, 2.4), (4.4, 3.2, -0.6)],
        [(1.0, 4.3, 4.0), (2.3, 4.4, 3.3), (3.2, 4.5, 1.9), (3.3, 4.7, -0.6)],
    ],
    "back": [
        [(3.3, -3.3, -2.9), (2.1, -3.5, -3.9), (0.8, -3.6, -4.2)],
        [(4.3, -1.4, -3.5), (2.6, -1.4, -4.9), (0.9, -1.4, -5.3)],
        [(4.6, 0.8, -3.6), (2.7, 0.8, -5.2), (0.9, 0.8, -5.7)],
        [(3.9, 3.2, -3.6), (2.4, 3.1, -4.9), (0.9, 3.0, -5.3)],
        [(2.9, 4.5, -2.9), (1.9, 4.6, -3.9), (0.7, 4.7, -4.2)],
    ],
    "top": [[(1.0, 5.6, -0.4), (2.3, 5.3, -0.4)]],
    "bottom": [[(1.0, -4.8, 0.3), (2.4, -4.5, 0.1)]],
    "eye": [[(1.75, -0.2, 5.3), (2.8, 0.1, 4.9), (2.7, 1.7, 4.7), (1.6, 1.6, 5.1)]],
    "ear": [[(5.8, 2.4, 0.7), (7.2, 2.7, -1.6), (6.6, 7.2, -0.8), (5.2, 6.9, 0.6)]],
    "nose": [[(1.6, -2.4, 7.6), (1.5, 0.3, 7.6)]],
    "neck": [[(0.9, -6.2, 0.6), (2.1, -5.8, 0.3), (1.9, -5.8, -2.9), (0.8, -6.2, -3.3)]],
}


def head_cage() -> PolygonMesh:
    """A character's head with sockets for the eyes, nose, ears and neck (Fig. 3).

    It looks toward +z and is about 15 high.

    Returns
    -------
    106 vertices and 104 quads without a boundary, symmetric bit for bit; corner attribute ``uv``
    (2), the head unfolded into the unit square, its seam down the back.
    """
    return _head(_HEAD)


def pig_cage() -> PolygonMesh:
    """The faces of :func:`head_cage` around a toy pig's face (Fig. 4)."""
    return _head(_PIG)


def unfolded(uv: Floats) -> Floats:
    """Texture coordinates of a head's cage, (n, 2), in quads of the box that it was made of.

    The front spans columns from -2.5 to 2.5, with 0 in the middle, and rows from 0 to 4. The sides
    and the back continue it to the left and right, the back from 4.5 on; the top continues it
    upward and the bottom downward. Eyes (at -1 and 1, 2.5), nose (0, 2.5), ears (-4 and 4, 2.5) and
    neck are in the middle of where they were drawn out, half as wide.
    """
    places: Floats = np.asarray(uv) * _UNFOLDED - _ORIGIN
    return places


def torus_cage(n: int = 8, m: int = 6) -> PolygonMesh:
    """A torus about the z axis, of radii 1 and 0.4 (Fig. 6).

    Parameters
    ----------
    n, m : quads the long and the short way around, at least 3.

    Returns
    -------
    n m vertices and quads; corner attribute ``uv``, [0, 1] the long and the short way around.

    Raises
    ------
    InvalidInput : ``n`` or ``m`` is out of range.
    """
    _require_count(n, m, least=3)
    row, column = (index.ravel() for index in np.indices((n, m)))
    along, around = 2 * np.pi * row / n, 2 * np.pi * column / m
    radius = 1 + 0.4 * np.cos(around)
    vertices = np.stack(
        [radius * np.cos(along), radius * np.sin(along), 0.4 * np.sin(around)], axis=1
    )
    i, j = _corners(n, m)
    return PolygonMesh(vertices, i % n * m + j % m, attributes=_textured(i / n, j / m))


def sheet_cage(n: int = 4, m: int = 4) -> PolygonMesh:
    """A flat rectangle facing +z, n times m quads of side 1 about the origin, with a boundary.

    Returns
    -------
    (n + 1) (m + 1) vertices, row by row from below; corner attribute ``uv``.

    Raises
    ------
    InvalidInput : ``n`` or ``m`` is less than 1.
    """
    _require_count(n, m, least=1)
    row, column = (index.ravel() for index in np.indices((m + 1, n + 1)))
    vertices = np.stack([column - n / 2, row - m / 2, np.zeros(len(row))], axis=1)
    i, j = _corners(n, m)
    return PolygonMesh(vertices, j * (n + 1) + i, attributes=_textured(i / n, j / m))


def cube_cage() -> PolygonMesh:
    """A cube of side 2 about the origin: 8 vertices, 6 quads."""
    vertices = 2.0 * np.array(np.unravel_index(np.arange(8), (2, 2, 2))).T - 1
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return PolygonMesh(vertices, faces)  # type: ignore[arg-type]


def tetrahedron_cage() -> Mesh:
    """A regular tetrahedron with its corners on the unit sphere, one up (Fig. 1): 4 triangles."""
    return Mesh(_tetrahedron(), np.array(_TETRAHEDRON))


def holed_tetrahedron_cage() -> PolygonMesh:
    """A hollow tetrahedron with a hole in each face, which leaves its thick edges (Fig. 8).

    Returns
    -------
    32 vertices and 36 quads without a boundary, of genus 3. The tetrahedron's corners, the first 4
    vertices, are on the unit sphere, one up; then those of the hollow; then for each face those of
    the hole outside and inside.
    """
    corners = _tetrahedron()
    vertices, faces = [corners, _HOLLOW * corners], []
    for face, side in enumerate(_TETRAHEDRON):
        middle = corners[side].mean(axis=0)
        vertices += [middle + 0.4 * (corners[side] - middle)]
        vertices += [_HOLLOW * (middle + 0.6 * (corners[side] - middle))]
        outside = 8 + 6 * face + np.arange(3)
        inside = outside + 3
        for i, j in ((0, 1), (1, 2), (2, 0)):
            faces += [[side[i], side[j], outside[j], outside[i]]]
            faces += [[outside[i], outside[j], inside[j], inside[i]]]
            faces += [[inside[i], inside[j], side[j] + 4, side[i] + 4]]
    return PolygonMesh(np.concatenate(vertices), np.array(faces))


def _tetrahedron() -> Floats:
    around = 2 * np.pi * np.arange(3) / 3
    low = np.stack([np.sin(around), np.full(3, -1 / np.sqrt(8)), np.cos(around)], axis=1)
    return np.concatenate([[[0, 1, 0]], low * np.sqrt(8) / 3])


def _corners(n: int, m: int) -> tuple[Ints, Ints]:
    """Both indices (n m, 4) of the corners of the quads of a grid."""
    i, j = (index.reshape(-1, 1).astype(np.int32) for index in np.indices((n, m)))
    return i + np.array([0, 1, 1, 0], np.int32), j + np.array([0, 0, 1, 1], np.int32)


def _textured(u: Floats, v: Floats) -> Attributes:
    return Attributes(corner={"uv": np.stack([u.ravel(), v.ravel()], axis=1)})


def _require_count(*counts: int, least: int) -> None:
    for count in counts:
        if not isinstance(count, int | np.integer) or isinstance(count, bool) or count < least:
            raise InvalidInput(f"a whole number of quads from {least} is needed, not {count!r}")


def _head(shape: dict[str, Sequence[Sequence[Point]]]) -> PolygonMesh:
    """A box of quads with parts drawn out of it, each vertex moved where ``shape`` says."""
    left = list(_left_of_box())
    faces = [*left, *map(_image, left), *_middle_of_box()]
    for part, patch in (("eye", _EYE), ("ear", _EAR)):
        for sign in (1, -1):
            faces = _drawn_out(faces, [(sign * c, r, k) for c, r, k in patch], part)
    for part, patch in (("nose", _NOSE), ("neck", _NECK)):
        both = [(sign * c, r, k) for c, r, k in patch for sign in (1, -1)]
        faces = _drawn_out(faces, both, part)
    faces = _symmetric(faces)
    positions = list(_positions(shape))
    number = {corner: 2 * i for i, (corner, _) in enumerate(positions)}
    number |= {_mirrored(corner): 2 * i + 1 for i, (corner, _) in enumerate(positions)}
    vertices = [(sign * x, y, z) for _, (x, y, z) in positions for sign in (1, -1)]
    places = np.array([place for face in faces for _, place in face])
    return PolygonMesh(
        vertices,  # type: ignore[arg-type]
        [[number[corner] for corner, _ in face] for face in faces],  # type: ignore[arg-type]
        attributes=Attributes(corner={"uv": (places + _ORIGIN) / _UNFOLDED}),
    )


def _positions(shape: dict[str, Sequence[Sequence[Point]]]) -> Iterator[tuple[Corner, Point]]:
    """Of the corners on the left."""
    for row, sides in enumerate(zip(shape["front"], shape["back"], strict=True)):
        for (column, layer), point in zip(_RING, chain(*sides), strict=True):
            yield ("", column, row, layer), point
    for part, row in (("bottom", 0), ("top", _ROWS)):
        for column, point in enumerate(shape[part][0], 1):
            yield ("", column, row, 1), point
    for part, patch in (("eye", _EYE), ("ear", _EAR), ("nose", _NOSE), ("neck", _NECK)):
        for corner, point in zip(patch, shape[part][0], strict=True):
            yield (part, *corner), point


def _left_of_box() -> Iterator[Face]:
    for i, (start, end) in enumerate(pairwise(_RING)):
        yield from _wall(start, end, i + 0.5)
    yield from _lids(1, 2)
    yield from _lids(2, 3)


def _middle_of_box() -> Iterator[Face]:
    yield from _wall((-1, 2), (1, 2), -0.5)
    yield from _wall((1, 0), (-1, 0), 6.5)
    yield from _lids(-1, 1)


def _wall(start: tuple[int, int], end: tuple[int, int], s: float) -> Iterator[Face]:
    """The faces of all rows between two columns and layers, unfolded from ``s`` on."""
    (c, k), (d, j) = start, end
    for row in range(_ROWS):
        yield [
            (("", c, row, k), (s, row)),
            (("", d, row, j), (s + 1, row)),
            (("", d, row + 1, j), (s + 1, row + 1)),
            (("", c, row + 1, k), (s, row + 1)),
        ]


def _lids(c: int, d: int) -> Iterator[Face]:
    """The faces above and below between two columns, unfolded at the rim of the front."""
    places = [(column, column - 0.5 * np.sign(column)) for column in (c, d, d, c)]
    for layer in (2, 1):
        layers = (layer, layer, layer - 1, layer - 1)
        yield [
            (("", column, _ROWS, k), (s, _ROWS + 2.0 - k))
            for (column, s), k in zip(places, layers, strict=True)
        ]
        yield [
            (("", column, 0, k), (s, k - 2.0))
            for (column, s), k in zip(places, layers[::-1], strict=True)
        ]


def _mirrored(corner: Corner) -> Corner:
    part, column, row, layer = corner
    return part, -column, row, layer


def _image(face: Face) -> Face:
    """On the other side; it begins at the image of the first corner, so that what goes by the order
    of corners, such as triangles, is symmetric too."""
    image = [(_mirrored(corner), (-s, t)) for corner, (s, t) in face]
    return [image[0], *image[:0:-1]]


def _symmetric(faces: Sequence[Face]) -> list[Face]:
    """Those on the left, their images in place of those on the right, and those across."""
    side = [sum(column for (_, column, _, _), _ in face) for face in faces]
    left = [face for face, column in zip(faces, side, strict=True) if column > 0]
    across = [face for face, column in zip(faces, side, strict=True) if column == 0]
    return [*left, *map(_image, left), *across]


def _drawn_out(
    faces: Iterable[Face], patch: Iterable[tuple[int, int, int]], part: str
) -> list[Face]:
    """The faces among the corners of a patch moved off, and the walls that follow them.

    Unfolded, the faces lie inside where they were, half as wide, and the walls around them.
    """
    corners = {("", *corner) for corner in patch}
    rest: list[Face] = []
    moved: list[Face] = []
    for face in faces:
        (moved if all(corner in corners for corner, _ in face) else rest).append(face)
    middle = np.mean([place for face in moved for _, place in face], axis=0)

    def off(corner: Corner, place: Place) -> tuple[Corner, Place]:
        s, t = ((place + middle) / 2).tolist()
        return (part, *corner[1:]), (s, t)

    sides = [(a, b) for face in moved for a, b in pairwise([*face, face[0]])]
    inner = {(b[0], a[0]) for a, b in sides}
    walls = [[a, b, off(*b), off(*a)] for a, b in sides if (a[0], b[0]) not in inner]
    return [*rest, *walls, *([off(*corner) for corner in face] for face in moved)]
