"""Embedding any closed surface of genus 0 on the unit sphere, and judging maps onto it.

E. Praun, H. Hoppe: Spherical parametrization and remeshing (2003). A map onto the sphere with
straight edges (arcs of great circles) is injective if it turns no face over and wraps around the
sphere once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from henkei._kernels import embed_sphere
from henkei._kernels import inverted_on_sphere as _inverted
from henkei.errors import Infeasible, InvalidInput, InvalidMesh, NotADisk, NotASphere, some
from henkei.geometry.requirements import (
    ORIENTED,
    Check,
    closed,
    connected,
    finite,
    has_faces,
    no_handles,
    problems,
)
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints

_SPHERE: list[list[Check]] = [[has_faces, finite], *ORIENTED, [connected], [closed], [no_handles]]


def progressive_sphere(
    mesh: Mesh,
    desired: ArrayLike | None = None,
    *,
    area_weight: float = 1.0,
    sweeps: int = 16,
) -> Floats:
    """An injective map of a closed surface of genus 0 onto the unit sphere.

    The mesh is taken apart down to a tetrahedron; its vertices come back one after the other, each
    to a place where no face turns over, and are moved to where the map distorts less: least sum of
    ``area (s/t + t/s) (st + 1/(st))**area_weight`` over the faces, with s, t the singular values of
    their maps. That the map is injective depends on no shape: faces without area and vertices at
    one place do no harm.

    Parameters
    ----------
    mesh : closed, manifold, oriented, connected, of genus 0; no unused vertices.
    desired : (n, 3) directions in which the vertices are wanted, for example of a map that folds.
        Vertices go there as far as no face turns over: a map that is injective comes back as it is.
    area_weight : 1 gives the symmetric Dirichlet energy. More keeps areas better and angles worse;
        less, the other way round: then limbs shrink.
    sweeps : rounds of moves over the vertices at the end, more on coarser levels; 0 leaves every
        vertex where it first found room.

    Returns
    -------
    (n, 3) unit vectors, faces counter-clockwise seen from outside.

    Raises
    ------
    NotFinite, DegenerateFaces, NotManifold, NotOriented, NotClosed, NotASphere; InvalidMesh if a
        vertex is unused.
    InvalidInput : ``desired`` does not fit the mesh, or a setting makes no sense.
    Infeasible : no place for a vertex at the resolution of floating point.
    """
    _check(mesh, area_weight, sweeps)
    directions = np.empty((0, 3)) if desired is None else _directions(desired, len(mesh.vertices))
    if desired is not None and _covers_once(directions, mesh.faces):
        return directions
    span = np.abs(mesh.vertices).max() or 1.0
    points = mesh.vertices / span
    points = points - points.mean(axis=0)
    points /= np.abs(points).max() or 1.0
    twins = mesh.topology.twin
    positions = embed_sphere(points, mesh.faces, twins, directions, area_weight, sweeps)
    if len(positions) == 0:
        raise Infeasible(
            f"the mesh ({len(mesh.vertices)} vertices) cannot be laid on the sphere without "
            "folds at the resolution of floating point; remesh it where its triangles are nested"
        )
    return positions


def inverted_on_sphere(positions: Floats, faces: Ints) -> Ints:
    """Faces that do not run counter-clockwise seen from outside the sphere, or have no area.

    Parameters
    ----------
    positions : (n, 3) of length about 1; what matters are the directions.
    faces : (m, 3).

    Returns
    -------
    (k,) int32, ascending: faces with ``det(a, b, c) <= 0``, decided exactly.
    """
    return _inverted(
        np.ascontiguousarray(positions, dtype=np.float64),
        np.ascontiguousarray(faces, dtype=np.int32),
    )


def turns_around_sphere(positions: Floats, faces: Ints) -> float:
    """How many times the faces wrap around the sphere: their total solid angle by 4 pi.

    For a closed surface this is an integer up to rounding, its degree; 1 is right. Solid angles as
    in A. van Oosterom, J. Strackee: The solid angle of a plane triangle (1983).

    Parameters
    ----------
    positions : (n, 3) unit vectors.
    faces : (m, 3).
    """
    a, b, c = (np.asarray(positions)[faces[:, corner]] for corner in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b - a, c - a))
    rest = 1 + np.einsum("ij,ij->i", a, b) + np.einsum("ij,ij->i", b, c)
    rest += np.einsum("ij,ij->i", c, a)
    return float(2 * np.arctan2(volume, rest).sum() / (4 * np.pi))


def _covers_once(positions: Floats, faces: Ints) -> bool:
    if len(inverted_on_sphere(positions, faces)):
        return False
    return bool(np.isclose(turns_around_sphere(positions, faces), 1))


def _check(mesh: Mesh, area_weight: float, sweeps: int) -> None:
    for problem in problems(mesh, _SPHERE):
        kind = NotASphere if problem.kind is NotADisk else problem.kind
        raise replace(problem, kind=kind).error()
    unused = mesh.topology.unused_vertices
    if len(unused):
        raise InvalidMesh(f"no face uses vertices {some(unused)}; remove them")
    if not 0 < area_weight <= 16:
        raise InvalidInput(f"area_weight must be over 0 and at most 16, not {area_weight}")
    if sweeps < 0:
        raise InvalidInput(f"sweeps must not be negative, not {sweeps}")


def _directions(desired: ArrayLike, count: int) -> Floats:
    given = np.array(desired, dtype=np.float64)
    if given.shape != (count, 3):
        raise InvalidInput(f"desired must have shape ({count}, 3), this has {given.shape}")
    length = np.linalg.norm(given, axis=1)
    bad = np.flatnonzero(~(np.isfinite(length) & (length > 0)))
    if len(bad):
        raise InvalidInput(f"desired gives no direction for vertices {some(bad)}")
    directions: Floats = given / length[:, None]
    return directions
