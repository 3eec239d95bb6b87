"""How well-shaped triangles are. All measures are free of units and of scale.

Names as in P. M. Knupp, "Algebraic mesh quality metrics", SIAM J. Sci. Comput. 23 (2001), and
J. R. Shewchuk, "What is a good linear finite element?" (2002).
"""

from __future__ import annotations

import numpy as np

from henkei.mesh import Floats, Mesh


def mean_ratio(mesh: Mesh) -> Floats:
    """Mean ratio of each triangle, ``4 sqrt(3) area / (sum of squared edge lengths)``.

    Returns
    -------
    (m,) float64: 1 for an equilateral triangle, 0 for one without area.
    """
    lengths, area = _lengths_and_area(mesh)
    squares = (lengths**2).sum(axis=1)
    return _over(4 * np.sqrt(3) * area, squares, 0.0)


def aspect_ratio(mesh: Mesh) -> Floats:
    """Longest edge over the diameter of the inscribed circle, divided by sqrt(3).

    Returns
    -------
    (m,) float64: 1 for an equilateral triangle, infinite for one without area.
    """
    lengths, area = _lengths_and_area(mesh)
    return _over(lengths.max(axis=1) * lengths.sum(axis=1), 4 * np.sqrt(3) * area, np.inf)


def minimum_angle(mesh: Mesh) -> Floats:
    """Smallest angle of each triangle.

    Returns
    -------
    (m,) float64, in radians: pi / 3 for an equilateral triangle, 0 for one without area.
    """
    lengths, area = _lengths_and_area(mesh)
    a, b, c = np.sort(lengths, axis=1).T
    cosine = _over(b * b + c * c - a * a, 2 * b * c, 1.0)
    sine = _over(2 * area, b * c, 0.0)
    angle: Floats = np.arctan2(sine, cosine)
    return angle


def _lengths_and_area(mesh: Mesh) -> tuple[Floats, Floats]:
    """Edge lengths and area of each triangle, scaled so that its longest side is about 1."""
    points = mesh.vertices[mesh.faces] / (np.abs(mesh.vertices).max(initial=0.0) or 1.0)
    sides = np.roll(points, -1, axis=1) - points
    size = np.abs(sides).max(axis=(1, 2), initial=0.0)
    sides /= np.where(size > 0, size, 1.0)[:, None, None]
    lengths: Floats = np.linalg.norm(sides, axis=2)
    area: Floats = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    return lengths, area


def _over(a: Floats, b: Floats, otherwise: float) -> Floats:
    ratio: Floats = np.divide(a, b, out=np.full_like(a, otherwise), where=b > 0)
    return ratio
