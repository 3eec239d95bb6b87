"""Which vertices an eye sees, slowly: each line of sight against each triangle, in fractions."""

from __future__ import annotations

from fractions import Fraction

from oracles.self_intersection import cross, dot, minus


def hidden(vertices, faces, eye) -> list[bool]:
    """Whether the open segment from each vertex to the eye meets a face it is no corner of."""
    points = [tuple(Fraction(float(x)) for x in p) for p in vertices]
    goal = tuple(Fraction(float(x)) for x in eye)
    return [
        any(v not in face and blocks(points[v], goal, [points[c] for c in face]) for face in faces)
        for v in range(len(points))
    ]


def blocks(start, end, triangle) -> bool:
    """Whether a triangle crosses the open segment, at its corners and sides too."""
    along = minus(end, start)
    a, b, c = (minus(corner, start) for corner in triangle)
    volumes = [dot(along, cross(b, c)), dot(along, cross(c, a)), dot(along, cross(a, b))]
    total = sum(volumes)
    if total == 0:
        return False
    if any(volume * total < 0 for volume in volumes):
        return False
    at = [sum(w * p[i] for w, p in zip(volumes, (a, b, c), strict=True)) / total for i in range(3)]
    return 0 < dot(at, along) < dot(along, along)


def on_another_face(vertices, faces) -> list[int]:
    """The vertices that lie on a face that they are no corner of."""
    points = [tuple(Fraction(float(x)) for x in p) for p in vertices]
    return [
        v
        for v in range(len(points))
        if any(v not in face and holds(points[v], [points[c] for c in face]) for face in faces)
    ]


def holds(point, triangle) -> bool:
    """Whether a point lies on a triangle; on the line of one without area counts, too."""
    a, b, c = (minus(corner, point) for corner in triangle)
    normal = cross(minus(b, a), minus(c, a))
    if dot(a, cross(b, c)) != 0:
        return False
    return all(dot(normal, cross(p, q)) >= 0 for p, q in ((a, b), (b, c), (c, a)))
