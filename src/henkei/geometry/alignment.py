"""Moving one shape onto another: the best similarity in closed form."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from henkei.errors import InvalidInput, some
from henkei.geometry.correspondence import Correspondence
from henkei.geometry.rotations import best_rotations
from henkei.mesh import Attributes, Floats, Mesh


@dataclass(frozen=True, eq=False)
class Similarity:
    """The map ``x -> scale * rotation @ x + translation``.

    rotation : (3, 3) proper rotation matrix.
    scale : factor, at least 0.
    translation : (3,).
    """

    rotation: Floats
    scale: float
    translation: Floats

    def apply(self, points: ArrayLike) -> Floats:
        """The images of points ``(n, 3)``."""
        moved: Floats = self.scale * (np.asarray(points) @ self.rotation.T) + self.translation
        return moved

    def undo(self, points: ArrayLike) -> Floats:
        """The points ``(n, 3)`` whose images these are; the scale is above 0."""
        unmoved: Floats = (np.asarray(points) - self.translation) @ self.rotation / self.scale
        return unmoved

    def turn(self, directions: ArrayLike) -> Floats:
        """The images of directions ``(n, 3)``: turned only."""
        turned: Floats = np.asarray(directions) @ self.rotation.T
        return turned


def similarity(
    source: ArrayLike, target: ArrayLike, weights: ArrayLike | None = None, scale: bool = True
) -> Similarity:
    """The similarity that takes ``source`` closest to ``target``, point by point.

    It minimises ``sum w |s R x + t - y|^2`` (Umeyama 1991, "Least-squares estimation of
    transformation parameters between two point patterns"). Mirroring is never used. Where the
    points leave the rotation open (all on a line, or all in one place), the smallest one is taken;
    where they leave the scale open, 1.

    Parameters
    ----------
    source, target : (n, 3) points, n at least 1.
    weights : (n,) not negative, not all zero; equal by default.
    scale : False keeps the scale at 1 (a rigid motion).

    Raises
    ------
    InvalidInput : shapes that do not fit, values that are not finite, or unusable weights.
    """
    x, y, w = _checked(source, target, weights)
    centre_x, centre_y = w @ x, w @ y
    x, y = x - centre_x, y - centre_y
    covariance = (w[:, None] * y).T @ x
    rotation = best_rotations(covariance[None])[0]
    spread = float(w @ (x * x).sum(axis=1))
    factor = 1.0
    if scale and spread > 0:
        factor = max(float(np.einsum("ij,ij", rotation, covariance)) / spread, 0.0)
    return Similarity(rotation, factor, centre_y - factor * (rotation @ centre_x))


def aligned(correspondence: Correspondence, *, scale: bool = True) -> Correspondence:
    """The correspondence with b moved onto a by the best similarity of the surfaces.

    The squared distance is integrated over the surface (area: mean of a and b, each relative to its
    whole), so that it does not matter where an overlay has its vertices. A ``normal`` among b's
    attributes turns along.
    """
    onto = surface_similarity(correspondence, scale)
    before = correspondence.attributes_b
    return replace(
        correspondence,
        vertices_b=onto.apply(correspondence.vertices_b),
        attributes_b=Attributes(
            **{
                domain: {
                    name: onto.turn(values)
                    if name == "normal" and values.shape[1:] == (3,)
                    else values
                    for name, values in getattr(before, domain).items()
                }
                for domain in ("vertex", "corner", "face")
            }
        ),
    )


def surface_similarity(correspondence: Correspondence, scale: bool = True) -> Similarity:
    """The similarity that takes b closest to a, see :func:`aligned`."""
    faces = correspondence.faces
    if not len(faces):
        return similarity(correspondence.vertices_b, correspondence.vertices_a, None, scale)
    # Midpoints of edges: this quadrature is exact for squares of what is linear on each face.
    a, b = (
        ((p[faces] + p[np.roll(faces, -1, axis=1)]) / 2).reshape(-1, 3)
        for p in (correspondence.vertices_a, correspondence.vertices_b)
    )
    return similarity(b, a, np.repeat(face_weights(correspondence), 3), scale)


def face_weights(correspondence: Correspondence) -> Floats:
    """Share of each face in the area, mean of a and b; (m,), sums to 1."""
    count = len(correspondence.faces)
    total = np.zeros(count)
    for vertices in (correspondence.vertices_a, correspondence.vertices_b):
        areas = Mesh(vertices, correspondence.faces).face_areas
        whole = areas.sum()
        total += areas / whole if whole > 0 else 1 / max(count, 1)
    return total / 2


def _checked(
    source: ArrayLike, target: ArrayLike, weights: ArrayLike | None
) -> tuple[Floats, Floats, Floats]:
    x, y = np.asarray(source, dtype=np.float64), np.asarray(target, dtype=np.float64)
    if x.shape != y.shape or x.ndim != 2 or x.shape[1] != 3 or not len(x):
        raise InvalidInput(
            f"source and target must both be (n, 3) with n > 0; they are {x.shape} and {y.shape}"
        )
    w = np.ones(len(x)) if weights is None else np.asarray(weights, dtype=np.float64)
    if w.shape != (len(x),):
        raise InvalidInput(f"weights must have shape ({len(x)},), these have {w.shape}")
    for name, values in (("source", x), ("target", y), ("weights", w[:, None])):
        bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
        if len(bad):
            raise InvalidInput(f"{name} is not finite in rows {some(bad)}")
    if (w < 0).any() or not w.sum() > 0:
        raise InvalidInput("weights must not be negative and not all be zero")
    return x, y, w / w.sum()
