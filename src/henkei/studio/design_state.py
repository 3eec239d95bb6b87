"""What the tab of design holds, and what follows from it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from henkei.design.settings import MOST_LEVELS
from henkei.errors import InvalidInput, some
from henkei.mesh import Floats
from henkei.recipes.design import KINDS, Constraint, Curve, DesignRecipe, Kind
from henkei.recipes.recipe import Index, Part
from henkei.studio.designing import Engine
from henkei.studio.services import Services
from henkei.studio.tabs.base import MeshId, TabState

Level = Annotated[Index, Field(le=MOST_LEVELS)]


class Stroke(Part):
    """A curve that is being drawn.

    through : vertices of its level that it goes through, in turn.
    """

    level: Level
    through: tuple[Index, ...] = Field(min_length=1)


class DesignState(TabState):
    """The cage, what its surface shall meet, and the level that is looked at.

    shown : none: the finest that is quick to work with.
    stroke : the curve that is being drawn.
    """

    slots: ClassVar[tuple[str, ...]] = ("cage",)
    cage: MeshId | None = None
    recipe: DesignRecipe = DesignRecipe()
    shown: Level | None = None
    stroke: Stroke | None = None

    def saying(self, **changes: Any) -> DesignState:
        """With a recipe changed in some fields, checked as a whole."""
        recipe = self.recipe.model_copy(update=changes)
        checked = DesignRecipe.of(recipe.model_dump(exclude_defaults=True))
        return self.model_copy(update={"recipe": checked})

    def part(self, name: str) -> tuple[Kind, int, Constraint]:
        """The kind, place and data of a constraint.

        Raises
        ------
        InvalidInput : there is none of this name.
        """
        for kind in KINDS:
            names = self.recipe.names(kind)
            if name in names:
                index = names.index(name)
                return kind, index, self.recipe.parts(kind)[index]
        raise InvalidInput(f"there is no {name!r} any more; it may have been removed")

    def with_part(self, name: str, part: Constraint | None) -> DesignState:
        """With another constraint in place of one, or without it. Only its form is checked."""
        kind, index, _ = self.part(name)
        parts = self.recipe.parts(kind)
        new = (*parts[:index], *([] if part is None else [part]), *parts[index + 1 :])
        return self.model_copy(update={"recipe": self.recipe.model_copy(update={kind: new})})


def engine_of(state: DesignState, services: Services) -> Engine:
    """Designers for the cage, the refinement and the filters of a state.

    Raises
    ------
    HenkeiError : there is no cage, or it cannot be refined.
    """
    surface, recipe = services.entry(state.cage).surface, state.recipe
    key = (surface, recipe.refinement, recipe.support, recipe.interpolating)
    return services.engine("design", key, lambda: Engine(services.blobs.surface(surface), recipe))


def level_of(state: DesignState, engine: Engine) -> int:
    """The level that is looked at."""
    finest = state.recipe.levels
    return engine.quick_level(finest) if state.shown is None else min(state.shown, finest)


def path_of(state: DesignState, stroke: Stroke, services: Services) -> list[int]:
    """The vertices along edges that a stroke goes through."""
    if len(stroke.through) < 2:
        return list(stroke.through)
    engine = engine_of(state, services)
    designer = engine.designer(state.recipe, max(stroke.level, level_of(state, engine)))
    return designer.path(stroke.level, stroke.through)


def named(recipe: DesignRecipe) -> DesignRecipe:
    """A recipe that says the names of all constraints, so that they stay when others go."""
    said: dict[str, Any] = {
        kind: tuple(
            one.model_copy(update={"name": name})
            for one, name in zip(recipe.parts(kind), recipe.names(kind), strict=True)
        )
        for kind in KINDS
    }
    return recipe.model_copy(update=said)


def positions_of(
    state: DesignState, level: int, vertices: Sequence[int], services: Services
) -> Floats:
    """Where the surface of a level has vertices (k,) of it: (k, 3).

    Raises
    ------
    InvalidInput : the level or a vertex does not exist.
    """
    engine = engine_of(state, services)
    if level > state.recipe.levels:
        raise InvalidInput(f"there is no level {level}; the finest is {state.recipe.levels}")
    missing = [one for one in vertices if one >= engine.sizes[level].vertices]
    if missing:
        raise InvalidInput(f"level {level} has no vertices {some(missing)}")
    designer = engine.designer(state.recipe, max(level, level_of(state, engine)))
    return designer.surface(level).vertices[vertices]


def line_of(state: DesignState, name: str, curve: Curve, services: Services) -> Floats:
    """Where a curve goes (t, 3)."""
    if curve.to is not None:
        return np.array(curve.to)
    engine = engine_of(state, services)
    level = max(curve.level, level_of(state, engine))
    return engine.asked(state.recipe, level)[name].target


def new_name(state: DesignState, one: str) -> str:
    """The first of ``pin 1`` and so on that nothing has."""
    taken = {name for kind in KINDS for name in state.recipe.names(kind)}
    return next(name for i in range(1, len(taken) + 2) if (name := f"{one} {i}") not in taken)
