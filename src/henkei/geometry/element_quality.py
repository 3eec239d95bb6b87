"""How well-shaped finite elements are, in the measures that pre-processors report.

Definitions of the Verdict library: C. J. Stimpson, C. D. Ernst, P. Knupp, P. P. Pebay, D. Thompson,
"The Verdict geometric quality library", SAND2007-1751; scaled Jacobians after P. M. Knupp,
"Achieving finite element mesh quality via optimization of the Jacobian matrix norm", Int. J. Numer.
Meth. Eng. 48 (2000). All measures are free of units and of scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidInput
from henkei.mesh import Floats, Surface

# Of each corner: the three corners to which its edges go, seen so that they are right-handed.
AT_CORNERS: dict[int, tuple[tuple[int, int, int, int], ...]] = {
    6: ((0, 1, 2, 3), (1, 2, 0, 4), (2, 0, 1, 5), (3, 5, 4, 0), (4, 3, 5, 1), (5, 4, 3, 2)),
    8: (
        (0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7),
        (4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3),
    ),
}  # fmt: skip
# Of each solid without such corners: the tetrahedra of which the worst one counts.
WITHIN: dict[int, tuple[tuple[int, int, int, int], ...]] = {
    4: ((0, 1, 2, 3),),
    5: ((0, 1, 2, 4), (1, 2, 3, 4), (2, 3, 0, 4), (3, 0, 1, 4)),
}
IDEAL = {4: np.sqrt(2.0), 5: 2.0, 6: 2 / np.sqrt(3.0), 8: 1.0}


@dataclass(frozen=True, eq=False)
class ElementQuality:
    """Quality of the faces of a surface.

    scaled_jacobian : (m,) in [-1, 1]; 1 for an equilateral triangle, a square or a regular
        polygon, 0 for a face without area, less where a corner of it is turned inside out.
    aspect_ratio : (m,) from 1 for those on; infinite for a face without area.
    worst_scaled_jacobian, mean_scaled_jacobian : over all faces.
    worst_aspect_ratio, mean_aspect_ratio : over all faces.
    worst_faces : (k,) up to ten faces of least scaled Jacobian, the worst first.
    """

    scaled_jacobian: Floats
    aspect_ratio: Floats
    worst_scaled_jacobian: float
    mean_scaled_jacobian: float
    worst_aspect_ratio: float
    mean_aspect_ratio: float
    worst_faces: NDArray[np.int64]


def element_quality(surface: Surface) -> ElementQuality:
    """Scaled Jacobian and aspect ratio of each face.

    Triangles and quads after Verdict. The scaled Jacobian of a larger polygon is the least over its
    corners of the sine there, against the face's normal, over the sine in a regular polygon; its
    aspect ratio is the longest edge times the perimeter over the area, against the same of a
    regular polygon (for a quad that is Verdict's aspect ratio as well).

    Raises
    ------
    InvalidInput : no faces.
    """
    if not surface.face_count:
        raise InvalidInput("a surface without faces has no element quality")
    jacobian, aspect = np.empty(surface.face_count), np.empty(surface.face_count)
    sizes = np.diff(surface.offsets)
    for size in np.unique(sizes):
        faces = np.flatnonzero(sizes == size)
        rings = surface.indices[surface.offsets[faces][:, None] + np.arange(size)]
        jacobian[faces], aspect[faces] = _polygons(surface.vertices[rings])
    order = np.argsort(jacobian, kind="stable")
    return ElementQuality(
        jacobian,
        aspect,
        float(jacobian.min()),
        float(jacobian.mean()),
        float(aspect.max()),
        float(aspect.mean()),
        order[:10],
    )


def _polygons(points: Floats) -> tuple[Floats, Floats]:
    """Scaled Jacobian and aspect ratio of polygons with equally many corners ``(m, k, 3)``."""
    count = points.shape[1]
    edges = _scaled(np.roll(points, -1, axis=1) - points)
    lengths = np.linalg.norm(edges, axis=2)
    corners = np.cross(np.roll(edges, 1, axis=1), edges)
    area = _vector_area(edges)
    size = np.linalg.norm(area, axis=1)
    normal = _over(area, size[:, None], 0.0)
    signed = np.einsum("fki,fi->fk", corners, normal)
    if count == 3:
        products = np.stack([lengths[:, i] * lengths[:, j] for i, j in ((0, 1), (1, 2), (2, 0))], 1)
        least = _over(2 * size, products.max(axis=1), 0.0)
    else:
        least = _over(signed, np.roll(lengths, 1, axis=1) * lengths, 0.0).min(axis=1)
    regular = np.sin(2 * np.pi / count)
    perimeter = count / 4 / np.tan(np.pi / count)  # area of the regular polygon with unit edges
    aspect = _over(lengths.max(axis=1) * lengths.sum(axis=1) * perimeter, count * size, np.inf)
    return np.clip(least / regular, -1, 1), aspect


def scaled_jacobians(nodes: ArrayLike, cells: ArrayLike) -> Floats:
    """Scaled Jacobian of each solid element, after Verdict.

    Parameters
    ----------
    nodes : (N, 3) positions.
    cells : (k, c) rows of ``nodes``: 4 corners for tetrahedra, 5 for pyramids, 6 for wedges, 8 for
        hexahedra, in the order of Abaqus and Nastran.

    Returns
    -------
    (k,) in [-1, 1]: 1 for the regular element (of pyramids, one whose sides are equilateral
    triangles), 0 without volume, less for one turned inside out at a corner.

    Raises
    ------
    InvalidInput : another number of corners.
    """
    table = np.asarray(cells, dtype=np.int64)
    if table.ndim != 2 or table.shape[1] not in IDEAL:
        raise InvalidInput(
            f"solids have 4, 5, 6 or 8 corners, these cells have shape {table.shape}"
        )
    corners = table.shape[1]
    points = np.asarray(nodes, dtype=np.float64)[table]
    points = _scaled(points - points[:, :1])
    found = [_tetrahedron(points[:, tetra]) for tetra in WITHIN.get(corners, ())]
    for corner, first, second, third in AT_CORNERS.get(corners, ()):
        a, b, c = (points[:, end] - points[:, corner] for end in (first, second, third))
        found.append(_jacobian(a, b, c))
    if corners == 8:
        found.append(_jacobian(*_axes(points)))
    least = np.min(found, axis=0) * IDEAL[corners]
    if corners == 5:  # higher ones are worse again
        least = np.minimum(least, 2 - least)
    quality: Floats = np.clip(least, -1, 1)
    return quality


def _jacobian(a: Floats, b: Floats, c: Floats) -> Floats:
    lengths = np.prod([np.linalg.norm(edge, axis=1) for edge in (a, b, c)], axis=0)
    return _over(np.einsum("ij,ij->i", np.cross(a, b), c), lengths, 0.0)


def _tetrahedron(points: Floats) -> Floats:
    """The determinant over the largest product of three edges that meet at a corner."""
    a, b, c = (points[:, k] - points[:, 0] for k in (1, 2, 3))
    determinant = np.einsum("ij,ij->i", np.cross(a, b), c)
    products = [
        np.prod(
            [np.linalg.norm(points[:, j] - points[:, i], axis=1) for j in range(4) if j != i],
            axis=0,
        )
        for i in range(4)
    ]
    return _over(determinant, np.max(products, axis=0), 0.0)


def _axes(points: Floats) -> tuple[Floats, Floats, Floats]:
    """The principal axes of hexahedra."""
    sides = (
        ((1, 2, 6, 5), (0, 3, 7, 4)),
        ((3, 2, 6, 7), (0, 1, 5, 4)),
        ((4, 5, 6, 7), (0, 1, 2, 3)),
    )
    x, y, z = (points[:, far].sum(axis=1) - points[:, near].sum(axis=1) for far, near in sides)
    return x, y, z


def _vector_area(edges: Floats) -> Floats:
    """Area times normal of polygons, given their edges one after the other."""
    ring = np.cumsum(edges, axis=1)
    area: Floats = np.cross(ring[:, :-1], ring[:, 1:]).sum(axis=1) / 2
    return area


def _scaled(vectors: Floats) -> Floats:
    """The vectors of each element over the largest of its coordinates."""
    size = np.abs(vectors).max(axis=(1, 2), initial=0.0)
    scaled: Floats = vectors / np.where(size > 0, size, 1.0)[:, None, None]
    return scaled


def _over(a: Floats, b: Floats, otherwise: float) -> Floats:
    a, b = np.broadcast_arrays(a, b)
    ratio: Floats = np.divide(a, b, out=np.full(a.shape, otherwise), where=b > 0)
    return ratio
