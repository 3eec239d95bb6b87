"""Where points lie on a triangulated sphere, slowly: every face is tried in rational arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

Vector = tuple[Fraction, Fraction, Fraction]


def locate_on_sphere(points, vertices, faces) -> tuple[np.ndarray, np.ndarray]:
    """Face, and barycentric coordinates in it, of each point's projection from the centre.

    The origin must lie strictly on the inner side of every face, and the faces, projected, cover
    the sphere once. Lengths of points and vertices do not matter for the face; the coordinates are
    those in the flat triangle. Of several faces that share a point the first is named.

    Returns
    -------
    (k,) int and (k, 3) float, the exact values rounded; rows sum to 1, and ``weights @ corners``
    is a positive multiple of the point.
    """
    corners = [[exact(vertices[v]) for v in face] for face in faces]
    assert all(determinant(*triangle) > 0 for triangle in corners)
    found = [first_face(exact(point), corners) for point in points]
    return (
        np.array([face for face, _ in found], dtype=np.int64),
        np.array([[float(w) for w in weights] for _, weights in found]).reshape(-1, 3),
    )


def first_face(point: Vector, corners: list[list[Vector]]) -> tuple[int, list[Fraction]]:
    """The first face whose cone from the origin contains the point, and its weights there."""
    for face, (p, q, r) in enumerate(corners):
        if (
            (w_p := determinant(point, q, r)) >= 0
            and (w_q := determinant(p, point, r)) >= 0
            and (w_r := determinant(p, q, point)) >= 0
        ):
            total = w_p + w_q + w_r
            return face, [w_p / total, w_q / total, w_r / total]
    raise AssertionError(f"no face contains {point}")


def determinant(p: Vector, q: Vector, r: Vector) -> Fraction:
    """Six times the volume of the origin, p, q and r."""
    return (
        p[0] * (q[1] * r[2] - q[2] * r[1])
        + p[1] * (q[2] * r[0] - q[0] * r[2])
        + p[2] * (q[0] * r[1] - q[1] * r[0])
    )


def exact(point) -> Vector:
    return tuple(Fraction(float(x)) for x in point)
