"""Planar refinement, neighbours and inner products of a cage, face by face and edge by edge."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

Face = list[int]
Edge = tuple[int, int]


def sides(face: Face) -> list[Edge]:
    """From each corner to the next."""
    return list(zip(face, [*face[1:], face[0]], strict=True))


def sorted_edges(faces: Sequence[Face]) -> list[Edge]:
    return sorted({(min(side), max(side)) for face in faces for side in sides(face)})


def corner_edges(faces: Sequence[Face], edges: Sequence[Edge]) -> list[int]:
    """The number of the edge from each corner to the next."""
    number = {frozenset(edge): e for e, edge in enumerate(edges)}
    return [number[frozenset(side)] for face in faces for side in sides(face)]


def refined(
    count: int, faces: Sequence[Face], edges: Sequence[Edge], quads: bool
) -> tuple[list[Face], list[Edge]]:
    """Children of all faces and edges."""
    middle = {frozenset(edge): count + e for e, edge in enumerate(edges)}
    children: list[Face] = []
    halves = [(end, middle[frozenset(edge)]) for edge in edges for end in edge]
    inner: list[Edge] = []
    for f, face in enumerate(faces):
        ahead = [middle[frozenset(side)] for side in sides(face)]
        behind = [ahead[-1], *ahead[:-1]]
        centre = count + len(edges) + f
        for corner, a, b in zip(face, ahead, behind, strict=True):
            children.append([corner, a, centre, b] if quads else [corner, a, b])
            inner.append((a, centre) if quads else (a, b))
        if not quads:
            children.append(ahead)
    return children, halves + inner


def averages(count: int, faces: Sequence[Face], edges: Sequence[Edge], quads: bool) -> np.ndarray:
    """The matrix from old vertices to new ones."""
    groups = [[v] for v in range(count)] + [list(edge) for edge in edges]
    matrix = np.zeros((len(groups) + (len(faces) if quads else 0), count))
    for row, group in enumerate(groups + (list(faces) if quads else [])):
        matrix[row, group] = 1 / len(group)
    return matrix


def neighbours(count: int, faces: Sequence[Face], edges: Sequence[Edge]) -> list[list[int]]:
    """Those a vertex is drawn to: on the boundary, its neighbours along the boundary."""
    uses = Counter(frozenset(side) for face in faces for side in sides(face))
    border = [edge for edge in edges if uses[frozenset(edge)] == 1]
    on_border = {v for edge in border for v in edge}
    return [
        sorted(
            (set(edge) - {v}).pop() for edge in (border if v in on_border else edges) if v in edge
        )
        for v in range(count)
    ]


def smoothed(rings: Sequence[Sequence[int]], values, factors, free) -> np.ndarray:
    """Each value moved towards the mean of its neighbours by the factor of its column."""
    moved = np.array(values, dtype=float)
    for v, ring in enumerate(rings):
        if len(ring) and free[v]:
            mean = sum(values[w] for w in ring) / len(ring)
            moved[v] = values[v] + factors * (mean - values[v])
    return moved


def hat_products(count: int, faces: Sequence[Face], area: float) -> np.ndarray:
    """Integrals of products of linear hats over triangles or bilinear ones over quads, by
    quadrature that is exact for them."""
    matrix = np.zeros((count, count))
    for face in faces:
        for hats, weight in triangle_places() if len(face) == 3 else square_places():
            matrix[np.ix_(face, face)] += area * weight * np.outer(hats, hats)
    return matrix


def triangle_places() -> list[tuple[np.ndarray, float]]:
    """The middles of the sides: exact for quadratic functions."""
    return [(np.roll([0.5, 0.5, 0.0], k), 1 / 3) for k in range(3)]


def square_places() -> list[tuple[np.ndarray, float]]:
    """Gauss's two places along each side: exact for cubic functions."""
    places = (0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12))
    return [
        (np.array([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]), 1 / 4)
        for u in places
        for v in places
    ]
