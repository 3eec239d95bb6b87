"""Levels that refine only some faces, where the constraints are fine.

Wished for in section 9 of S. Takahashi: Designing subdivision surfaces via multiresolution-based
local filtering (2000). Inside, such a level is like every other; on its rim, where faces beside are
not refined, vertices stay where the level before has them, so that nothing gapes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from henkei.design.attached import Attached, ways_to_yield, yielding
from henkei.design.constraints import Constraint
from henkei.design.levels import Level, Levels, compact
from henkei.design.part import Part, PartialLevel
from henkei.design.paths import is_index
from henkei.design.projection import Projection, Sparse, applied
from henkei.design.refinement import Connectivity, prolongation, refined
from henkei.design.settings import MOST_LEVELS
from henkei.errors import InvalidInput, some
from henkei.mesh import Floats

if TYPE_CHECKING:
    from henkei.design.live import Live
    from henkei.design.meshes import Meshes
    from henkei.design.system import System


def refined_in_part(coarse: Level, faces: NDArray[np.integer]) -> PartialLevel:
    """The level that refines only some faces, ascending, of another.

    Raises
    ------
    InvalidInput : the children are too many for indices of 32 bits.
    """
    whole = coarse.connectivity
    part, origin = whole.part(faces)
    fine = refined(part, coarse.quads)
    rim = np.zeros(len(fine.edges), dtype=bool)
    rim[: 2 * len(part.edges)] = np.repeat(_ends_inside(coarse, part, faces), 2)
    free = np.ones(fine.vertex_count, np.uint8)
    free[fine.edges[rim]] = 0
    old = (np.ones(len(origin)), (np.arange(len(origin)), origin))
    selected = csr_array(old, shape=(len(origin), whole.vertex_count))
    return PartialLevel(
        coarse.number + 1,
        fine,
        coarse.quads,
        compact(prolongation(part, coarse.quads) @ selected),
        free,
        faces=faces.astype(np.int32),
        origin=origin,
        rim=rim,
    )


def _ends_inside(
    coarse: Level, part: Connectivity, faces: NDArray[np.integer]
) -> NDArray[np.bool_]:
    """Which edges of a part have a face beside them that is not in it, on this level or before."""
    whole = coarse.connectivity
    sides = np.bincount(whole.corner_edges, minlength=len(whole.edges))
    if isinstance(coarse, PartialLevel):
        sides += coarse.rim
    corners = np.repeat(np.isin(np.arange(whole.face_count), faces), whole.sizes)
    edges = np.unique(whole.corner_edges[corners])  # in the order of the part's
    inside: NDArray[np.bool_] = np.bincount(part.corner_edges) < sides[edges]
    return inside


class Within:
    """The constraints of levels up to a partial one, acting on it: a projection.

    What coarser levels have found stays as it is; only rows that reach into the part take part.
    """

    def __init__(
        self, system: System, number: int, here: Sparse | None, before: Projection
    ) -> None:
        levels = Levels(system.levels[: number + 1])
        part = Part(levels, number, np.arange(levels[number].connectivity.face_count))
        attached = Attached(system, part)
        self._inner = attached.projection(number)
        self._reaching = attached.places(number)
        self._near = attached.near(number)[:, None]
        self._here, null = here, before.nullspace
        self._held = self._reaching < len(null)
        _, own = ways_to_yield(self._inner.nullspace, self._held)
        own = np.linalg.qr(own[~self._held])[0]
        of_before = np.concatenate([null, np.zeros((own.shape[0], null.shape[1]))])
        of_own = np.concatenate([np.zeros((null.shape[0], own.shape[1])), own])
        self.nullspace = np.concatenate([of_before, of_own], axis=1)

    def measure(self, change: Floats) -> Floats:
        found = np.zeros((len(self.nullspace), change.shape[1]))
        found[self._reaching] = self._near * self._inner.measure(change)
        return found

    def here(self, positions: Floats) -> Floats:
        return applied(self._here, positions)

    def correct(self, change: Floats, missing: Floats) -> None:
        rest = missing[self._reaching] / self._near
        self._inner.correct(change, yielding(self._inner.nullspace, self._held, rest))


def analysis_in_part(level: PartialLevel, coarse: Level) -> Sparse:
    """What old vertices of a partial level are on the level before, if there are no wavelets."""
    old = np.arange(len(level.origin))
    return compact(csr_array((np.ones(len(old)), (level.origin, old)), (coarse.size, level.size)))


def refine(live: Live, faces: NDArray[np.integer]) -> int:
    """Add a level that refines only some faces of the finest one; its number.

    Raises
    ------
    InvalidInput : wavelets are on a number of rings, a part of the surface is held, or the level is
        too deep.
    """
    system = live.system
    levels = system.levels
    if isinstance(system.support, int):
        raise InvalidInput("only with support=None or interpolating=True a part can be refined")
    if live.region is not None:
        raise InvalidInput("call smooth_only() before a part is refined; it can be set again then")
    if len(levels) > MOST_LEVELS:
        raise InvalidInput(f"there are {MOST_LEVELS} levels already, and no more are possible")
    levels.append(refined_in_part(levels[-1], faces))
    gamma = live.settings.gamma
    if isinstance(gamma, np.ndarray):
        live.settings = replace(
            live.settings, gamma=np.append(gamma, gamma[-1] ** 2 / gamma[-2:][0])
        )
    return len(levels) - 1


def require_free(levels: Levels, one: Constraint) -> None:
    """Raise InvalidInput for a constraint that acts only on the rim of a refined part."""
    free = levels[one.level].free
    if free is not None and not free[one.rows.indices].any():
        raise InvalidInput(
            f"{one} lies on the rim of what level {one.level} refines, where nothing may move; "
            "refine more faces around it"
        )


def faces_near_constraints(system: System, rings: int) -> NDArray[np.integer]:
    """Faces of the finest level in rings around its constraints, or around those of the finest
    level before it that has any, as vertices keep their numbers as long as all faces are refined.

    Raises
    ------
    InvalidInput : there are none.
    """
    number = len(system.levels) - 1
    level = max((one.level for one in system.constraints), default=-1)
    if level < 0:
        raise InvalidInput("there are no constraints to refine around; name the faces instead")
    if any(isinstance(between, PartialLevel) for between in system.levels[level + 1 :]):
        raise InvalidInput(
            f"level {number}, the finest, has no constraints to refine around; name its faces, as "
            "by faces_around(level, vertices)"
        )
    rows = [one.rows.indices for one in system.of_level(level)]
    return faces_around(system.levels[number].connectivity, np.concatenate(rows), rings)


def faces_around(faces: Connectivity, vertices: ArrayLike, rings: int) -> NDArray[np.integer]:
    """Faces in rings around vertices, ascending.

    Raises
    ------
    InvalidInput : vertices that there are not.
    """
    given = np.atleast_1d(np.asarray(vertices))
    if given.ndim != 1 or given.dtype.kind not in "iu":
        raise InvalidInput(f"vertices are whole numbers, not {vertices!r}")
    bad = given[(given < 0) | (given >= faces.vertex_count)]
    if len(bad):
        raise InvalidInput(f"there are no vertices {some(bad)}, only 0 to {faces.vertex_count - 1}")
    near = np.zeros(faces.vertex_count, dtype=bool)
    near[given] = True
    chosen = np.zeros(faces.face_count, dtype=bool)
    for _ in range(rings):
        chosen = np.logical_or.reduceat(near[faces.indices], faces.offsets[:-1])
        near[faces.indices[np.repeat(chosen, faces.sizes)]] = True
    return np.flatnonzero(chosen)


def vertex_of(meshes: Meshes, number: int, vertex: Any) -> int:
    """The number at a level of a vertex of the finest surface.

    Raises
    ------
    InvalidInput : the level does not have it.
    """
    found = np.flatnonzero(meshes.conforming(number).numbers[number] == vertex)
    if not is_index(vertex) or not len(found):
        raise InvalidInput(
            f"vertex {vertex!r} of the surface is no vertex of level {number}: it is finer, or not "
            "where that level refines"
        )
    return int(found[0])
