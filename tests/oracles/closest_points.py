"""Nearest points on triangles, slowly: each triangle is asked in rational arithmetic."""

from __future__ import annotations

from fractions import Fraction

Vector = tuple[Fraction, ...]


def squared_distances(vertices, faces, point) -> list[Fraction]:
    """Exact squared distance of a point from each face."""
    corners = [exact(p) for p in vertices]
    return [to_triangle(exact(point), [corners[v] for v in face]) for face in faces]


def exact(point) -> Vector:
    return tuple(Fraction(float(x)) for x in point)


def to_triangle(p: Vector, triangle: list[Vector]) -> Fraction:
    """To the projection if that falls inside, else to the nearest side."""
    a, b, c = triangle
    found = [to_segment(p, *side) for side in ((a, b), (b, c), (c, a))]
    normal = cross(minus(b, a), minus(c, a))
    if any(normal):
        inward = (
            dot(cross(normal, minus(q, start)), minus(p, start))
            for start, q in ((a, b), (b, c), (c, a))
        )
        if all(side >= 0 for side in inward):
            found.append(dot(normal, minus(p, a)) ** 2 / dot(normal, normal))
    return min(found)


def to_segment(p: Vector, a: Vector, b: Vector) -> Fraction:
    along = minus(b, a)
    length = dot(along, along)
    place = dot(minus(p, a), along) / length if length else Fraction(0)
    place = min(max(place, Fraction(0)), Fraction(1))
    rest = tuple(x - y - place * z for x, y, z in zip(p, a, along, strict=True))
    return dot(rest, rest)


def minus(a: Vector, b: Vector) -> Vector:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def dot(a: Vector, b: Vector) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a: Vector, b: Vector) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
