"""The registration: the source's connectivity with the target's shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidFile, InvalidInput
from henkei.geometry.alignment import Similarity, aligned
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.geometry.interpolation import Path, Time, between
from henkei.io.scene import Mark, Scene
from henkei.mesh import Floats, Mesh
from henkei.register.quality import RegisterQuality
from henkei.showing import Showing
from henkei.topology import Ints


@dataclass(frozen=True, eq=False, repr=False)
class Registration(Showing):
    """A source mesh on a target's surface. Made by :func:`henkei.register`.

    correspondence : the source's faces, its vertices (a) and their places on the target (b).
    target_faces : (m, 3) faces of the target, which ``on_target`` names.
    target_vertices : number of the target's vertices.
    landmarks : (k,) vertices of the source that were landmarks.
    similarity : how the source was aligned to the target at the start.
    """

    correspondence: Correspondence
    target_faces: Ints
    target_vertices: int
    landmarks: Ints
    similarity: Similarity
    quality: RegisterQuality

    @classmethod
    def of(
        cls,
        source: Mesh,
        target: Mesh,
        vertices: Floats,
        on_target: SurfacePoints,
        landmarks: Ints,
        similarity: Similarity,
        quality: RegisterQuality,
    ) -> Registration:
        """The source with its vertices (n, 3) where they came to lie."""
        kept = source.attributes.without("normal")
        at_home = SurfacePoints.of_vertices(source)
        return cls(
            Correspondence(source.faces, source.vertices, vertices, at_home, on_target, kept, kept),
            target.faces,
            len(target.vertices),
            landmarks,
            similarity,
            quality,
        )

    def __repr__(self) -> str:
        sizes = f"{len(self.correspondence.vertices_a)} vertices, {len(self.faces)} faces"
        return f"Registration({sizes}, {len(self.landmarks)} landmarks)"

    def _scene_(self) -> Scene:
        """The source in the shape of the target, with a slider back, and the landmarks."""
        scene = self.correspondence._scene_()
        (morph,) = scene.slides
        marks = tuple(Mark(vertex, str(k)) for k, vertex in enumerate(self.landmarks.tolist()))
        return replace(
            scene, slides=(replace(morph, start=1.0, ends=("source", "target")),), marks=marks
        )

    @property
    def faces(self) -> Ints:
        """Faces (m, 3), the source's."""
        return self.correspondence.faces

    @property
    def on_target(self) -> SurfacePoints:
        """Places of the vertices on the target; face -1 where it has a hole and the vertex was
        bridged over it."""
        return self.correspondence.on_b

    @cached_property
    def mesh(self) -> Mesh:
        """The source's faces in the shape of the target, with the source's attributes."""
        return self.correspondence.mesh_b

    def at(
        self,
        t: float,
        *,
        path: Literal["linear", "rotation"] | Path = "linear",
        time: Time = "linear",
        delay: ArrayLike | None = None,
    ) -> Mesh:
        """The shape at time ``t`` between the source (0) and the target (1); see
        :func:`henkei.geometry.interpolation.between`."""
        return between(self.correspondence, t, path=path, time=time, delay=delay)

    def pull(self, values: ArrayLike) -> NDArray[Any]:
        """Per-vertex ``values`` of the target at the source's vertices.

        Floats are interpolated, NaN at bridged vertices; of integers and booleans (labels) the
        target's vertex with the largest weight decides.

        Raises
        ------
        InvalidInput : not one row per vertex of the target, or labels where vertices are bridged.
        """
        rows = np.asarray(values)
        if len(rows) != self.target_vertices:
            raise InvalidInput(
                f"{len(rows)} rows of values for a target of {self.target_vertices} vertices"
            )
        target = Mesh(np.zeros((self.target_vertices, 3)), self.target_faces)
        return self.on_target.pull(target, rows)

    def aligned(self, *, scale: bool = True) -> Registration:
        """The same with the target moved onto the source by the best similarity (rigid motion
        without ``scale``)."""
        return replace(self, correspondence=aligned(self.correspondence, scale=scale))

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything as arrays by name, for a file; :meth:`from_arrays` undoes it."""
        similarity = self.similarity
        arrays: dict[str, NDArray[Any]] = {
            **self.correspondence.to_arrays(),
            "target_faces": self.target_faces,
            "target_vertices": np.array(self.target_vertices),
            "landmarks": self.landmarks,
            "similarity.rotation": similarity.rotation,
            "similarity.scale": np.array(similarity.scale),
            "similarity.translation": similarity.translation,
        }
        return arrays | {f"quality.{n}": np.array(v) for n, v in asdict(self.quality).items()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Registration:
        """The registration that :meth:`to_arrays` took apart.

        Raises
        ------
        InvalidFile : an array is missing, or names vertices or faces that do not exist.
        """
        try:
            _refuse_strays(arrays)
            fields = RegisterQuality.__dataclass_fields__
            return cls(
                Correspondence.from_arrays(arrays),
                arrays["target_faces"],
                int(arrays["target_vertices"]),
                arrays["landmarks"],
                Similarity(
                    arrays["similarity.rotation"],
                    float(arrays["similarity.scale"]),
                    arrays["similarity.translation"],
                ),
                RegisterQuality(**{n: arrays[f"quality.{n}"].item() for n in fields}),
            )
        except KeyError as missing:
            raise InvalidFile(f"not a whole registration: {missing} is missing") from None


def _refuse_strays(arrays: Mapping[str, NDArray[Any]]) -> None:
    figures = [f"quality.{name}" for name in RegisterQuality.__dataclass_fields__]
    for name in ("target_vertices", "similarity.scale", *figures):
        if arrays[name].ndim or arrays[name].dtype.kind not in "iuf" or arrays[name] < 0:
            raise InvalidFile(f"{name} is not one number")
    counts = {
        "on_a.face": len(arrays["faces"]),
        "on_b.face": len(arrays["target_faces"]),
        "landmarks": len(arrays["vertices_a"]),
        "target_faces": int(arrays["target_vertices"]),
    }
    for name, count in counts.items():
        if not np.isin(arrays[name], np.arange(-1, count)).all():
            raise InvalidFile(f"{name} names vertices or faces that do not exist")
