"""Faces that intersect, slowly: each pair is clipped in rational arithmetic."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

Vector = tuple[Fraction, Fraction, Fraction]


def self_intersections(vertices, faces) -> list[tuple[int, int]]:
    """Pairs of faces with an area that meet elsewhere than in vertices and edges they share."""
    points = [tuple(Fraction(float(x)) for x in p) for p in vertices]
    triangles = [[points[v] for v in face] for face in faces]
    return [
        (f, g)
        for f, g in combinations(range(len(triangles)), 2)
        if any(normal(triangles[f]))
        and any(normal(triangles[g]))
        and intersect(triangles[f], triangles[g])
    ]


def intersect(s: list[Vector], t: list[Vector]) -> bool:
    """Whether two triangles meet beyond the corners they share."""
    common = clip_to_triangle(s, t)
    shared = [p for p in s if p in t]
    if len(shared) == 3:
        return True
    if len(shared) == 2:
        along = minus(shared[1], shared[0])
        return any(any(cross(minus(p, shared[0]), along)) for p in common)
    return any(p not in shared for p in common)


def clip_to_triangle(polygon: list[Vector], t: list[Vector]) -> list[Vector]:
    """Corners of the part of a convex polygon that lies in the triangle."""
    n = normal(t)
    half_spaces = [(t[0], n), (t[0], scaled(n, -1))]
    half_spaces += [(t[i], cross(n, minus(t[(i + 1) % 3], t[i]))) for i in range(3)]
    for origin, inward in half_spaces:
        heights = [dot(minus(p, origin), inward) for p in polygon]
        kept = []
        for i, (p, height) in enumerate(zip(polygon, heights, strict=True)):
            before = heights[i - 1]
            if height * before < 0:
                kept.append(plus(p, scaled(minus(polygon[i - 1], p), height / (height - before))))
            if height >= 0:
                kept.append(p)
        polygon = kept
    return polygon


def normal(t: list[Vector]) -> Vector:
    return cross(minus(t[1], t[0]), minus(t[2], t[0]))


def plus(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scaled(a: Vector, factor: Fraction | int) -> Vector:
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def dot(a: Vector, b: Vector) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
