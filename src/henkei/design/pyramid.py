"""A given surface as a coarse shape and details of all finer levels, to be edited at any of them.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000), 3,
4; D. Zorin, P. Schroeder, W. Sweldens: Interactive multiresolution mesh editing (1997).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.design.filters import Support
from henkei.design.levels import Levels, times
from henkei.design.refinement import LOST, Connectivity, carried, connectivity, counts
from henkei.design.settings import (
    Refinement,
    checked_count,
    checked_positions,
    checked_refinement,
    checked_scale,
    checked_support,
)
from henkei.design.subdivision_connectivity import unrefined
from henkei.design.wavelets import Wavelets
from henkei.errors import InvalidInput, some
from henkei.interchange import surface_from
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh, Surface, Values, simplest
from henkei.progress import Progress, part, silent
from henkei.topology import Ints


@dataclass(frozen=True, eq=False, repr=False)
class Pyramid:
    """A surface as a coarse shape and what each finer level adds to it.

    Made by :meth:`of` a surface whose faces come from refinement, or :meth:`on` a cage. Vertices
    are numbered as refinement numbers them: those of a level keep their number at all finer ones.
    Edits give a new pyramid.

    hierarchy : the levels of the cage.
    wavelets : from each level to the next.
    approximations : c(k) (m, 3) of every level, the surface without the details of finer ones.
    details : d(k) (n, 3) of every level but the finest: what its wavelets add, by new vertex.
    given : the surface it was made of; None on a cage.
    order : (n,) the vertex of this surface that is each of the finest level.
    """

    hierarchy: Levels
    wavelets: tuple[Wavelets, ...]
    approximations: tuple[Floats, ...]
    details: tuple[Floats, ...]
    attributes: Attributes
    given: Surface | None = None
    order: Ints | None = None

    @classmethod
    def of(
        cls,
        surface: Any,
        levels: int | None = None,
        *,
        support: int | None = None,
        interpolating: bool = False,
        progress: Progress = silent,
    ) -> Pyramid:
        """The levels of a surface whose faces come from refinement, in any order.

        Parameters
        ----------
        surface : triangles or quads, see :func:`.unrefined`; a path, a ``(vertices, faces)`` pair,
            or an object of henkei, trimesh, PyVista or meshio.
        levels : how many below the finest; as many as there are by default.
        support : None: wavelets are orthogonal to all coarser hats, so that the shape at each level
            is nearest to the surface in the sense of least squares. A number: they are nearly so,
            on so many rings of faces.
        interpolating : without wavelets: the shape at each level has its vertices on the surface.

        Raises
        ------
        Infeasible : the faces do not come from refinement, or from fewer levels.
        InvalidInput : a setting that can't be.
        NotFinite, DegenerateFaces, NotManifold, NotOriented, InvalidMesh : of the surface.
        """
        filters = checked_support(support, interpolating)
        given = surface_from(surface)
        progress("finding levels", 0.0)
        found = unrefined(given, levels)
        cage = connectivity(found.cage)
        hierarchy = Levels.of(cage, found.levels, found.quads, part(progress, 0.3, 0.5))
        attributes = _reordered(given.attributes, found.order, found.corners, found.quads)
        positions = given.vertices[found.order]
        made = cls._analysed(hierarchy, filters, positions, attributes, part(progress, 0.5, 1.0))
        return replace(made, given=given, order=found.order)

    @classmethod
    def on(
        cls,
        cage: Any,
        positions: ArrayLike,
        *,
        refinement: Refinement = "auto",
        support: int | None = None,
        interpolating: bool = False,
        progress: Progress = silent,
    ) -> Pyramid:
        """The levels of a refined cage whose finest vertices are given.

        Parameters
        ----------
        cage : manifold and oriented; only its faces and attributes matter.
        positions : (n, 3) of the finest level, numbered as refinement numbers them.
        refinement : as for :class:`.Designer`; the others as in :meth:`of`.

        Raises
        ------
        InvalidInput : as many vertices as no level has, or positions that are no numbers.
        NotFinite, DegenerateFaces, NotManifold, NotOriented, InvalidMesh : of the cage.
        """
        filters = checked_support(support, interpolating)
        surface = surface_from(cage)
        base = connectivity(surface)
        quads = checked_refinement(refinement, bool((base.sizes == 3).all()))
        points = checked_positions(positions, None, "positions of the finest level")
        count = _levels_with(base, quads, len(points))
        hierarchy = Levels.of(base, count, quads, part(progress, 0.0, 0.4))
        attributes = surface.attributes
        for level in hierarchy[:-1]:
            attributes = carried(attributes, level.connectivity, quads)
        return cls._analysed(hierarchy, filters, points, attributes, part(progress, 0.4, 1.0))

    @classmethod
    def _analysed(
        cls,
        hierarchy: Levels,
        support: Support,
        positions: Floats,
        attributes: Attributes,
        progress: Progress,
    ) -> Pyramid:
        wavelets = tuple(Wavelets(a, b, support) for a, b in pairwise(hierarchy))
        coarser, details = _analysis(wavelets, positions, progress)
        return cls(hierarchy, wavelets, (*coarser, positions), tuple(details), attributes)

    @property
    def levels(self) -> int:
        """The number of the finest level."""
        return len(self.details)

    @property
    def cage(self) -> Mesh | PolygonMesh:
        """The surface at level 0."""
        return self.surface(0)

    def positions(self, level: int | None = None, detail: int | None = None) -> Floats:
        """Vertices (m, 3) of a level, the finest by default.

        detail : show the shape of this level, without the details of it and of finer ones; by
            default all that the level can show.
        """
        level = self._checked_level(level)
        shown = level if detail is None else self._checked_level(detail)
        if shown > level:
            raise InvalidInput(f"level {level} can't show the detail of level {shown}")
        points = self.approximations[shown].copy()
        for number in range(shown + 1, level + 1):
            points = times(self.hierarchy[number].prolongation, points)
        return points

    def surface(self, level: int | None = None, detail: int | None = None) -> Mesh | PolygonMesh:
        """The surface at a level with the attributes of the finest; normals are left out.

        Parameters as in :meth:`positions`.
        """
        level = self._checked_level(level)
        faces = self.hierarchy[level].connectivity
        mesh = PolygonMesh(
            self.positions(level, detail),
            (faces.indices, faces.offsets),
            attributes=self._attributes(level),
        )
        return simplest(mesh)

    def as_given(self) -> Surface:
        """The finest level with the vertices and faces in the order in which they were given.

        Raises
        ------
        InvalidInput : the pyramid was made on a cage.
        """
        if self.given is None or self.order is None:
            raise InvalidInput("this pyramid was made on a cage: surface() is in its order")
        vertices = np.empty_like(self.approximations[-1])
        vertices[self.order] = self.approximations[-1]
        attributes = self.given.attributes
        for name in LOST:
            attributes = attributes.without(name)
        return replace(self.given, vertices=vertices, attributes=attributes)

    def edited(
        self,
        level: int,
        positions: ArrayLike | None = None,
        *,
        displacement: ArrayLike | None = None,
        frames: bool = True,
    ) -> Pyramid:
        """With another shape at one level, under the same details of finer ones.

        Parameters
        ----------
        level : number of the level.
        positions : (m, 3) of its vertices.
        displacement : (m, 3) in place of the positions: how far each vertex moves.
        frames : turn the details with the surface beneath, as bent arms their wrinkles; else they
            stay as they are, and the surface is linear in the positions.

        Raises
        ------
        InvalidInput : there is no such level, or the positions do not suit it.
        """
        level = self._checked_level(level)
        shape = self.approximations[level]
        if (positions is None) == (displacement is None):
            raise InvalidInput("give either positions or a displacement")
        if positions is not None:
            shape = checked_positions(positions, len(shape), f"positions of level {level}")
        else:
            shape = shape + checked_positions(displacement, len(shape), "the displacement")
        return self._raised(level, shape, self.details[level:], self if frames else None)

    def with_detail(self, scale: float | Sequence[ArrayLike], *, frames: bool = False) -> Pyramid:
        """With weaker or stronger details on the same coarsest shape.

        Parameters
        ----------
        scale : one factor; or for each level but the finest one, or one for each of its details.
            With 0 details go, with 2 they are exaggerated.
        frames : turn details with the surface beneath, which those of coarser levels change.

        Raises
        ------
        InvalidInput : the factors are no numbers, or too many or too few.
        """
        factors = checked_scale(scale, [len(details) for details in self.details])
        details = [f * d for f, d in zip(factors, self.details, strict=True)]
        return self._raised(0, self.approximations[0], details, self if frames else None)

    def with_detail_of(self, other: Pyramid, level: int = 0, *, frames: bool = True) -> Pyramid:
        """With the details of another pyramid of the same cage from some level on.

        Parameters
        ----------
        level : the details of it and of all finer levels are taken from the other.
        frames : turn them from the surface beneath them there to that here.

        Raises
        ------
        InvalidInput : the cages, levels or wavelets differ, or there is no such level.
        """
        level = self._checked_level(level)
        if not isinstance(other, Pyramid):
            raise InvalidInput(f"details are taken from another pyramid, not from {other!r}")
        _require_alike(self.wavelets, other.wavelets)
        shape = self.approximations[level]
        return self._raised(level, shape, other.details[level:], other if frames else None)

    def _raised(
        self, level: int, shape: Floats, details: Sequence[Floats], under: Pyramid | None
    ) -> Pyramid:
        """With a shape at one level, and details from it on, turned from the shapes of a pyramid
        that they are details of."""
        coarser, below = _analysis(self.wavelets[:level], shape, silent)
        shapes, added = [shape], []
        for wavelets, own in zip(self.wavelets[level:], details, strict=True):
            number = wavelets.coarse.number
            if under is not None:
                own = wavelets.turned(own, under.approximations[number], shapes[-1])
            added.append(own)
            shapes.append(wavelets.synthesised(shapes[-1], own))
        return replace(self, approximations=(*coarser, *shapes), details=(*below, *added))

    def _checked_level(self, level: int | None) -> int:
        if level is None:
            return self.levels
        return checked_count(level, "level", self.levels)

    def _attributes(self, level: int) -> Attributes:
        """Those of the finest level at what came from the vertices, corners and faces of one."""
        c = self.hierarchy[level].connectivity
        corners, quads = np.arange(len(c.indices)), self.hierarchy[level].quads
        for _ in range(level, self.levels):
            corners = 4 * corners if quads else 12 * (corners // 3) + 3 * (corners % 3)
        faces = corners[c.offsets[:-1]] // (4 if quads else 3)
        return _taken(self.attributes, np.arange(c.vertex_count), corners, faces)

    def __repr__(self) -> str:
        cage, finest = self.hierarchy[0].connectivity, self.hierarchy[-1].connectivity
        return (
            f"Pyramid({self.levels} levels, {cage.face_count:,} faces to {finest.face_count:,} "
            f"{'quads' if self.hierarchy[0].quads else 'triangles'})"
        )


def _analysis(
    wavelets: Sequence[Wavelets], positions: Floats, progress: Progress
) -> tuple[list[Floats], list[Floats]]:
    """The shapes of all coarser levels, and the details between them."""
    shapes: list[Floats] = [positions]
    details: list[Floats] = []
    for done, step in enumerate(reversed(wavelets)):
        progress(f"analysing level {step.fine.number}", done / len(wavelets))
        coarse, detail = step.analysed(shapes[0])
        shapes.insert(0, coarse)
        details.insert(0, detail)
    return shapes[:-1], details


def _levels_with(cage: Connectivity, quads: bool, vertices: int) -> int:
    """How often a cage is refined until it has so many vertices."""
    sizes = [cage.vertex_count]
    while sizes[-1] < vertices:
        sizes.append(counts(cage, quads, len(sizes))[-1][0])
    if vertices not in sizes[1:]:
        raise InvalidInput(
            f"there are {vertices:,} positions, but the levels of this cage have "
            f"{some(f'{size:,}' for size in [*sizes, counts(cage, quads, len(sizes))[-1][0]])} "
            "vertices; give those of one level from 1 on"
        )
    return len(sizes) - 1


def _reordered(given: Attributes, order: Ints, corners: Ints, quads: bool) -> Attributes:
    sides = 4 if quads else 3
    return _taken(given, order, corners, corners[::sides] // sides)


def _taken(
    attributes: Attributes,
    vertices: NDArray[np.integer],
    corners: NDArray[np.integer],
    faces: NDArray[np.integer],
) -> Attributes:
    """Some rows of the attributes that positions do not change."""

    def rows(values: Values, places: NDArray[np.integer]) -> dict[str, NDArray[Any]]:
        return {name: a[places] for name, a in values.items()}

    for name in LOST:
        attributes = attributes.without(name)
    return Attributes(
        vertex=rows(attributes.vertex, vertices),
        corner=rows(attributes.corner, corners),
        face=rows(attributes.face, faces),
    )


def _require_alike(wavelets: Sequence[Wavelets], others: Sequence[Wavelets]) -> None:
    def kind(steps: Sequence[Wavelets]) -> tuple[object, ...]:
        base = steps[0].coarse
        faces = base.connectivity.indices.tobytes(), base.connectivity.offsets.tobytes()
        return len(steps), steps[0].support, base.quads, *faces

    if kind(wavelets) != kind(others):
        raise InvalidInput(
            "the pyramids must have the same cage, number of levels and wavelets, so that their "
            "details belong to the same vertices"
        )
