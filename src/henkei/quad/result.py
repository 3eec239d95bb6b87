"""The result: a mesh of quads only, and how it lies on the surface it was made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.element_quality import element_quality
from henkei.io.scene import Colouring, Mark, Scene
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh
from henkei.quad.cleanup import irregular
from henkei.quad.quality import QuadQuality
from henkei.showing import Showing
from henkei.topology import Ints

IRREGULAR = ("#d9485a", "#3f7fd6")  # colours of dots where fewer and where more quads meet
MOST_MARKS = 400


@dataclass(frozen=True, eq=False, repr=False)
class QuadResult(Showing):
    """Quads on a surface. Made by :func:`henkei.quadrangulate`.

    mesh : quads (q, 4), counter-clockwise like the input; corner attribute ``uv``, face attribute
        ``patch``.
    patches : (q,) patch of the layout that each quad comes from.
    uv : (q, 4, 2) coordinates of each quad's corners in the rectangle of its patch, in quads; in
        patches of other than four corners, in a regular polygon.
    on_input : place of each vertex on the input: face and barycentric coordinates.
    features : (k, 2) vertices of the edges that lie on creases and boundaries.
    layout : the triangle mesh that was cut into patches, with face attribute ``patch`` and corner
        attribute ``uv``: the maps whose isolines the quads are, before they were relaxed.
    """

    mesh: PolygonMesh
    on_input: SurfacePoints
    features: Ints
    layout: Mesh
    quality: QuadQuality

    def _scene_(self) -> Scene:
        """The quads with lines between patches, and dots where other than four meet."""
        mesh = self.mesh
        quads: Ints = np.asarray(mesh.faces)
        jacobian = element_quality(mesh).scaled_jacobian
        off = np.flatnonzero(irregular(mesh.vertices, quads))
        few = np.bincount(quads.ravel())[off] < 4
        colours = np.where(few, *IRREGULAR).tolist()
        return Scene(
            mesh,
            (
                Colouring("patch", "face", self.patches.astype(float), "categorical"),
                Colouring("scaled Jacobian", "face", jacobian, "quality", (0.0, 1.0)),
            ),
            shown=0,
            marks=tuple(map(Mark, off.tolist(), [""] * len(off), colours))[:MOST_MARKS],
            creases=np.concatenate([self._between_patches(), self.features.reshape(-1, 2)]),
        )

    def _between_patches(self) -> Ints:
        """Edges (k, 2) between quads of two patches, and on the boundary."""
        topology = self.mesh.topology
        twin, patch = topology.twin, self.patches
        beyond = np.where(twin >= 0, patch[topology.face[twin]], -1)
        at = np.flatnonzero(patch[topology.face] > beyond)
        return np.stack([topology.indices[at], topology.target[at]], axis=1)

    @property
    def patches(self) -> Ints:
        """Patch (q,) of each quad."""
        patches: Ints = self.mesh.attributes.face["patch"]
        return patches

    @property
    def uv(self) -> Floats:
        """Coordinates (q, 4, 2) of each quad's corners in the domain of its patch."""
        uv: Floats = self.mesh.attributes.corner["uv"].reshape(-1, 4, 2)
        return uv

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything as arrays by name, for a file; :meth:`from_arrays` undoes it.

        But for the seconds, so that equal quads give equal arrays.
        """
        layout = self.layout
        arrays: dict[str, NDArray[Any]] = {
            "vertices": self.mesh.vertices,
            "faces": np.asarray(self.mesh.faces),
            "patch": self.patches,
            "uv": self.uv,
            "on_input.face": self.on_input.face,
            "on_input.barycentric": self.on_input.barycentric,
            "features": self.features,
            "layout.vertices": layout.vertices,
            "layout.faces": layout.faces,
            "layout.patch": layout.attributes.face["patch"],
            "layout.uv": layout.attributes.corner["uv"].reshape(-1, 3, 2),
        }
        return arrays | {f"quality.{n}": np.array(getattr(self.quality, n)) for n in _FIGURES}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> QuadResult:
        """The result that :meth:`to_arrays` took apart.

        Raises
        ------
        InvalidFile : an array is missing, names vertices that do not exist, or is no figure.
        InvalidMesh : a face names a vertex that does not exist.
        """
        try:
            mesh = quad_mesh(*(arrays[name] for name in ("vertices", "faces", "patch", "uv")))
            layout = layout_mesh(
                *(arrays[f"layout.{name}"] for name in ("vertices", "faces", "patch", "uv"))
            )
            places = SurfacePoints(arrays["on_input.face"], arrays["on_input.barycentric"])
            features, figures = arrays["features"], {n: arrays[f"quality.{n}"] for n in _FIGURES}
        except KeyError as missing:
            raise InvalidFile(f"not a whole result of quads: {missing} is missing") from None
        if not np.isin(features, np.arange(len(mesh.vertices))).all():
            raise InvalidFile("features names vertices that do not exist")
        wrong = [name for name, figure in figures.items() if figure.ndim]
        if wrong:
            raise InvalidFile(f"quality.{wrong[0]} is not one figure")
        quality = QuadQuality(**{name: figure.item() for name, figure in figures.items()})
        return cls(mesh, places, features, layout, quality)

    def __repr__(self) -> str:
        q = self.quality
        return f"QuadResult({q.quads} quads, {q.irregular} irregular vertices, {q.layout} layout)"


def quad_mesh(vertices: Floats, faces: Ints, patch: Ints, uv: Floats) -> PolygonMesh:
    """Quads with their patches and coordinates as attributes."""
    attributes = Attributes(corner={"uv": np.reshape(uv, (-1, 2))}, face={"patch": patch})
    return PolygonMesh(vertices, faces, attributes=attributes)


def layout_mesh(vertices: Floats, faces: Ints, patch: Ints, uv: Floats) -> Mesh:
    """Triangles with their patches and coordinates as attributes."""
    attributes = Attributes(corner={"uv": np.reshape(uv, (-1, 2))}, face={"patch": patch})
    return Mesh(vertices, faces, attributes=attributes)


_FIGURES = [name for name in QuadQuality.__dataclass_fields__ if name != "seconds"]
