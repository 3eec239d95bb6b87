"""H. Masuda, Y. Yoshioka, Y. Furukawa, "Feature-preserving interactive mesh deformation" (2006)."""

from __future__ import annotations

import dataclasses
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from henkei.deform.constraints import Feature, Fixed, Handle, Keep, Pin
from henkei.deform.drag import Drag
from henkei.deform.prepared import Prepared
from henkei.deform.quality import DeformQuality, Solution, measured
from henkei.deform.regions import (
    checked_name,
    checked_point,
    checked_region,
    checked_weight,
    require_apart,
)
from henkei.deform.scene import scene_of
from henkei.deform.settings import Method, Settings
from henkei.deform.symmetry import Symmetry
from henkei.errors import InvalidInput, some
from henkei.geometry.requirements import (
    require_measurable_displacement,
    require_measurable_faces,
)
from henkei.mesh import Floats, Surface
from henkei.progress import Progress, silent
from henkei.showing import Showing

ON_TOP = 100  # vertices that may come to a prepared deformer before it is factored anew


class Deformer(Showing):
    """Bends a surface by handles while form features keep their shape.

    Parameters
    ----------
    mesh : a mesh of triangles or polygons, or anything :meth:`henkei.Mesh.from_any` takes. It may
        be open, of several pieces and not manifold. Faces and attributes are kept.
    settings : see :class:`Settings`.

    Raises
    ------
    InvalidMesh : no faces, NaN or infinite positions, faces without an area.

    Notes
    -----
    Name what is held, moved and kept, then :meth:`prepare` once; afterwards each :meth:`solve`
    costs one back-substitution (section 2 of the paper).

    >>> d = Deformer(mesh)
    >>> d.fix(rim)
    >>> handle = d.handle(middle)
    >>> hole = d.feature(loop)
    >>> d.prepare()
    >>> handle.move(translation=(0, 0, 5))
    >>> positions = d.solve()
    """

    _scene_ = scene_of

    def __init__(self, mesh: Any, settings: Settings | None = None) -> None:
        from henkei.interchange import surface_from

        self.mesh: Surface = mesh if isinstance(mesh, Surface) else surface_from(mesh)
        self.settings = Settings() if settings is None else settings
        if not isinstance(self.settings, Settings):
            raise InvalidInput(f"settings must be henkei.deform.Settings, not {settings!r}")
        require_measurable_faces(self.mesh)
        self._bodies: list[Fixed | Handle | Feature] = []
        self._pins: list[Pin] = []
        self._offsets: list[tuple[str, Feature, Feature]] = []
        self._symmetry: Symmetry | None = None
        self._prepared: Prepared | None = None
        self._late: list[Fixed | Handle | Pin] = []
        self._solution: Solution | None = None
        self._quality: DeformQuality | None = None

    @property
    def handles(self) -> list[Handle]:
        """All handles, in the order they were made."""
        return [body for body in self._bodies if isinstance(body, Handle)]

    @property
    def features(self) -> list[Feature]:
        """All features, in the order they were made."""
        return [body for body in self._bodies if isinstance(body, Feature)]

    @property
    def pins(self) -> list[Pin]:
        """All pins, in the order they were made."""
        return list(self._pins)

    def fix(self, region: Any, *, weight: float | None = None, name: str | None = None) -> Fixed:
        """Hold a region where it is.

        Parameters
        ----------
        region : vertex indices ``(k,)``, a mask ``(n,)`` of booleans, or an object with
            ``vertices`` such as a found feature. :mod:`henkei.select` has functions that choose.
        weight : None to hold it exactly, or a positive number to hold it softly: its part in the
            least squares, against 1 for the curvature of a vertex.
        name : how messages and recipes call it; "fixed 1" and so on by default.

        Raises
        ------
        InvalidInput : the region is empty, names vertices that don't exist or overlaps another one;
            the weight is not positive; the name is taken.
        """
        name = self._name(name, "fixed")
        vertices = self._region(region, name)
        body = Fixed(name, vertices, checked_weight(weight, name))
        self._add(body)
        return body

    def handle(
        self, region: Any, *, weight: float | None = None, name: str | None = None
    ) -> Handle:
        """A region to be moved as one body; see :meth:`fix` for the parameters.

        Raises
        ------
        InvalidInput : as :meth:`fix`.
        """
        name = self._name(name, "handle")
        vertices = self._region(region, name)
        rest = self.mesh.vertices[vertices]
        body = Handle(name, vertices, rest, checked_weight(weight, name))
        self._add(body)
        return body

    def feature(
        self,
        region: Any,
        *,
        keep: Keep = "rigid",
        weight: float | None = None,
        name: str | None = None,
    ) -> Feature:
        """A region whose shape survives: a hole, a rib, a pad, a character line (eq. 12).

        All vertices of the region are one body, even where no edge joins them.

        Parameters
        ----------
        keep : ``"rigid"``, ``"circle"``, ``"plane"`` or ``"line"``; see :class:`Feature`.

        Raises
        ------
        InvalidInput : as :meth:`fix`; or the region is not round, planar or straight but shall stay
            so.
        """
        name = self._name(name, "feature")
        if not isinstance(keep, str) or keep not in ("rigid", "circle", "plane", "line"):
            raise InvalidInput(f"keep must be 'rigid', 'circle', 'plane' or 'line', not {keep!r}")
        vertices = self._region(region, name)
        if keep in ("plane", "line"):  # nothing says how these stretch at vertices without faces
            vertices = np.setdiff1d(vertices, self.mesh.topology.unused_vertices)
            if not len(vertices):
                raise InvalidInput(f"region {name!r} has no vertex that a face uses")
        rest = self.mesh.vertices[vertices]
        circle = getattr(region, "circle", None) if keep == "circle" else None
        body = Feature(name, vertices, rest, keep, checked_weight(weight, name), circle)
        self._add(body)
        return body

    def pin(
        self,
        point: Any,
        target: ArrayLike | None = None,
        *,
        weight: float | None = None,
        name: str | None = None,
    ) -> Pin:
        """Put one point of the surface at a place; it is free to turn there (eq. 2, 3).

        Parameters
        ----------
        point : a vertex index, ``((i, j), t)`` for ``t p_i + (1 - t) p_j`` on an edge, or
            ``(face, weights)`` with a weight for each corner of a face.
        target : (3,) where it shall be; where it is by default.
        weight, name : as in :meth:`fix`.

        Raises
        ------
        InvalidInput : the point is not on the mesh, the target is not three finite numbers.
        """
        name = self._name(name, "pin")
        vertices, coefficients = checked_point(point, self.mesh, name)
        rest = coefficients @ self.mesh.vertices[vertices]
        pin = Pin(name, vertices, coefficients, rest, rest, checked_weight(weight, name))
        if target is not None:
            pin.move(target)
        self._pins.append(pin)
        self._come(pin)
        return pin

    def keep_offset(self, first: Feature, second: Feature, *, name: str | None = None) -> str:
        """Keep the offset between the centres of two features, turned with them.

        The two share one rotation, so that axes of holes stay parallel; each may still be scaled
        about its own centre.

        Raises
        ------
        InvalidInput : not two different hard features of this deformer.
        """
        for feature in (first, second):
            if feature not in self.features or feature.weight is not None:
                raise InvalidInput("an offset is kept between two hard features of this deformer")
        if first is second:
            raise InvalidInput(f"{first.name!r} has no offset to itself; give two features")
        name = self._name(name, "offset")
        self._offsets.append((name, first, second))
        self._changed()
        return name

    def symmetry(
        self, point: ArrayLike, normal: ArrayLike, *, tolerance: float | None = None
    ) -> None:
        """Keep the mesh symmetric about a plane: what is done on one side is done on the other.

        Every constraint gets a mirrored twin. One that is its own mirror image, such as a handle
        on the plane, can only move within the plane.

        Parameters
        ----------
        point, normal : (3,) of the plane.
        tolerance : how far a vertex may be from the mirror image of its partner, in the unit of
            the mesh; 1e-6 of the diagonal by default.

        Raises
        ------
        InvalidInput : a vertex has no mirror image, or the plane is no plane.
        """
        self._symmetry = Symmetry(self.mesh, point, normal, tolerance)
        self._changed()

    def prepare(self, progress: Progress = silent, *, method: Method = "linear") -> Deformer:
        """Factor the systems for the constraints named so far.

        Raises
        ------
        InvalidInput : nothing is fixed, or a connected piece of the surface is held by nothing.
        """
        _require_known(method)
        self._prepared = Prepared(
            self.mesh,
            self.settings,
            self._bodies,
            self._pins,
            [(first, second) for _, first, second in self._offsets],
            self._symmetry,
            progress,
        )
        self._late = []
        if method == "refined":
            self._prepared.prepare_refinement(progress)
        return self

    def solve(self, method: Method = "linear") -> Floats:
        """Positions ``(n, 3)`` for the present poses of handles, features and pins.

        Parameters
        ----------
        method : ``"linear"``, the paper; or ``"refined"``: a few steps more that fit rotations to
            the result, for large turns and translations, where the linear method shears.

        Raises
        ------
        Infeasible : constraints contradict each other; the message names them.
        InvalidInput : as :meth:`prepare`, which is called if it has not been; or a pose is so far
            away that lengths overflow.
        """
        _require_known(method)
        prepared = self._ready()
        displacement = prepared.solve(method)
        require_measurable_displacement(displacement)
        positions = self.mesh.vertices + displacement
        self._solution = Solution(
            positions,
            [copy(body) for body in self._bodies],
            [copy(pin) for pin in self._pins],
            prepared.turned,
            prepared.field.rotations(),
            method,
            *prepared.solver,
        )
        self._quality = None
        return positions.copy()

    def drag(
        self, handle: Handle, *, axis: ArrayLike = (0.0, 0.0, 1.0), limit: float = np.pi
    ) -> Drag:
        """Prepare to drag a handle from its present pose: then a frame costs no solve.

        ``drag.positions(translation, angle)`` gives the linear solution for the handle translated
        further, exactly, and turned further about ``axis``, to about 1e-7 of the diagonal. Handles,
        pins and rigid features are exact. At the end, move the handle and :meth:`solve`.

        Parameters
        ----------
        handle : of this deformer.
        axis : (3,) direction of further turns.
        limit : radians; the largest turn to either side, up to pi.

        Raises
        ------
        InvalidInput : the handle is not of this deformer, no axis, a limit out of range.
        """
        if handle not in self.handles:
            raise InvalidInput("a handle is dragged that is not of this deformer")
        return Drag(self._ready(), handle, axis, limit)

    @property
    def result(self) -> Surface:
        """The surface at the last solution; faces and attributes as given."""
        return dataclasses.replace(self.mesh, vertices=self._solved().positions)

    @property
    def rotations(self) -> Floats:
        """Rotation matrices ``(n, 3, 3)`` of all vertices at the last solution.

        A rigid feature has turned by exactly that of its vertices.
        """
        return self._solved().rotations(np.arange(len(self.mesh.vertices)))

    @property
    def quality(self) -> DeformQuality:
        """Figures that tell whether to trust the last solution."""
        if self._quality is None:
            self._quality = measured(self.mesh, self._solved())
        return self._quality

    def _ready(self) -> Prepared:
        """The systems, factored if need be, with what came since on top."""
        if self._prepared is None:
            self.prepare()
        assert self._prepared is not None
        if self._late:
            self._prepared, self._late = self._prepared.with_late(self._late), []
        return self._prepared

    def _solved(self) -> Solution:
        if self._solution is None:
            raise InvalidInput("there is no solution yet; call solve()")
        return self._solution

    def _add(self, body: Fixed | Handle | Feature) -> None:
        if body.weight is None:
            require_apart(body, [other for other in self._bodies if other.weight is None])
        self._bodies.append(body)
        self._come(body)

    def _come(self, item: Fixed | Handle | Feature | Pin) -> None:
        """What comes to a prepared deformer is put on top of it if it is small."""
        on_top = [item.vertices for item in (*self._late, item)]
        if self._prepared is not None:
            on_top += [item.vertices for item in self._prepared.late]
        if (
            isinstance(item, Feature)
            or item.weight is not None
            or self._symmetry is not None
            or sum(map(len, on_top)) > ON_TOP
            or self._prepared is None
            or not self._prepared.takes(item)
        ):
            self._changed()
        else:
            self._late.append(item)

    def _changed(self) -> None:
        self._prepared, self._late = None, []

    def _name(self, name: str | None, kind: str) -> str:
        named = [item.name for item in (*self._bodies, *self._pins)]
        return checked_name(name, kind, named + [name for name, _, _ in self._offsets])

    def _region(self, region: Any, name: str) -> Any:
        vertices = checked_region(region, len(self.mesh.vertices), name)
        lost = vertices[~np.isfinite(self.mesh.vertices[vertices]).all(axis=1)]
        if len(lost):
            raise InvalidInput(
                f"region {name!r} holds vertices {some(lost)}, whose positions are not finite; "
                "no face uses them: leave them out"
            )
        return vertices


def _require_known(method: str) -> None:
    if method not in ("linear", "refined"):
        raise InvalidInput(f"method must be 'linear' or 'refined', not {method!r}")
