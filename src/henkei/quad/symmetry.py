"""Quads that are symmetric about a plane: those of one half of the surface, and their images.

The surface is cut along the plane; the vertices of a half's quads on the cut, its seam, stay in the
plane, and there the mirror image is joined on.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import Infeasible, InvalidInput, some
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import ClosestPoints, points_on, sampled, used_vertices
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh
from henkei.quad.components import Component, Quads, joined
from henkei.quad.plane_cut import CutMesh, Plane, cut_along
from henkei.quad.seam import Seam
from henkei.topology import Ints, Topology

Symmetry = Literal["x", "y", "z"] | ArrayLike | None

TOLERANCE = 0.02  # of the diagonal: how far the mirrored surface may be from itself
SAMPLES = 20_000  # places at which that is measured, beside the vertices


@dataclass(frozen=True, eq=False)
class Half:
    """One side of a surface, cut along a plane.

    given : the whole surface.
    mesh : the half: what is above the plane, or below where only that can be completed.
    face : (m,) face of the whole that each face is a piece of.
    weights : (m, 3, 3) barycentric coordinates in it of each corner.
    along : (3 m,) half-edge of the whole that each half-edge is a part of, -1 inside faces.
    seam : (3 m,) bool, boundary half-edges on the cut.
    asymmetry : largest distance of the mirrored surface from itself, as a fraction of the diagonal.
    """

    given: Mesh
    plane: Plane
    mesh: Mesh
    face: Ints
    weights: Floats
    along: Ints
    seam: NDArray[np.bool_]
    asymmetry: float

    @classmethod
    def of(cls, mesh: Mesh, symmetry: Any) -> Self:
        """The half of a surface on one side of ``"x"``, ``"y"`` or ``"z"``, the plane with that
        normal through the centroid; or of a plane given by a point and a normal.

        Raises
        ------
        InvalidInput : there is no such plane, or the surface is not symmetric about it.
        Infeasible : neither half and its mirror image make a surface of the same topology.
        """
        plane = Plane.of(mesh, symmetry)
        asymmetry = _checked_asymmetry(mesh, plane)
        cut = cut_along(mesh, plane)
        failures = []
        for kept in (cut.above, ~cut.above):
            failure, half = cls._kept(mesh, plane, cut, kept, asymmetry)
            if half is not None and not failure:
                return half
            failures.append(failure)
        raise Infeasible(
            "the surface is nearly symmetric, but not in its topology: mirrored, the part above "
            f"the plane of symmetry {failures[0]}, and the part below {failures[1]}; choose "
            "another plane, or mend the surface where it differs from its mirror image"
        )

    @classmethod
    def _kept(
        cls, given: Mesh, plane: Plane, cut: CutMesh, kept: NDArray[np.bool_], asymmetry: float
    ) -> tuple[str, Self | None]:
        """The faces kept as a half; or why they cannot be one."""
        if not kept.any():
            return "is empty", None
        used, number = np.unique(cut.mesh.faces[kept], return_inverse=True)
        mesh = Mesh(cut.mesh.vertices[used], number.reshape(-1, 3).astype(np.int32))
        touching = mesh.topology.nonmanifold_vertices
        if len(touching):
            places = [tuple(p) for p in mesh.vertices[touching].round(6).tolist()]
            return f"only touches itself at {some(places, 3)}", None
        rows = np.repeat(kept, 3)
        seam = (mesh.topology.twin < 0) & (cut.mesh.topology.twin[rows] >= 0)
        half = cls(
            given, plane, mesh, cut.face[kept], cut.weights[kept], cut.along[rows], seam, asymmetry
        )
        on_seam = np.zeros(len(mesh.vertices), dtype=bool)
        on_seam[mesh.indices[seam]] = on_seam[mesh.topology.target[seam]] = True
        whole = Mesh(*_doubled(plane, mesh.vertices, mesh.faces, on_seam)[:2])
        return _difference(whole.topology, given.topology), half

    def pull(self, values: Floats) -> Floats:
        """Values at the vertices of the whole as values at those of the half."""
        corner = np.zeros(len(self.mesh.vertices), dtype=np.int64)
        corner[self.mesh.indices] = np.arange(len(self.mesh.indices))
        places = SurfacePoints(self.face[corner // 3], self.weights.reshape(-1, 3)[corner])
        pulled: Floats = places.pull(self.given, values)
        return pulled

    def carried(self, feature: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Features (half-edges of the whole) as half-edges of the half; its boundary is feature."""
        own = np.where(self.along >= 0, feature[self.along], False)
        carried: NDArray[np.bool_] = own | (self.mesh.topology.twin < 0)
        return carried

    def on_given(self, places: SurfacePoints) -> SurfacePoints:
        """Places on the half as places on the whole."""
        weights = np.einsum("nk,nkj->nj", places.barycentric, self.weights[places.face])
        return SurfacePoints(self.face[places.face], weights)

    def seam_of(self, component: Component) -> Seam:
        """Where a component of the half is cut."""
        rows = (3 * component.faces[:, None] + np.arange(3)).ravel()
        return Seam(component.mesh, self.seam[rows])

    def doubled(
        self, parts: Sequence[Component], made: Sequence[Quads], feature: NDArray[np.bool_]
    ) -> Quads:
        """The quads of all components of the half together with their mirror images.

        feature : half-edges of the whole, so that creases in the plane are told from the seam.

        Raises
        ------
        Infeasible : they do not have the topology of the whole.
        """
        half = joined(parts, made)
        seams = [self.seam_of(one) for one in parts]
        edges = _seam_edges(seams, [(q.vertices, q.faces) for q in made])
        layout_edges = _seam_edges(seams, [(q.layout.vertices, q.layout.faces) for q in made])
        on_seam = _marked(len(half.vertices), edges)
        vertices, faces, image = _doubled(self.plane, half.vertices, half.faces, on_seam)
        difference = _difference(PolygonMesh(vertices, faces).topology, self.given.topology)
        if difference:
            raise Infeasible(
                f"the quads and their mirror images are no surface like the input: it {difference}"
                "; ask for more quads"
            )
        return Quads(
            vertices=vertices,
            faces=faces.astype(np.int32),
            patch=_numbered_on(half.patch),
            uv=np.concatenate([half.uv, half.uv[:, ::-1, ::-1]]),
            on_surface=self._places(half.on_surface, vertices[len(on_seam) :], ~on_seam),
            features=self._features(half, edges, image, feature),
            layout=self._layout(half.layout, layout_edges),
            way=half.way,
            injective=half.injective,
        )

    def _places(
        self, places: SurfacePoints, images: Floats, of: NDArray[np.bool_]
    ) -> SurfacePoints:
        """Places on the whole: those of the half, and for the images of some of its vertices the
        nearest where the whole faces as their mirrored surroundings do."""
        own = self.on_given(places)
        normals = self.given.face_normals[own.face[of]]
        turned = normals - 2 * (normals @ self.plane.normal)[:, None] * self.plane.normal
        slack = (self.asymmetry + 1e-9) * self.given.diagonal
        other = _facing(self.given, images, turned, slack)
        return SurfacePoints(
            np.concatenate([own.face, other.face]).astype(np.int32),
            np.concatenate([own.barycentric, other.barycentric]),
        )

    def _features(self, half: Quads, edges: Ints, image: Ints, feature: NDArray[np.bool_]) -> Ints:
        """Features of the half and their images; of the seam only what is a crease of the whole."""
        features = np.sort(half.features, axis=1)
        crease = self._on_crease(half.vertices[edges].mean(axis=1), feature)
        key = features.astype(np.int64) @ [len(half.vertices), 1]
        smooth = np.sort(edges[~crease], axis=1).astype(np.int64) @ [len(half.vertices), 1]
        features = features[~np.isin(key, smooth)]
        both = np.concatenate([features, image[features]])
        return np.unique(np.sort(both, axis=1), axis=0).astype(np.int32)

    def _on_crease(self, points: Floats, feature: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether points (k, 3) on the seam lie where it runs along features of the whole."""
        if not len(points):
            return np.zeros(0, dtype=bool)
        rows = np.flatnonzero(self.seam)
        ends = np.stack([self.mesh.indices[rows], self.mesh.topology.target[rows]], axis=1)
        lines = ClosestPoints(Mesh(self.mesh.vertices, ends[:, [0, 1, 1]]))
        along = self.along[rows]
        crease = np.where(along >= 0, feature[along], False)
        on_crease: NDArray[np.bool_] = crease[lines.query(points)[0].face]
        return on_crease

    def _layout(self, layout: Mesh, edges: Ints) -> Mesh:
        """The layout and its mirror image."""
        on_seam = _marked(len(layout.vertices), edges)
        vertices, faces, _ = _doubled(self.plane, layout.vertices, layout.faces, on_seam)
        uv = layout.attributes.corner["uv"].reshape(-1, 3, 2)
        both = np.concatenate([uv, uv[:, ::-1, ::-1]]).reshape(-1, 2)
        patch = _numbered_on(layout.attributes.face["patch"])
        return Mesh(
            vertices, faces, attributes=Attributes(corner={"uv": both}, face={"patch": patch})
        )


def _checked_asymmetry(mesh: Mesh, plane: Plane) -> float:
    """Largest distance of the mirrored mesh from itself, as a fraction of the diagonal."""
    points = np.concatenate([used_vertices(mesh), points_on(mesh, sampled(mesh, SAMPLES))])
    distance = ClosestPoints(mesh).query(plane.mirrored(points))[1]
    worst = int(distance.argmax())
    asymmetry = float(distance[worst] / mesh.diagonal)
    if asymmetry > TOLERANCE:
        raise InvalidInput(
            f"the surface is not symmetric about the plane through {_text(plane.point)} with "
            f"normal {_text(plane.normal)}: the mirror image of its point {_text(points[worst])} "
            f"is {asymmetry:.2%} of the diagonal away from it, more than the {TOLERANCE:.0%} "
            "allowed; give the plane as a point and a normal, or make the surface symmetric"
        )
    return asymmetry


def _text(point: Floats) -> str:
    return "(" + ", ".join(f"{x:.6g}" for x in point) + ")"


def _doubled(
    plane: Plane, vertices: Floats, faces: Ints, on_seam: NDArray[np.bool_]
) -> tuple[Floats, Ints, Ints]:
    """Vertices and faces together with their mirror images, and the image (n,) of each vertex.

    Vertices of the seam are their own images. The corners of an image are in reverse order.
    """
    count = len(vertices)
    image = np.where(on_seam, np.arange(count), count + np.cumsum(~on_seam) - 1)
    kept = np.where(on_seam[:, None], plane.put(vertices), vertices)
    both = np.concatenate([kept, plane.mirrored(vertices[~on_seam])])
    return both, np.concatenate([faces, image[faces][:, ::-1]]).astype(np.int32), image


def _difference(made: Topology, given: Topology) -> str:
    """What keeps a surface from being of the topology of another, empty if nothing does."""
    if not made.is_manifold:
        return "is not manifold"
    if len(made.misoriented_edges):
        return "has faces that wind against each other"
    figures = {
        "an Euler number of": (made.euler_characteristic, given.euler_characteristic),
        "as number of boundary loops": (len(made.boundary_loops), len(given.boundary_loops)),
        "as number of pieces": (made.component_count, given.component_count),
    }
    found = [
        f"{name} {now} in place of {due}" for name, (now, due) in figures.items() if now != due
    ]
    return "has " + ", ".join(found) if found else ""


def _seam_edges(seams: Sequence[Seam], meshes: Sequence[tuple[Floats, Ints]]) -> Ints:
    """Edges (k, 2) on the seams of all components, whose vertices are numbered through."""
    first = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])[:-1].tolist()
    rows = [
        seam.edges(vertices, faces) + start
        for seam, (vertices, faces), start in zip(seams, meshes, first, strict=True)
    ]
    return np.concatenate(rows).astype(np.int32)


def _marked(count: int, edges: Ints) -> NDArray[np.bool_]:
    marked = np.zeros(count, dtype=bool)
    marked[edges] = True
    return marked


def _numbered_on(patch: Ints) -> Ints:
    """Patches (q,) and as many again with other numbers."""
    return np.concatenate([patch, patch + int(patch.max()) + 1]).astype(np.int32)


def _facing(surface: Mesh, points: Floats, normals: Floats, slack: float) -> SurfacePoints:
    """Nearest places to points (n, 3); where the surface faces against the normals (n, 3) there,
    the nearest of the faces that do not face against their largest coordinate, unless these are
    further away by more than ``slack``."""
    places, distance = ClosestPoints(surface).query(points)
    face, weights = places.face.copy(), places.barycentric.copy()
    wrong = (surface.face_normals[face] * normals).sum(axis=1) < 0
    axis = np.abs(normals).argmax(axis=1)
    sign = np.sign(normals[np.arange(len(normals)), axis])
    for number, towards in itertools.product(range(3), (1, -1)):
        rows = np.flatnonzero(wrong & (axis == number) & (sign == towards))
        faces = np.flatnonzero(surface.face_normals[:, number] * towards > 0)
        if len(rows) and len(faces):
            facing = ClosestPoints(Mesh(surface.vertices, surface.faces[faces]))
            found, there = facing.query(points[rows])
            near = there <= distance[rows] + slack
            face[rows[near]] = faces[found.face[near]]
            weights[rows[near]] = found.barycentric[near]
    return SurfacePoints(face, weights)
