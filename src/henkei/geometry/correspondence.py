"""One connectivity, two surfaces: what every method that relates two shapes ends in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.io.scene import Scene, Slide, offered
from henkei.mesh import Attributes, Floats, Mesh
from henkei.showing import Showing
from henkei.topology import Ints


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Places on a triangle mesh.

    face : (n,) int32, face of the mesh; -1 where the place has none (a filled hole, say).
    barycentric : (n, 3) float64, weights of that face's three vertices, each row sums to 1; all 0
        where there is no face.
    """

    face: Ints
    barycentric: Floats

    def __len__(self) -> int:
        return len(self.face)

    @classmethod
    def of_vertices(cls, mesh: Mesh) -> SurfacePoints:
        """The places of a mesh's own vertices; face -1 for those that no face uses."""
        corner = np.full(len(mesh.vertices), -1, dtype=np.int64)
        corner[mesh.indices[::-1]] = np.arange(len(mesh.indices))[::-1]
        weights = np.where(corner[:, None] < 0, 0, np.eye(3)[corner % 3])
        return cls((corner // 3).astype(np.int32), weights)

    def taken(self, rows: NDArray[Any]) -> SurfacePoints:
        """Some of the places, by number or by a mask."""
        return SurfacePoints(self.face[rows], self.barycentric[rows])

    def pull(self, mesh: Mesh, values: NDArray[Any]) -> NDArray[Any]:
        """Per-vertex ``values`` of ``mesh`` at these places.

        Floats are interpolated and are NaN where there is no face; of integers and booleans
        (labels) the vertex with the largest weight decides, and a place without face is refused.

        Raises
        ------
        InvalidInput : ``values`` has not one row per vertex of ``mesh``, or labels are asked where
            there is no face.
        """
        values = np.asarray(values)
        if len(values) != len(mesh.vertices):
            raise InvalidInput(
                f"{len(values)} rows of values for a mesh of {len(mesh.vertices)} vertices"
            )
        missing = self.face < 0
        corners = mesh.faces[np.where(missing, 0, self.face)]
        if not np.issubdtype(values.dtype, np.floating):
            if missing.any():
                raise InvalidInput(
                    f"{int(missing.sum())} places have no face on the mesh, "
                    "so they have no label there; drop the filled parts first"
                )
            largest = self.barycentric.argmax(axis=1)[:, None]
            labels: NDArray[Any] = values[np.take_along_axis(corners, largest, axis=1)[:, 0]]
            return labels
        pulled: NDArray[Any] = weighted_mean(self.barycentric, values[corners])
        pulled[missing] = np.nan
        return pulled


def weighted_mean(weights: Floats, values: NDArray[Any]) -> NDArray[Any]:
    """Means (n, ...) of ``values`` (n, 3, ...); a NaN without weight does not count."""
    weight = weights.reshape(*weights.shape, *(1,) * (values.ndim - 2))
    mean: NDArray[Any] = np.where(weight == 0, 0, weight * values).sum(axis=1)
    return mean


@dataclass(frozen=True, eq=False)
class Correspondence(Showing):
    """One connectivity with a place on a surface *a* and a place on a surface *b* per vertex.

    faces : (m, 3) int32.
    vertices_a, vertices_b : (n, 3) float64, positions on a and on b.
    on_a, on_b : the same places as faces and barycentric coordinates of the *input* meshes.
    attributes_a, attributes_b : attributes of the inputs carried to this connectivity.
    """

    faces: Ints
    vertices_a: Floats
    vertices_b: Floats
    on_a: SurfacePoints
    on_b: SurfacePoints
    attributes_a: Attributes = field(default_factory=Attributes)
    attributes_b: Attributes = field(default_factory=Attributes)

    @property
    def correspondence(self) -> Correspondence:
        """Itself, so that a bare correspondence serves wherever a method's result does."""
        return self

    @property
    def mesh_a(self) -> Mesh:
        """The common connectivity in the shape of a."""
        return Mesh(self.vertices_a, self.faces, attributes=self.attributes_a)

    @property
    def mesh_b(self) -> Mesh:
        """The common connectivity in the shape of b."""
        return Mesh(self.vertices_b, self.faces, attributes=self.attributes_b)

    def _scene_(self) -> Scene:
        """The shape of a, with a slider to that of b and what both carry as colours."""
        colourings = offered(self.mesh_a)
        if self.attributes_b is not self.attributes_a:
            names = {one.name for one in colourings}
            for one in offered(self.mesh_b):
                colourings += (replace(one, name=f"{one.name} (b)") if one.name in names else one,)
        morph = Slide("morph", self.vertices_b - self.vertices_a, ends=("a", "b"))
        return Scene(Mesh(self.vertices_a, self.faces), colourings, slides=(morph,))

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything as arrays by name; :meth:`from_arrays` undoes it."""
        arrays: dict[str, NDArray[Any]] = {
            "faces": self.faces,
            "vertices_a": self.vertices_a,
            "vertices_b": self.vertices_b,
            "on_a.face": self.on_a.face,
            "on_a.barycentric": self.on_a.barycentric,
            "on_b.face": self.on_b.face,
            "on_b.barycentric": self.on_b.barycentric,
        }
        for side, attributes in (("a", self.attributes_a), ("b", self.attributes_b)):
            arrays |= attribute_arrays(attributes, f"attributes_{side}")
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Correspondence:
        """The correspondence that :meth:`to_arrays` took apart; KeyError if an array is missing."""
        return cls(
            arrays["faces"],
            arrays["vertices_a"],
            arrays["vertices_b"],
            SurfacePoints(arrays["on_a.face"], arrays["on_a.barycentric"]),
            SurfacePoints(arrays["on_b.face"], arrays["on_b.barycentric"]),
            attributes_in(arrays, "attributes_a"),
            attributes_in(arrays, "attributes_b"),
        )


def attribute_arrays(attributes: Attributes, prefix: str) -> dict[str, NDArray[Any]]:
    """Attributes as arrays by name; :func:`attributes_in` undoes it."""
    return {
        f"{prefix}.{domain}.{name}": values
        for domain in ("vertex", "corner", "face")
        for name, values in getattr(attributes, domain).items()
    }


def attributes_in(arrays: Mapping[str, NDArray[Any]], prefix: str) -> Attributes:
    """The attributes that :func:`attribute_arrays` took apart."""
    domains: dict[str, dict[str, NDArray[Any]]] = {"vertex": {}, "corner": {}, "face": {}}
    for key, values in arrays.items():
        if key.startswith(prefix + "."):
            _, domain, name = key.split(".", 2)
            domains[domain][name] = values
    return Attributes(**domains)


class HasCorrespondence(Protocol):
    """Any result of a method that relates two surfaces."""

    @property
    def correspondence(self) -> Correspondence: ...
