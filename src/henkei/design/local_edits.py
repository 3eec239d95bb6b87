"""What a designer does to a part of the surface, and leaves the rest alone.

Wished for in section 9 of S. Takahashi: Designing subdivision surfaces via multiresolution-based
local filtering (2000): smoothing a part, refining a part, changing a part of the cage.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from henkei.design.cage_change import with_cage
from henkei.design.constraints import Constraint
from henkei.design.levels import Levels
from henkei.design.live import Live
from henkei.design.local_refinement import (
    faces_around,
    faces_near_constraints,
    refine,
    vertex_of,
)
from henkei.design.meshes import Meshes
from henkei.design.part import PartialLevel, checked_faces
from henkei.design.scene import scene_of
from henkei.design.settings import checked_count
from henkei.design.system import System
from henkei.errors import InvalidInput
from henkei.showing import Showing

if TYPE_CHECKING:
    from henkei.design.designer import Designer


class LocalEdits(Showing):
    """The part of :class:`henkei.Designer` that works on parts of the surface."""

    _levels: Levels
    _system: System
    _meshes: Meshes
    _live: Live
    _lost: Sequence[Constraint] = ()
    _scene_ = scene_of

    @property
    def levels(self) -> int:
        """The number of the finest level."""
        return len(self._levels) - 1

    def smooth_only(self, level: int | None = None, faces: ArrayLike | None = None) -> None:
        """From now on, let edits change the surface on some faces of a level only.

        Everything outside stays as it is, to the bit, until ``smooth_only()`` lets the whole
        surface follow again. An edit costs as much as these faces have vertices.
        :attr:`left_alone` are the constraints that cannot be followed there.

        Raises
        ------
        InvalidInput : faces that the level does not have, or too few to have anything inside.
        """
        if level is None:
            self._live.release()
        else:
            number = self._require_level(level)
            self._live.hold(number, checked_faces(self._levels, number, faces))

    @property
    def is_whole(self) -> bool:
        """Whether every level refines all faces, and edits change all of the surface."""
        partial = any(isinstance(level, PartialLevel) for level in self._levels)
        return not partial and self._live.region is None

    @property
    def left_alone(self) -> list[Constraint]:
        """Constraints that ask for something else since :meth:`smooth_only`, but not inside."""
        return [] if self._live.region is None else self._live.region.left_alone

    def refine(self, faces: ArrayLike) -> int:
        """Add a level that refines only some faces of the finest one, and return its number.

        Its vertices and faces have numbers of their own: see :meth:`vertex_of`. Those on its rim,
        next to faces that stay as they are, stay where the coarser level has them.
        """
        return refine(self._live, checked_faces(self._levels, self.levels, faces))

    def refine_near_constraints(self, rings: int = 2) -> int:
        """As :meth:`refine`, for the faces in rings around constraints of the finest level."""
        count = checked_count(rings, "rings")
        return refine(self._live, faces_near_constraints(self._system, count))

    def vertex_of(self, level: int, vertex: int) -> int:
        """The number at a level of a vertex of :meth:`surface`, at any level."""
        return vertex_of(self._meshes, self._require_level(level), vertex)

    def faces_around(self, level: int, vertices: ArrayLike, rings: int = 1) -> Any:
        """The faces of a level in rings around vertices of it."""
        faces = self._levels[self._require_level(level)].connectivity
        return faces_around(faces, vertices, checked_count(rings, "rings"))

    def with_cage(self, cage: Any, rings: int = 2) -> Designer:
        """The same design on a cage that is mostly the same, most of it without another solve.

        Vertices of both cages are the same where they have one place, and else by their numbers;
        faces and constraints follow from them. The surface is made anew around the change as by
        :meth:`smooth_only`, and is to the bit what it was elsewhere, until ``smooth_only()``.
        :attr:`lost` are the constraints that have no place on the new cage.

        Parameters
        ----------
        rings : of faces of the cage around the change that are smoothed anew.

        Raises
        ------
        InvalidInput : a part is refined alone, or as for a new designer.
        """
        made, lost = with_cage(cast("Designer", self), cage, checked_count(rings, "rings"))
        made._lost = lost
        return made

    @property
    def lost(self) -> list[Constraint]:
        """Constraints of the designer this one comes from that have no place on its cage."""
        return list(self._lost)

    def _require_level(self, level: int) -> int:
        if not isinstance(level, int | np.integer) or isinstance(level, bool):
            raise InvalidInput(f"level must be a whole number, not {level!r}")
        if not 0 <= level <= self.levels:
            raise InvalidInput(f"there is no level {level}; levels are 0 to {self.levels}")
        return int(level)
