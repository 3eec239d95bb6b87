"""Nearest points on a surface, and how far surfaces are from each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from henkei._kernels import ClosestPoints as _ClosestPoints
from henkei.errors import InvalidInput, InvalidMesh, some
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.requirements import require_finite
from henkei.mesh import Floats, Mesh

_FARTHEST = 1e150  # from the origin, in sizes of the surface, so that squares do not overflow


class ClosestPoints:
    """A surface made ready to be asked for the nearest point to any point.

    The mesh may be of any topology, its faces of any shape: one without area counts as its sides.

    Raises
    ------
    InvalidMesh : the mesh has no faces.
    NotFinite : a coordinate is NaN or infinite.
    """

    def __init__(self, mesh: Mesh) -> None:
        require_finite(mesh)
        if not len(mesh.faces):
            raise InvalidMesh("no point is nearest: the mesh has no faces; give a surface mesh")
        used = mesh.vertices[mesh.indices]
        # A power of two, so that scaling is exact: the largest coordinate is about 1.
        self._exponent = int(np.frexp(np.abs(used).max())[1])
        self._surface = _ClosestPoints(self._scaled(mesh.vertices), mesh.faces)

    def query(self, points: ArrayLike) -> tuple[SurfacePoints, Floats]:
        """The nearest place on the surface to each point, and how far it is.

        Parameters
        ----------
        points : (k, 3).

        Returns
        -------
        places : of faces at the same distance, as computed, the one with the lowest index.
        distances : (k,) float64, in the unit of the mesh.

        Raises
        ------
        InvalidInput : the points have another shape, are not finite, or are so far away that
            squared distances overflow.
        """
        asked = np.ascontiguousarray(points, dtype=np.float64)
        if asked.ndim != 2 or asked.shape[1] != 3:
            raise InvalidInput(f"points must have shape (k, 3), these have {asked.shape}")
        with np.errstate(over="ignore"):
            scaled = self._scaled(asked)
        far = np.flatnonzero(~(np.abs(scaled) < _FARTHEST).all(axis=1))
        if len(far):
            raise InvalidInput(
                f"points {some(far)} are NaN, infinite, or more than {_FARTHEST:g} times as far "
                "away as the surface is large"
            )
        face, barycentric, squared = self._surface.query(scaled)
        return SurfacePoints(face, barycentric), np.ldexp(np.sqrt(squared), self._exponent)

    def _scaled(self, points: Floats) -> Floats:
        return np.ldexp(points, -self._exponent)


def points_on(mesh: Mesh, places: SurfacePoints) -> Floats:
    """Points (n, 3) in space of places on a mesh; NaN where a place has no face."""
    points = np.zeros((len(places), 3))
    if len(mesh.faces):
        for corner in range(3):
            at = mesh.vertices[mesh.faces[places.face, corner]]
            points += places.barycentric[:, corner, None] * at
    points[places.face < 0] = np.nan
    return points


def sampled(mesh: Mesh, count: int, seed: int = 0) -> SurfacePoints:
    """``count`` random places on a mesh, each piece of its area as likely as any other.

    Raises
    ------
    InvalidInput : ``count`` is negative.
    InvalidMesh : the mesh has no area.
    """
    if count < 0:
        raise InvalidInput(f"the number of samples must not be negative, it is {count}")
    total = np.cumsum(mesh.face_areas)
    if not (len(total) and 0 < total[-1] < np.inf):
        raise InvalidMesh("the mesh has no area to take samples of; give a surface mesh")
    rng = np.random.default_rng(seed)
    # What rounds up to the whole area falls behind the last face; it is that of the last with area.
    last = np.searchsorted(total, total[-1])
    face = np.minimum(np.searchsorted(total, total[-1] * rng.random(count), side="right"), last)
    along, across = np.sqrt(rng.random(count)), rng.random(count)
    barycentric = np.stack([1 - along, along * (1 - across), along * across], axis=1)
    return SurfacePoints(face.astype(np.int32), barycentric)


@dataclass(frozen=True)
class SurfaceDistance:
    """Distances of points of one surface from another: their mean, the one that 95 % do not
    exceed, and the largest; in the unit of the meshes."""

    mean: float
    p95: float
    maximum: float

    @classmethod
    def of(cls, distances: Floats) -> SurfaceDistance:
        """Of distances (k,); all 0 of none."""
        if not len(distances):
            return cls(0.0, 0.0, 0.0)
        return cls(
            float(distances.mean()), float(np.quantile(distances, 0.95)), float(distances.max())
        )


def surface_distance(
    a: Mesh, b: Mesh, *, samples: int | None = None, seed: int = 0
) -> SurfaceDistance:
    """How far surface a is from surface b, one way: from points of a to all of b.

    Parameters
    ----------
    samples : measure at so many random places on a, even over its area, in place of at the
        vertices that its faces use.
    seed : for the random places.

    Raises
    ------
    InvalidMesh : b has no faces, or a no area to take samples of; NotFinite for NaN or infinite
        coordinates.
    InvalidInput : ``samples`` is negative.
    """
    require_finite(a)
    points = used_vertices(a) if samples is None else points_on(a, sampled(a, samples, seed))
    return SurfaceDistance.of(ClosestPoints(b).query(points)[1])


def used_vertices(mesh: Mesh) -> Floats:
    """Positions of the vertices that faces use."""
    return np.delete(mesh.vertices, mesh.topology.unused_vertices, axis=0)
