"""Designers kept ready while a recipe changes, one for each level that is looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.design import Designer
from henkei.design.constraints import Constraint as Asked
from henkei.design.refinement import Connectivity, connectivity, counts, refined, refined_positions
from henkei.design.settings import MOST_LEVELS, checked_refinement
from henkei.fans import fan_triangles
from henkei.mesh import Floats, Surface
from henkei.progress import Progress, silent
from henkei.recipes.design import KINDS, Constraint, Curve, DesignRecipe, Pin
from henkei.recipes.recipe import ORIGIN
from henkei.studio.drawables import frame_of, normalised, surface_header
from henkei.workflows.design_by_recipe import add_constraint, designer_of
from henkei.workflows.design_places import Places

QUICK = 120_000  # vertices up to which a level is shown unasked
LIVE = 16_000  # vertices up to which the whole surface follows settings at once
SLOW = 200_000  # vertices from which on progress is told


@dataclass(frozen=True)
class Size:
    """How large a level is."""

    vertices: int
    edges: int
    faces: int


@dataclass(frozen=True, eq=False)
class Response:
    """How a level answers a drag: positions (n, 3) are ``start + response * step``; the response is
    (n,), or (n, 3) by axis."""

    start: Floats
    response: Floats


class Engine:
    """Designers of one cage.

    Level k of a design is what it would be if k were the last, so that only as much is solved as
    is seen.

    Parameters
    ----------
    recipe : whose refinement and filters are used; designers for others need another engine.

    Attributes
    ----------
    quads : whether faces are cut into quads.

    Raises
    ------
    HenkeiError : the cage cannot be refined so.
    """

    def __init__(self, cage: Surface, recipe: DesignRecipe) -> None:
        self._cage = cage
        base = connectivity(cage)
        self.quads = checked_refinement(recipe.refinement, bool((base.sizes == 3).all()))
        self._faces = [base]
        self._kept: dict[int, _Kept] = {}
        self._detail: Floats | None = None

    @cached_property
    def sizes(self) -> list[Size]:
        """Of all levels that there can be."""
        return [Size(*one) for one in counts(self._faces[0], self.quads, MOST_LEVELS)]

    def quick_level(self, finest: int) -> int:
        """The finest level that is shown without asking."""
        fitting = [k for k in range(finest + 1) if self.sizes[k].vertices <= QUICK]
        return max(fitting, default=0)

    def designer(self, recipe: DesignRecipe, level: int, progress: Progress = silent) -> Designer:
        """A designer whose finest level this is, with all that a recipe asks up to it.

        Raises
        ------
        HenkeiError : a constraint does not fit the cage, nothing holds the surface, or the level
            does not fit into memory.
        """
        kept = self._kept.get(level)
        if kept is None or not kept.can_become(recipe):
            self._kept[level] = kept = _Kept(self._cage, recipe, level)
        kept.become(recipe)
        if self.sizes[level].vertices >= SLOW:
            kept.designer.solve(progress)
        return kept.designer

    def positions(self, recipe: DesignRecipe, level: int, progress: Progress = silent) -> Floats:
        """Positions (n, 3) of the surface of a level."""
        return self.designer(recipe, level, progress).surface().vertices

    def begin(self, recipe: DesignRecipe, level: int) -> None:
        """From now on settings change many times a second: see :meth:`live_positions`."""
        if self.sizes[level].vertices > LIVE:
            self._detail = self.positions(recipe, level) - self._refined(recipe, level)

    def settle(self) -> None:
        """Settings have come to rest."""
        self._detail = None

    def live_positions(
        self, recipe: DesignRecipe, level: int, progress: Progress = silent
    ) -> Floats:
        """As :meth:`positions`; but since :meth:`begin`, and until :meth:`settle`, what levels of
        very many vertices add to coarser ones stays as it was, which hardly shows."""
        if self._detail is None or len(self._detail) != self.sizes[level].vertices:
            return self.positions(recipe, level, progress)
        refined = self._refined(recipe, level)
        refined += self._detail
        return refined

    def _refined(self, recipe: DesignRecipe, level: int) -> Floats:
        """A level that is only the finest quick one, refined (n, 3)."""
        coarse = max(k for k in range(level + 1) if not k or self.sizes[k].vertices <= LIVE)
        positions = self.positions(recipe, coarse)
        for k in range(coarse, level):
            positions = refined_positions(self.faces(k), self.quads, positions)
        return positions

    def response(self, recipe: DesignRecipe, level: int, name: str) -> Response | None:
        """How a level answers to a constraint's target being moved as a whole."""
        asked = self.asked(recipe, level).get(name)
        if asked is None:
            return None
        designer = self.designer(recipe, level)
        drag = designer.drag(asked)
        response = drag.response
        return Response(
            drag.positions(ORIGIN), response.ravel() if response.shape[1] == 1 else response
        )

    def difference(self, recipe: DesignRecipe, moved: DesignRecipe, level: int) -> Response:
        """How a level answers a change of targets, of which ``moved`` has a step of 1 along all
        axes: the surface is linear in them."""
        start = self.positions(recipe, level)
        return Response(start, self.positions(moved, level) - start)

    def asked(self, recipe: DesignRecipe, level: int) -> Mapping[str, Asked]:
        """The constraints of a level's designer by name."""
        return {one.name: one for one in self.designer(recipe, level).constraints}

    def flat(self, recipe: DesignRecipe, level: int) -> Floats:
        """The vertices (n, 3) of the cage as refined to a level."""
        return self.designer(recipe, level).flat(level).vertices

    def grid(self, level: int) -> list[int]:
        """How many of a level's edges lie on edges of each level up to it; those come first."""
        return [self.sizes[k].edges << (level - k) for k in range(level + 1)]

    def drawable(
        self, recipe: DesignRecipe, level: int
    ) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
        """What the page draws of a level, as :func:`henkei.studio.drawables.drawable` has it.

        Positions are those of the flat cage. Edges are in the order of :meth:`grid`, and creases
        the same, so that the page can draw the edges of a coarser level.
        """
        faces, flat = self.faces(level), self.flat(recipe, level)
        centre, scale = frame_of(self._cage)
        header = surface_header(centre, scale, faces.vertex_count, faces.face_count)
        edges = faces.edges.astype(np.uint32)
        arrays: dict[str, NDArray[Any]] = {
            "positions": normalised(flat, centre, scale),
            "edges": edges,
            "creases": edges,
        }
        if (faces.sizes == 3).all():
            arrays["triangles"] = faces.indices.reshape(-1, 3).astype(np.uint32)
        else:
            corners, parent = fan_triangles(flat, faces.indices, faces.offsets)
            arrays["triangles"] = faces.indices[corners].astype(np.uint32)
            arrays["face"] = parent.astype(np.uint32)
        return header, arrays

    def faces(self, level: int) -> Connectivity:
        """The faces of a level."""
        while len(self._faces) <= level:
            self._faces.append(refined(self._faces[-1], self.quads))
        return self._faces[level]


