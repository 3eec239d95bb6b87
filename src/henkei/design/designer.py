"""Smooth surfaces from a coarse cage, with constraints at every level.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

from numpy.typing import ArrayLike

from henkei.design import constraints as made
from henkei.design.constraints import Constraint, Curve, Derivative, Pin
from henkei.design.drag import Drag
from henkei.design.edge_paths import edge_path
from henkei.design.levels import Levels
from henkei.design.live import Live
from henkei.design.local_edits import LocalEdits
from henkei.design.local_refinement import require_free
from henkei.design.meshes import Meshes
from henkei.design.paths import EXACT, is_index
from henkei.design.quality import DesignQuality, measured
from henkei.design.refinement import connectivity
from henkei.design.settings import (
    MOST_LEVELS,
    MOST_STEPS,
    Gamma,
    Refinement,
    Settings,
    checked_axis_gamma,
    checked_axis_smoothing,
    checked_count,
    checked_gamma,
    checked_indices,
    checked_positions,
    checked_refinement,
    checked_support,
)
from henkei.design.system import System
from henkei.errors import InvalidInput
from henkei.geometry.arguments import numbers
from henkei.interchange import surface_from
from henkei.mesh import Floats, Mesh, PolygonMesh, Surface
from henkei.progress import Progress, silent


class Designer(LocalEdits):
    """A smooth surface that starts from a cage and meets constraints of all levels at once.

    Level 0 is the cage; each level refines the one before. Constraints of coarse levels give the
    overall form, those of fine levels the detail, and ``gamma`` says how far each reaches: above 1
    fine levels count for more and the surface is smoother, below 1 it is faceted like the cage.
    The vertices of the cage are pinned where it has them, until they are moved or unpinned.

    Parameters
    ----------
    cage : triangles or polygons, manifold and oriented, closed or open, of any genus: a path, a
        ``(vertices, faces)`` pair, or an object of henkei, trimesh, PyVista or meshio. Its texture
        coordinates and other attributes are carried to all levels.
    levels : how often the cage is refined.
    gamma : see there.
    steps : of smoothing at each level, up to 100. A fixed number, so that the surface is linear in
        what is asked for.
    support : None: a constraint acts on finer levels through wavelets that are orthogonal to all
        coarser hat functions, which is exact and fast. A number: through wavelets on so many rings
        of faces, as in the paper; slow, for comparison.
    interpolating : a constraint of a coarse level holds for the same point at finer ones, without
        wavelets. Else it holds for the coarse part of the shape, and detail may add to it.
    refinement : "triangles" cuts a triangle into four, "quads" a face of n corners into n quads;
        "auto" is triangles where the cage has no other faces.

    Raises
    ------
    NotFinite, DegenerateFaces, NotManifold, NotOriented, InvalidMesh : of the cage; see the
        message.
    InvalidInput : a setting that can't be, or levels too deep for the memory.

    Notes
    -----
    Every edit counts at once: :meth:`surface` and :meth:`solve` do again what has become old and
    nothing else. The source is eq. 5-36 of the paper; axes with their own gamma, wavelets with full
    support, and the cage that follows constraints of level 0 are ours.
    """

    def __init__(
        self,
        cage: Any,
        levels: int = 4,
        *,
        gamma: Gamma = 2.0,
        steps: int = 30,
        support: int | None = None,
        interpolating: bool = False,
        refinement: Refinement = "auto",
        progress: Progress = silent,
    ) -> None:
        count = checked_count(levels, "levels", MOST_LEVELS)
        self._cage = surface_from(cage)
        base = connectivity(self._cage)
        quads = checked_refinement(refinement, bool((base.sizes == 3).all()))
        settings = Settings(checked_gamma(gamma, count), checked_count(steps, "steps", MOST_STEPS))
        wavelets = checked_support(support, interpolating)
        self._levels = Levels.of(base, count, quads, progress)
        self._system = System(self._levels, wavelets)
        self._meshes = Meshes(self._cage, self._levels)
        self._live = Live(self._system, self._cage.vertices, settings)

    def __repr__(self) -> str:
        sizes = f"{self._levels[0].size} vertices to {self._levels[-1].size}"
        asked = len(self._system.constraints)
        return f"Designer(levels 0 to {self.levels}, {sizes}, {asked} constraints)"

    @property
    def cage(self) -> Surface:
        """The cage as it was given."""
        return self._cage

    @property
    def constraints(self) -> list[Constraint]:
        """Pins, curves and derivatives, each in the order they came; not the pins of the cage."""
        return list(self._system.constraints)

    @property
    def support(self) -> int | None:
        """Rings of faces that wavelets are on; None for all."""
        return None if self.interpolating else cast("int | None", self._system.support)

    @property
    def interpolating(self) -> bool:
        """Whether constraints of a level hold at finer ones as they are."""
        return self._system.support == "interpolating"

    @property
    def refinement(self) -> Refinement:
        """What faces are cut into."""
        return "quads" if self._levels[0].quads else "triangles"

    def pin(self, level: int, place: Any, target: ArrayLike, *, name: str | None = None) -> Pin:
        """Let a point of the surface of a level go through a place.

        Parameters
        ----------
        place : a vertex of that level, or ``(face, weights)`` with a weight for each corner of the
            face, barycentric coordinates. Vertices of coarser levels keep their numbers.
        target : (3,).
        name : for reports; one like "pin 3" if none is given.

        Raises
        ------
        InvalidInput : the level, vertex or face does not exist, or the numbers can't be.
        """
        one = made.pin(self._connectivities, level, place, target, self._name(name, "pin"))
        self._add(one)
        return one

    def curve(
        self,
        level: int,
        path: Sequence[Any],
        target: ArrayLike,
        *,
        name: str | None = None,
        cutoff: float = EXACT,
    ) -> Curve:
        """Let a curve on the surface of a level run along another one, by least squares (eq. 13).

        Parameters
        ----------
        path : vertices of that level or points ``(face, weights)``; two in a row share a face. If
            the last is the first, the curve is closed.
        target : (t, 3) points. As many as the path has: each belongs to its point; else both curves
            are followed by arc length.
        cutoff : eigenvalues of eq. 13 up to this part of the largest are left out. A path along
            edges has none that are small. One that runs freely through faces passes near vertices,
            and says almost nothing of the vertex across: met exactly it answers with spikes, with
            1e-2 the curve is missed by some percent of its move, and smooth.

        Raises
        ------
        InvalidInput : an empty path, a step that leaves a face inside, or as for :meth:`pin`.
        """
        self._require_level(level)
        one = made.curve(
            self._connectivities,
            level,
            path,
            target,
            self._name(name, "curve"),
            self._meshes.flat(level),
            cutoff,
        )
        self._add(one)
        return one

    def derivative(
        self, level: int, place: Any, direction: Any, target: ArrayLike, *, name: str | None = None
    ) -> Derivative:
        """Let the surface of a level leave a point in a given way.

        Parameters
        ----------
        place : as for :meth:`pin`.
        direction : where place is a vertex, a vertex next to it; else the change (corners,) of the
            weights, of sum 0.
        target : (3,) how the position changes on the way to that vertex, or by that change.

        Raises
        ------
        InvalidInput : as for :meth:`pin`.
        """
        one = made.derivative(
            self._connectivities, level, place, direction, target, self._name(name, "derivative")
        )
        self._add(one)
        return one

    def move(self, constraint: Constraint, target: ArrayLike) -> None:
        """Give a constraint another target.

        Raises
        ------
        InvalidInput : it is not one of this designer, or the target can't be.
        """
        self._require_own(constraint)
        constraint.target = target

    def remove(self, constraint: Constraint) -> None:
        """Take a constraint away.

        Raises
        ------
        InvalidInput : it is not one of this designer.
        """
        self._require_own(constraint)
        level = self._system.first_level(constraint)
        self._system.remove(constraint)
        self._live.changed(level)

    def unpin(self, vertices: ArrayLike | None = None) -> None:
        """Let vertices of the cage go, all of them by default.

        Where nothing holds it the surface depends on the number of steps: it has no depth of its
        own.

        Raises
        ------
        InvalidInput : a vertex that the cage does not have.
        """
        count = self._levels[0].size
        given = range(count) if vertices is None else vertices
        self._system.unpin(checked_indices(given, count, "vertices", "the cage"))
        self._live.changed(0)

    @property
    def pinned(self) -> Any:
        """(m,) which vertices of the cage are pinned."""
        return self._system.pinned.copy()

    @property
    def gamma(self) -> float | Floats:
        """How much more a level counts than the one before (eq. 36), or the weights of all."""
        return self._live.settings.gamma

    @gamma.setter
    def gamma(self, gamma: Gamma) -> None:
        self._set(1, gamma=checked_gamma(gamma, self.levels))

    @property
    def axis_gamma(self) -> Floats | None:
        """gamma for each of x, y and z; None for the same one."""
        return self._live.settings.axis_gamma

    @axis_gamma.setter
    def axis_gamma(self, gamma: ArrayLike | None) -> None:
        self._set(1, axis_gamma=checked_axis_gamma(gamma))

    @property
    def axis_smoothing(self) -> tuple[bool, bool, bool]:
        """Whether x, y and z are smoothed."""
        return self._live.settings.axis_smoothing

    @axis_smoothing.setter
    def axis_smoothing(self, on: Sequence[bool]) -> None:
        self._set(0, axis_smoothing=checked_axis_smoothing(on))

    @property
    def steps(self) -> int:
        """Steps of smoothing at each level."""
        return self._live.settings.steps

    @steps.setter
    def steps(self, steps: int) -> None:
        self._set(0, steps=checked_count(steps, "steps", MOST_STEPS))

    def solve(self, progress: Progress = silent) -> Mesh | PolygonMesh:
        """The surface of the finest level."""
        self._live.shapes(progress)
        return self.surface()

    def surface(self, level: int | None = None) -> Mesh | PolygonMesh:
        """The surface of a level: what the design is with no finer ones.

        Returns
        -------
        Triangles, or quads (polygons at level 0), with the attributes of the cage.

        Raises
        ------
        InvalidInput : the level does not exist.
        """
        number = self._require_level(self.levels if level is None else level)
        return self._meshes.mesh(number, self._live.positions)

    def flat(self, level: int) -> Mesh | PolygonMesh:
        """The cage itself with the vertices and faces of a level."""
        number = self._require_level(level)
        flat = [self._meshes.flat(k) for k in range(number + 1)]
        return self._meshes.mesh(number, flat)

    def nearest(self, level: int, point: ArrayLike) -> int:
        """The vertex of a level that is nearest to a point (3,) on the flat cage of that level.

        Raises
        ------
        InvalidInput : the level does not exist, or these are not three finite numbers.
        """
        number = self._require_level(level)
        there = checked_positions([numbers(point)], 1, "the point")
        return int(((self._meshes.flat(number) - there) ** 2).sum(axis=1).argmin())

    def path(self, level: int, through: Sequence[Any]) -> list[int]:
        """The vertices of a level on the shortest way along edges of its flat cage, and straight
        across its quads, for a curve.

        Parameters
        ----------
        through : at least two vertices, or points (3,) whose nearest vertices are meant, those in
            a row with the same one once; if the last is the first, the way is closed.

        Raises
        ------
        InvalidInput : too few, two in a row that are the same, or no way between them.
        """
        number = self._require_level(level)
        vertices: list[int] = []
        for place in through:
            vertex = place if is_index(place) else self.nearest(number, place)
            if is_index(place) or vertices[-1:] != [vertex]:
                vertices.append(vertex)
        checked_indices(vertices, self._levels[number].size, "vertices", f"level {number}")
        return edge_path(self._connectivities[number], self._meshes.flat(number), vertices)

    def drag(self, constraint: Constraint) -> Drag:
        """Prepare to move a constraint's target many times: each costs one sum over vertices.

        Raises
        ------
        InvalidInput : it is not one of this designer.
        """
        self._require_own(constraint)
        vertices = self._meshes.vertices
        return Drag(vertices(self._live.positions), vertices(self._live.response(constraint)))

    @property
    def quality(self) -> DesignQuality:
        """How well the constraints are met and how smooth the surface is."""
        return measured(self._system, self._cage.vertices, self._live.asked, self._live.shapes())

    @property
    def _connectivities(self) -> list[Any]:
        return [level.connectivity for level in self._levels]

    def _add(self, constraint: Constraint) -> None:
        require_free(self._levels, constraint)
        self._system.add(constraint)
        self._live.changed(self._system.first_level(constraint))

    def _set(self, level: int, **settings: Any) -> None:
        """Change settings that count from a level on."""
        self._live.settings = replace(self._live.settings, **settings)
        self._live.changed(level)

    def _name(self, name: str | None, kind: str) -> str:
        taken = {one.name for one in self._system.constraints}
        if name is None:
            return next(n for n in (f"{kind} {k}" for k in itertools.count(1)) if n not in taken)
        if not isinstance(name, str) or not name:
            raise InvalidInput(f"a name is a text that is not empty, not {name!r}")
        if name in taken:
            raise InvalidInput(f"there is a constraint named {name!r} already; choose another name")
        return name

    def _require_own(self, constraint: Constraint) -> None:
        if not any(one is constraint for one in self._system.constraints):
            raise InvalidInput(f"{constraint!r} is not a constraint of this designer")
