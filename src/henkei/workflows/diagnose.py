"""What a mesh is, and which methods take it as it is."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from henkei.design.refinement import CAGE
from henkei.errors import InvalidMesh
from henkei.geometry import requirements
from henkei.geometry.coincidence import coincident_vertices
from henkei.geometry.intersection import self_intersections
from henkei.geometry.quality import mean_ratio
from henkei.io.model import SET
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh, Surface
from henkei.topology import Ints

SELF_INTERSECTION_LIMIT = 100_000
WORST = 5
NUMBERS = ("node", "element")  # attributes that tell all vertices or faces apart
MOST_VALUES = 1000  # of one label
NO_AREA = 1e-12  # mean ratio up to which a triangle counts as one without area


@dataclass(frozen=True)
class BoundaryLoop:
    """One loop of boundary edges.

    start : a vertex on it.
    vertices : how many vertices it has.
    length : in the unit of the mesh.
    """

    start: int
    vertices: int
    length: float


@dataclass(frozen=True)
class Component:
    """One connected piece (over shared edges).

    genus : number of handles, half the number of cross-caps on a one-sided piece; None where the
        piece is not manifold and the number has no meaning.
    """

    vertices: int
    faces: int
    boundary_loops: int
    genus: float | None


@dataclass(frozen=True)
class Label:
    """A set, a property or another label, by which a recipe may choose a region.

    on : what has it.
    values : each with how many have it; of a set only 1, for what is in it. The first 1,000.
    """

    name: str
    on: Literal["vertices", "faces"]
    values: dict[int, int]


@dataclass(frozen=True)
class MethodUse:
    """Whether a method takes the mesh.

    usable : it does, as the mesh is.
    option : the option of the program with which it does, where it does not otherwise; or "".
    available : this version of henkei has the method.
    reason : why the mesh is not usable, with indices; "" if it is.
    remedy : what to do about it; "" if nothing.
    """

    usable: bool
    option: str
    available: bool
    reason: str
    remedy: str


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What a mesh is; indices count from 0.

    vertices, faces : how many.
    face_sizes : number of faces by their number of corners.
    diagonal : of the bounding box, in the unit of the mesh; NaN where a coordinate is not finite.
    components : the connected pieces, most faces first.
    boundary_loops : the longest first.
    manifold : every edge has at most two faces, every vertex one fan, no face repeats a vertex.
    nonmanifold_edges : (k, 2), edges of more than two faces.
    nonmanifold_vertices : vertices whose faces form more than one fan.
    orientable, oriented : whether windings can agree, and whether they do.
    misoriented_edges : (k, 2), edges whose faces wind against each other.
    degenerate_faces : faces that repeat a vertex.
    faces_without_area : triangles, or polygons with a triangle, of area 0 up to rounding.
    unused_vertices : vertices that no face uses.
    not_finite_vertices : vertices with a NaN or infinite coordinate.
    duplicate_vertices : number of vertices at the very position of an earlier one.
    worst_faces, worst_quality : the faces of lowest mean ratio (1 equilateral, 0 without area).
    self_intersections : (k, 2) pairs of faces, polygons split into triangles; None where it was not
        tested for coordinates that allow no exact answer.
    self_intersections_complete : False if not tested, or the search stopped at 100,000 pairs.
    labels : sets and properties of the file.
    methods : by name, whether it takes the mesh.
    """

    vertices: int
    faces: int
    face_sizes: dict[int, int]
    diagonal: float
    components: tuple[Component, ...]
    boundary_loops: tuple[BoundaryLoop, ...]
    manifold: bool
    nonmanifold_edges: Ints
    nonmanifold_vertices: Ints
    orientable: bool
    oriented: bool
    misoriented_edges: Ints
    degenerate_faces: Ints
    faces_without_area: Ints
    unused_vertices: Ints
    not_finite_vertices: Ints
    duplicate_vertices: int
    worst_faces: Ints
    worst_quality: Floats
    self_intersections: Ints | None
    self_intersections_complete: bool
    labels: tuple[Label, ...]
    methods: dict[str, MethodUse]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain numbers, strings, lists and dicts, fit for JSON (None for NaN)."""
        return {f.name: _plain(getattr(self, f.name)) for f in fields(self)}


def diagnose(mesh: Any) -> Diagnosis:
    """Says what a mesh is, what is wrong with it, and which methods take it as it is.

    Parameters
    ----------
    mesh : a :class:`Mesh`, a :class:`PolygonMesh`, a path, or what :meth:`Mesh.from_any` takes.

    Raises
    ------
    InvalidFile : the path names no readable mesh.
    """
    surface = _surface(mesh)
    topology = surface.topology
    finite = np.isfinite(surface.vertices).all(axis=1)
    quality = _face_quality(surface) if finite.all() else np.empty(0)
    worst = np.argsort(quality, kind="stable")[:WORST].astype(np.int32)
    pairs, complete = _intersecting_faces(surface)
    stands_for = coincident_vertices(surface.vertices)
    sizes, counts = np.unique(np.diff(surface.offsets), return_counts=True)
    return Diagnosis(
        vertices=len(surface.vertices),
        faces=surface.face_count,
        face_sizes=dict(zip(sizes.tolist(), counts.tolist(), strict=True)),
        diagonal=surface.diagonal if finite.all() else float("nan"),
        components=_components(surface),
        boundary_loops=_boundary_loops(surface),
        manifold=topology.is_manifold,
        nonmanifold_edges=topology.nonmanifold_edges,
        nonmanifold_vertices=topology.nonmanifold_vertices,
        orientable=topology.is_orientable,
        oriented=not len(topology.misoriented_edges),
        misoriented_edges=topology.misoriented_edges,
        degenerate_faces=topology.degenerate_faces,
        faces_without_area=np.flatnonzero(quality <= NO_AREA).astype(np.int32),
        unused_vertices=topology.unused_vertices,
        not_finite_vertices=np.flatnonzero(~finite).astype(np.int32),
        duplicate_vertices=int(np.count_nonzero(stands_for != np.arange(len(stands_for)))),
        worst_faces=worst,
        worst_quality=quality[worst],
        self_intersections=pairs,
        self_intersections_complete=complete,
        labels=_labels(surface),
        methods={name: _use(surface, *needs) for name, needs in _METHODS.items()},
    )


def _labels(surface: Surface) -> tuple[Label, ...]:
    """Attributes of integers, but for the numbers that a file gives its nodes and elements."""
    attributes = surface.attributes
    homes: tuple[tuple[Literal["vertices", "faces"], Any], ...] = (
        ("vertices", attributes.vertex),
        ("faces", attributes.face),
    )
    found = []
    for on, table in homes:
        for name, values in table.items():
            if values.ndim != 1 or values.dtype.kind not in "iub" or name in NUMBERS:
                continue
            kinds, counts = np.unique(values, return_counts=True)
            kept = slice(MOST_VALUES) if not name.startswith(SET) else kinds == 1
            counted = zip(kinds[kept].tolist(), counts[kept].tolist(), strict=True)
            found.append(Label(name, on, {int(kind): count for kind, count in counted}))
    return tuple(found)


_Groups = Sequence[Sequence[requirements.Check]]
_TURNABLE: _Groups = [
    *requirements.MEASURABLE_FACES,
    [requirements.manifold],
    [requirements.orientable],
]
# What each method asks for, what it asks for with --fill-holes, and whether it is there yet.
_METHODS: dict[str, tuple[_Groups, _Groups | None, bool]] = {
    "combine": (requirements.DISK, requirements.DISK_WITH_HOLES, True),
    "register": (requirements.SPHERE_WITH_HOLES, None, True),
    "quad": (_TURNABLE, None, True),
    "deform": (requirements.MEASURABLE_FACES, None, True),
    "design": (CAGE, None, True),
}


def _use(surface: Surface, needs: _Groups, filled: _Groups | None, available: bool) -> MethodUse:
    found = requirements.problems(surface, needs)
    fillable = bool(found) and filled is not None and not requirements.problems(surface, filled)
    return MethodUse(
        usable=not found,
        option="--fill-holes" if fillable else "",
        available=available,
        reason="; ".join(problem.reason for problem in found),
        remedy="; ".join(dict.fromkeys(problem.remedy for problem in found)),
    )


def _surface(mesh: Any) -> Surface:
    if isinstance(mesh, Surface):
        return mesh
    if isinstance(mesh, str | os.PathLike):
        from henkei.io import read

        return read(mesh)
    return Mesh.from_any(mesh)


def _triangles(surface: Surface) -> tuple[Mesh, NDArray[np.integer[Any]]]:
    """The surface in triangles, and the face each is of."""
    if isinstance(surface, Mesh):
        return surface, np.arange(surface.face_count)
    numbers = Attributes(face={"face": np.arange(surface.face_count)})
    mesh = PolygonMesh(surface.vertices, surface.faces, attributes=numbers).triangulated()
    return mesh, mesh.attributes.face["face"]


def _face_quality(surface: Surface) -> Floats:
    """Mean ratio of each face's worst triangle; 0 for a face with fewer than three corners."""
    mesh, face = _triangles(surface)
    quality = np.where(np.diff(surface.offsets) < 3, 0.0, 1.0)
    np.minimum.at(quality, face, mean_ratio(mesh))
    return quality


