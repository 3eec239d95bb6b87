"""Isotropic remeshing: triangles of a wished size on the same surface, its features kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei._kernels import Remeshing as _Remeshing
from henkei.errors import InvalidInput, some
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import points_on
from henkei.geometry.requirements import ORIENTED, Check, finite, has_faces, measurable, problems
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, silent

MOST_FACES = 50_000_000
_POLISHING = 3  # rounds after the features have been set apart


@dataclass(frozen=True, eq=False)
class Remeshed:
    """A remeshed surface, and where it lies on the one it was made from.

    mesh : the new mesh, homeomorphic to the input; it has no attributes.
    feature : (3 m',) bool, half-edges of the new mesh on a feature or a boundary, on both sides.
    on_input : where each new vertex lies on the input.
    corner : (n',) bool, vertices that are corners of features: kept vertices of the input where
        other than two feature edges meet, or where the line turns by more than 45 degrees.
    """

    mesh: Mesh
    feature: NDArray[np.bool_]
    on_input: SurfacePoints
    corner: NDArray[np.bool_]


def remeshed(
    mesh: Mesh,
    edge_length: ArrayLike,
    *,
    feature: ArrayLike | None = None,
    iterations: int = 6,
    progress: Progress = silent,
) -> Remeshed:
    """The surface in triangles as equilateral as they can be, with edges of about a wished length.

    Long edges are split, short ones collapsed, others flipped, and vertices moved along the
    surface (M. Botsch, L. Kobbelt: A remeshing approach to multiresolution modeling, 2004). No
    change alters the topology, turns a face over against the input, or takes the surface away from
    it by more than about a tenth of an edge: thin and curved parts keep shorter edges than wished.
    Vertices end on the input surface, those of features on their feature line. No triangle has two
    feature edges, and no other edge joins two vertices of features.

    Parameters
    ----------
    mesh : manifold and oriented, open or closed, of any genus, in any number of pieces. Slivers
        and faces without area are allowed.
    edge_length : wished length of edges, in the unit of the mesh; or one (n,) at each vertex.
    feature : (3 m,) bool, half-edges that lie on lines to be kept. One side of an edge is enough.
        Boundaries are always kept.
    iterations : rounds of the four steps.

    Raises
    ------
    InvalidMesh : the mesh is not finite, manifold and oriented.
    InvalidInput : lengths that are not positive, or so small that more than 50 million faces would
        result; ``feature`` of another shape; a negative number of iterations.
    """
    for problem in problems(mesh, _NEEDED):
        raise problem.error()
    if iterations < 0:
        raise InvalidInput(f"the number of iterations must not be negative, it is {iterations}")
    length = _lengths(mesh, edge_length)
    # Near the origin and about 1 long; scaled by a power of two, which is exact.
    exponent = int(np.frexp(mesh.diagonal)[1])
    used = mesh.vertices[mesh.indices]
    centre = used.min(axis=0) + np.ptp(used, axis=0) / 2
    work = _Remeshing(
        np.ldexp(mesh.vertices - centre, -exponent),
        mesh.faces,
        mesh.topology.twin,
        _features(mesh, feature).view(np.uint8),
        np.ldexp(length, -exponent),
    )
    rounds = iterations + _POLISHING
    for step in range(iterations):
        progress("remeshing", step / rounds)
        if step == 0:  # long slivers are many; what splitting them would make are more
            work.collapse_short()
        if not work.split_long(MOST_FACES):
            raise _too_many(length)
        work.collapse_short()
        work.flip()
        work.relax()
    work.separate()
    for step in range(iterations, rounds):
        progress("remeshing", step / rounds)
        work.flip()
        work.relax()
    faces, on_feature, on_face, weights, corner = work.result()
    places = SurfacePoints(on_face, weights)
    return Remeshed(
        Mesh(points_on(mesh, places), faces),
        on_feature.view(np.bool_),
        places,
        corner.view(np.bool_),
    )


def _lengths(mesh: Mesh, edge_length: ArrayLike) -> Floats:
    """Wished length at each vertex (n,), checked."""
    given = np.asarray(edge_length, dtype=np.float64)
    if given.shape not in {(), (len(mesh.vertices),)}:
        raise InvalidInput(
            f"the edge length must be one number or one for each of {len(mesh.vertices)} vertices, "
            f"it has shape {given.shape}"
        )
    length = np.array(np.broadcast_to(given, len(mesh.vertices)))
    used = np.ones(len(length), dtype=bool)
    used[mesh.topology.unused_vertices] = False
    bad = np.flatnonzero(used & ~((length > 0) & np.isfinite(length)))
    if len(bad):
        raise InvalidInput(
            f"edge lengths must be positive, at vertices {some(bad)} they are {some(length[bad])}"
        )
    length[~used] = length[used].max()
    if 2 * float((mesh.face_areas / length[mesh.faces].mean(axis=1) ** 2).sum()) > MOST_FACES:
        raise _too_many(length)
    return length


def _too_many(length: Floats) -> InvalidInput:
    return InvalidInput(
        f"edges as short as {float(length.min()):.3g} would make more than {MOST_FACES:,} faces; "
        "ask for longer ones"
    )


def _features(mesh: Mesh, feature: ArrayLike | None) -> NDArray[np.bool_]:
    """Half-edges on features (3 m,), both sides of each, and all boundaries."""
    twin = mesh.topology.twin
    lines = np.zeros(len(twin), dtype=bool) if feature is None else np.array(feature, dtype=bool)
    if lines.shape != twin.shape:
        raise InvalidInput(
            f"feature must have one entry for each of {len(twin)} half-edges, "
            f"it has shape {lines.shape}"
        )
    marked: NDArray[np.bool_] = lines | (twin < 0)
    marked |= marked[twin]  # of a boundary the last entry is taken; it is marked as it is
    return marked


_NEEDED: list[list[Check]] = [[has_faces, finite], [measurable], *ORIENTED]
