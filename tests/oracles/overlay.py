"""The overlay of two triangulations of one square, slowly: every pair of edges, in fractions."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

Point = tuple[Fraction, Fraction]


def arrangement(edges_a, edges_b) -> tuple[set[Point], set[frozenset[Point]]]:
    """Vertices and edges of the subdivision of the plane by both sets of segments.

    Segments of one set meet only in their ends. Points are pairs of integers or fractions.
    """
    segments = [tuple((Fraction(x), Fraction(y)) for x, y in edge) for edge in [*edges_a, *edges_b]]
    split = len(edges_a)
    vertices = {end for segment in segments for end in segment}
    for p, q in segments[:split]:
        for r, s in segments[split:]:
            side_p, side_q = left(r, s, p), left(r, s, q)
            if side_p * side_q < 0 and left(p, q, r) * left(p, q, s) < 0:
                along = side_p / (side_p - side_q)
                vertices.add(tuple(u + along * (v - u) for u, v in zip(p, q, strict=True)))
    pieces = set()
    for p, q in segments:
        on = sorted((v for v in vertices if within(p, q, v)), key=lambda v: dot(p, q, p, v))
        pieces |= {frozenset(pair) for pair in pairwise(on)}
    return vertices, pieces


def left(p: Point, q: Point, r: Point) -> Fraction:
    """Twice the signed area of the triangle p, q, r."""
    return (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])


def dot(p: Point, q: Point, r: Point, s: Point) -> Fraction:
    return (q[0] - p[0]) * (s[0] - r[0]) + (q[1] - p[1]) * (s[1] - r[1])


def within(p: Point, q: Point, v: Point) -> bool:
    return left(p, q, v) == 0 and dot(v, p, v, q) <= 0