class _Kept:
    """A designer of some depth, and the parts of the recipe that it has."""

    def __init__(self, cage: Surface, recipe: DesignRecipe, level: int) -> None:
        empty = {"levels": level, "gamma": _gamma(recipe, level), "unpin": ()}
        self.designer = designer_of(
            cage, recipe.model_copy(update={**empty, **dict.fromkeys(KINDS, ())})
        )
        self._places = Places.on_cage(self.designer)
        self._cage_size = len(cage.vertices)
        self._level = level
        self._freed: frozenset[int] = frozenset()
        self._parts: dict[str, Constraint] = {}

    def can_become(self, recipe: DesignRecipe) -> bool:
        """Whether no vertex of the cage would have to be held again."""
        return self._freed <= freed(recipe, self._cage_size)

    def become(self, recipe: DesignRecipe) -> None:
        """Do what the recipe asks and was not done yet, and undo what it does not ask."""
        free = freed(recipe, self._cage_size)
        if free - self._freed:
            self.designer.unpin(sorted(free - self._freed))
            self._freed = free
        self._set(recipe)
        wanted = _parts(recipe, self._level)
        asked = {one.name: one for one in self.designer.constraints}
        for name, part in list(self._parts.items()):
            new = wanted.get(name)
            if new is part or new == part:
                continue
            if new is not None and _only_moved(part, new):
                assert isinstance(new, Pin | Curve)
                self.designer.move(asked[name], np.array(new.to))
                self._parts[name] = new
            else:
                self.designer.remove(asked[name])
                del self._parts[name]
        for name, part in wanted.items():
            if name not in self._parts:
                add_constraint(self.designer, part, name, name, self._places)
                self._parts[name] = part

    def _set(self, recipe: DesignRecipe) -> None:
        """Settings that are not as the recipe has them; each makes shapes old."""
        designer, gamma = self.designer, _gamma(recipe, self._level)
        if not np.array_equal(designer.gamma, gamma):
            designer.gamma = gamma
        if not _alike(designer.axis_gamma, recipe.axis_gamma):
            designer.axis_gamma = recipe.axis_gamma
        if designer.axis_smoothing != recipe.axis_smoothing:
            designer.axis_smoothing = recipe.axis_smoothing
        if designer.steps != recipe.steps:
            designer.steps = recipe.steps


def freed(recipe: DesignRecipe, count: int) -> frozenset[int]:
    """The vertices of a cage of ``count`` that are let go."""
    return frozenset(range(count) if recipe.unpin == "all" else recipe.unpin)


def pulled(line: Floats, index: int, by: Floats, reach: float) -> Floats:
    """A line of which one point is moved, and others the less the farther along they are.

    Parameters
    ----------
    line : (t, 3); closed if the first is the last.
    by : (3,) how far that point goes.
    reach : how far along its neighbours follow, as a part of the length; 0: none does.
    """
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    apart = np.abs(along - along[index])
    closed = np.array_equal(line[0], line[-1])
    if closed:
        apart = np.minimum(apart, along[-1] - apart)
    share = (apart == 0).astype(float)
    near = apart < reach * along[-1]
    share[near] = np.cos(np.pi * apart[near] / (reach * along[-1])) / 2 + 0.5
    if closed:
        share[-1] = share[0]
    moved: Floats = line + share[:, None] * by
    return moved


def _parts(recipe: DesignRecipe, level: int) -> dict[str, Constraint]:
    """The constraints up to a level, by name."""
    return {
        name: one
        for kind in KINDS
        for name, one in zip(recipe.names(kind), recipe.parts(kind), strict=True)
        if one.level <= level
    }


def _only_moved(part: Constraint, new: Constraint) -> bool:
    """Whether the same place is only to go elsewhere."""
    if not isinstance(new, Pin | Curve) or type(part) is not type(new) or new.to is None:
        return False
    return part.model_copy(update={"to": new.to, "move": ORIGIN}) == new


def _gamma(recipe: DesignRecipe, level: int) -> float | tuple[float, ...]:
    """gamma, or its weights up to a level."""
    return recipe.gamma[: level + 1] if isinstance(recipe.gamma, tuple) else recipe.gamma


def _alike(one: Floats | None, other: tuple[float, ...] | None) -> bool:
    if one is None or other is None:
        return one is None and other is None
    return np.array_equal(one, other)