def _intersecting_faces(surface: Surface) -> tuple[Ints | None, bool]:
    """Pairs of faces, and whether these are all."""
    mesh, face = _triangles(surface)
    try:
        pairs = self_intersections(mesh, limit=SELF_INTERSECTION_LIMIT)
    except InvalidMesh:
        return None, False
    faces = np.unique(np.sort(face[pairs], axis=1), axis=0)
    between: Ints = faces[faces[:, 0] != faces[:, 1]].astype(np.int32)
    return between, len(pairs) < SELF_INTERSECTION_LIMIT


def _boundary_loops(surface: Surface) -> tuple[BoundaryLoop, ...]:
    loops = surface.topology.boundary_loops
    lengths = requirements.loop_lengths(surface, loops)
    described = [
        BoundaryLoop(int(loop[0]), len(loop), length)
        for loop, length in zip(loops, lengths, strict=True)
    ]
    return tuple(sorted(described, key=lambda loop: -loop.length))


def _components(surface: Surface) -> tuple[Component, ...]:
    """Counts per component; V - E + F = 2 - 2 genus - loops where it is manifold."""
    topology = surface.topology
    count, of_face = topology.component_count, topology.face_component
    of_vertex = np.full(len(surface.vertices), -1, dtype=np.int32)
    of_vertex[topology.indices] = of_face[topology.face]

    def tally(labels: NDArray[np.integer[Any]]) -> NDArray[np.int64]:
        return np.bincount(labels, minlength=count)

    vertices, faces = tally(of_vertex[of_vertex >= 0]), tally(of_face)
    edges = tally(of_vertex[topology.edges[:, 0]])
    starts = np.array([loop[0] for loop in topology.boundary_loops], dtype=np.int64)
    loops = tally(of_vertex[starts])
    genus = (2 - loops - (vertices - edges + faces)) / 2
    for piece in _nonmanifold_components(surface).tolist():
        genus[piece] = np.nan
    return tuple(
        Component(
            int(vertices[i]),
            int(faces[i]),
            int(loops[i]),
            None if np.isnan(genus[i]) else float(genus[i]),
        )
        for i in np.argsort(-faces, kind="stable")
    )


def _nonmanifold_components(surface: Surface) -> NDArray[np.integer[Any]]:
    topology = surface.topology
    bad = np.zeros(len(surface.vertices), dtype=bool)
    bad[topology.nonmanifold_edges.ravel()] = True
    bad[topology.nonmanifold_vertices] = True
    faces = np.concatenate([topology.face[bad[topology.indices]], topology.degenerate_faces])
    return np.unique(topology.face_component[faces])


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
