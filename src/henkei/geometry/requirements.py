"""What methods ask of a mesh, each said once.

A *check* takes a surface and answers with a :class:`Problem`, or with None where all is well. The
``require_...`` functions raise the first problem as a typed error; ``henkei.diagnose`` lists the
same problems without raising. Checks come in groups: those of one group may be asked together,
and mean something only when all earlier groups passed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from henkei.errors import (
    DegenerateFaces,
    InvalidInput,
    InvalidMesh,
    NotADisk,
    NotASphere,
    NotClosed,
    NotFinite,
    NotManifold,
    NotOriented,
    some,
)
from henkei.geometry.coincidence import coincident_vertices
from henkei.mesh import Floats, Surface
from henkei.topology import Ints


@dataclass(frozen=True)
class Problem:
    """Why a surface does not serve.

    kind : the error to raise.
    reason : what is wrong and where (indices count from 0).
    remedy : what to do about it.
    """

    kind: type[InvalidMesh]
    reason: str
    remedy: str

    def error(self) -> InvalidMesh:
        """The error that says this problem."""
        return self.kind(f"{self.reason}; {self.remedy}")


Check = Callable[[Surface], Problem | None]

LEAST, MOST = 1e-100, 1e100  # extent, so that squares of lengths neither vanish nor overflow
NO_AREA = 1e-14  # of a face by the square of its longest edge
_AT_ONCE = 1 << 14  # faces, so that what is computed of them stays in the cache
ROUNDING = 1e-12  # extent by distance from the origin


def problems(surface: Surface, groups: Sequence[Sequence[Check]]) -> list[Problem]:
    """All problems of the first group of checks that finds any."""
    for group in groups:
        found = [problem for check in group if (problem := check(surface))]
        if found:
            return found
    return []


def require_finite(surface: Surface) -> None:
    """Raise :class:`NotFinite` if a coordinate is NaN or infinite."""
    _require(surface, [[finite]])


def require_manifold(surface: Surface) -> None:
    """Every edge has one or two faces, the faces of every vertex form one fan, no face repeats a
    vertex.

    Raises
    ------
    DegenerateFaces, NotManifold
    """
    _require(surface, MANIFOLD)


def require_oriented(surface: Surface) -> None:
    """The surface is manifold and all faces wind the same way around.

    Raises
    ------
    DegenerateFaces, NotManifold, NotOriented
    """
    _require(surface, ORIENTED)


def require_disk(surface: Surface) -> None:
    """The surface is finite, manifold, oriented and connected, and has exactly one boundary
    loop and no handle.

    Raises
    ------
    NotFinite, DegenerateFaces, NotManifold, NotOriented, NotADisk; InvalidMesh for extreme scales
    """
    _require(surface, DISK)


def require_disk_with_holes(surface: Surface) -> None:
    """Like :func:`require_disk`, but with any number of boundary loops, at least one.

    Raises
    ------
    NotFinite, DegenerateFaces, NotManifold, NotOriented, NotADisk; InvalidMesh for extreme scales
    """
    _require(surface, DISK_WITH_HOLES)


def require_sphere_with_holes(surface: Surface) -> None:
    """The surface is finite, manifold, oriented and connected and has no handle; it may have
    boundary loops.

    Raises
    ------
    NotFinite, DegenerateFaces, NotManifold, NotOriented, NotASphere; InvalidMesh for extreme scales
    """
    try:
        _require(surface, SPHERE_WITH_HOLES)
    except NotADisk as error:
        raise NotASphere(str(error)) from None


def require_measurable_faces(surface: Surface) -> None:
    """Raise unless the surface has faces, each with finite positions and an area.

    Raises
    ------
    NotADisk, NotFinite, DegenerateFaces, InvalidMesh
    """
    _require(surface, MEASURABLE_FACES)


def require_measurable_displacement(displacement: Floats) -> None:
    """Raise unless vertices are moved (n, 3) by what can be squared.

    Raises
    ------
    InvalidInput
    """
    if not np.abs(displacement).max(initial=0.0) <= MOST:
        raise InvalidInput(
            "the surface is moved so far that lengths overflow; bring the handles, pins and scales "
            "to numbers of the mesh's own size"
        )


def has_faces(surface: Surface) -> Problem | None:
    """At least one face."""
    if surface.face_count:
        return None
    return Problem(NotADisk, "the mesh has no faces", "give a surface mesh, not a point cloud")


def finite(surface: Surface) -> Problem | None:
    """No NaN, no infinity in vertices that faces use."""
    wrong = np.asarray(~np.isfinite(surface.vertices).all(axis=1))
    wrong[surface.topology.unused_vertices] = False
    bad = np.flatnonzero(wrong)
    if not len(bad):
        return None
    return Problem(
        NotFinite,
        f"{_count(len(bad), 'vertex', 'vertices')} {_have(len(bad))} NaN or infinite coordinates: "
        f"{some(bad)}",
        "remove them and their faces, or give them positions",
    )


def measurable(surface: Surface) -> Problem | None:
    """Neither so large, so small nor so far from the origin that lengths drown in rounding."""
    is_used = np.zeros(len(surface.vertices), dtype=bool)
    is_used[surface.indices] = True
    used = surface.vertices[is_used]
    with np.errstate(over="ignore"):
        extent = float(np.ptp(used, axis=0).max()) if len(used) else 0.0
    farthest = float(np.abs(used).max()) if len(used) else 0.0
    if LEAST <= extent <= MOST and farthest < extent / ROUNDING:
        return None
    return Problem(
        InvalidMesh,
        f"the mesh is {extent:.3g} long and up to {farthest:.3g} from the origin: its edges "
        "cannot be measured in double precision",
        "scale it to a sensible size, or move it to the origin before its digits are lost",
    )


def not_degenerate(surface: Surface) -> Problem | None:
    """No face repeats a vertex or has fewer than three corners."""
    bad = surface.topology.degenerate_faces
    if not len(bad):
        return None
    return Problem(
        DegenerateFaces,
        f"{_count(len(bad), 'face')} {'repeat' if len(bad) > 1 else 'repeats'} a vertex: "
        f"{some(bad)}",
        "henkei.without_degenerate_faces(mesh) removes them",
    )


def with_area(surface: Surface) -> Problem | None:
    """No face has zero area, up to rounding."""
    starts = range(0, surface.face_count, _AT_ONCE)
    bad = np.concatenate([[], *(_without_area(surface, start) for start in starts)]).astype(int)
    if not len(bad):
        return None
    return Problem(
        DegenerateFaces,
        f"{_count(len(bad), 'face')} {_have(len(bad))} no area: {some(bad)}",
        "henkei.without_degenerate_faces(mesh) removes those that repeat a vertex; collapse or "
        "flip an edge of the others",
    )


def _without_area(surface: Surface, start: int) -> NDArray[np.intp]:
    """Those of the faces from ``start`` on, as many as are looked at together, that have none."""
    bounds = surface.offsets[start : start + _AT_ONCE + 1]
    corners, first = slice(bounds[0], bounds[-1]), bounds[:-1] - bounds[0]
    places = surface.vertices[surface.indices[corners]]
    ends = surface.vertices[surface.topology.target[corners]] - places
    longest = np.maximum.reduceat(np.einsum("hi,hi->h", ends, ends), first)
    spokes = places - places[first][surface.topology.face[corners] - start]
    crosses = np.cross(spokes, spokes + ends)
    area = np.linalg.norm(np.add.reduceat(crosses, first), axis=1)
    return start + np.flatnonzero(area <= NO_AREA * longest)


def manifold(surface: Surface) -> Problem | None:
    """At most two faces an edge, one fan of faces a vertex."""
    edges, vertices = surface.topology.nonmanifold_edges, surface.topology.nonmanifold_vertices
    found = []
    if len(edges):
        found.append(
            f"more than two faces share {_count(len(edges), 'edge')} "
            f"(between vertices {some(_pairs(edges))})"
        )
    if len(vertices):
        found.append(
            f"faces meet only in a point at {_count(len(vertices), 'vertex', 'vertices')}: "
            f"{some(vertices)}"
        )
    if not found:
        return None
    return Problem(
        NotManifold,
        "the surface is not manifold: " + ", and ".join(found),
        "remove the extra faces or split the surface there",
    )


def orientable(surface: Surface) -> Problem | None:
    """The faces can be turned so that all wind the same way around."""
    if surface.topology.is_orientable:
        return None
    return Problem(
        NotOriented,
        "the surface is one-sided (as a Moebius strip is), no winding of its faces agrees",
        "cut it open first",
    )


def oriented(surface: Surface) -> Problem | None:
    """All faces wind the same way around."""
    edges = surface.topology.misoriented_edges
    if not len(edges):
        return None
    return orientable(surface) or Problem(
        NotOriented,
        f"neighbouring faces wind against each other at {_count(len(edges), 'edge')} "
        f"(between vertices {some(_pairs(edges))})",
        "henkei.oriented(mesh) turns them",
    )


def connected(surface: Surface) -> Problem | None:
    """One piece."""
    count = surface.topology.component_count
    if count == 1:
        return None
    sizes = sorted(np.bincount(surface.topology.face_component).tolist(), reverse=True)
    return Problem(
        NotADisk,
        f"the mesh has {count} separate pieces, of {some(sizes)} faces",
        _weld_first(surface) + "henkei.largest_component(mesh) keeps the largest",
    )


def has_boundary(surface: Surface) -> Problem | None:
    """At least one boundary loop."""
    if surface.topology.boundary_loops:
        return None
    return Problem(
        NotADisk,
        "the surface is closed, it has no boundary loop",
        "cut it open (remove the faces of one region)",
    )


def one_loop(surface: Surface) -> Problem | None:
    """At most one boundary loop."""
    loops = surface.topology.boundary_loops
    if len(loops) < 2:
        return None
    described = [
        f"{length:.4g} ({len(loop)} vertices)"
        for length, loop in sorted(
            zip(loop_lengths(surface, loops), loops, strict=True), key=lambda pair: -pair[0]
        )
    ]
    return Problem(
        NotADisk,
        f"the surface has {len(loops)} boundary loops, of length {some(described)}",
        _weld_first(surface)
        + f"close {_count(len(loops) - 1, 'loop')} with --fill-holes, the longest stays open",
    )


def no_handles(surface: Surface) -> Problem | None:
    """Genus 0."""
    genus = surface.topology.genus
    if not genus:
        return None
    return Problem(
        NotADisk,
        f"the surface has {_count(round(genus), 'handle')} (genus {genus:g})",
        "cut the handles or fill their tunnels",
    )


def closed(surface: Surface) -> Problem | None:
    """No boundary."""
    loops = surface.topology.boundary_loops
    if not loops:
        return None
    return Problem(
        NotClosed,
        f"the surface has {_count(len(loops), 'boundary loop')}",
        "close them with --fill-holes",
    )


def loop_lengths(surface: Surface, loops: Sequence[Ints]) -> list[float]:
    """Length of each closed loop of vertices, in the unit of the mesh."""
    return [_loop_length(surface.vertices[loop]) for loop in loops]


def _loop_length(points: Floats) -> float:
    return float(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1).sum())


def _require(surface: Surface, groups: Sequence[Sequence[Check]]) -> None:
    for group in groups:
        for check in group:
            problem = check(surface)
            if problem:
                raise problem.error()


def _weld_first(surface: Surface) -> str:
    first = coincident_vertices(surface.vertices)
    duplicates = int(np.count_nonzero(first != np.arange(len(first))))
    if not duplicates:
        return ""
    return f"weld the {_count(duplicates, 'duplicate vertex', 'duplicate vertices')} first: " + (
        "henkei.weld(mesh); or "
    )


def _count(number: int, singular: str, plural: str | None = None) -> str:
    return f"{number:,} {singular if number == 1 else plural or singular + 's'}"


def _have(number: int) -> str:
    return "has" if number == 1 else "have"


def _pairs(edges: Ints) -> list[str]:
    return [f"{a}-{b}" for a, b in edges.tolist()]


MANIFOLD: list[list[Check]] = [[not_degenerate], [manifold]]
ORIENTED: list[list[Check]] = [*MANIFOLD, [oriented]]
MEASURABLE_FACES: list[list[Check]] = [
    [has_faces, finite],
    [measurable],
    [not_degenerate],
    [with_area],
]
_PIECE: list[list[Check]] = [[has_faces, finite], [measurable], *ORIENTED, [connected]]
DISK_WITH_HOLES: list[list[Check]] = [*_PIECE, [has_boundary, no_handles]]
DISK: list[list[Check]] = [*_PIECE, [has_boundary, no_handles, one_loop]]
SPHERE_WITH_HOLES: list[list[Check]] = [*_PIECE, [no_handles]]
