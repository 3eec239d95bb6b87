"""Designing live: pins and curves at the levels of a cage; a recipe of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from henkei.design.settings import MOST_STEPS, checked_axis_gamma, checked_gamma
from henkei.errors import HenkeiError, InvalidInput, some
from henkei.mesh import Floats
from henkei.recipes.design import KINDS, Curve, DesignRecipe, Flag, Pin
from henkei.recipes.recipe import ORIGIN, Index, Name, Number, Point, Positive
from henkei.studio.design_state import DesignState as DesignState
from henkei.studio.design_state import (
    Level,
    Stroke,
    engine_of,
    level_of,
    line_of,
    named,
    new_name,
    path_of,
    positions_of,
)
from henkei.studio.design_view import described
from henkei.studio.designing import Engine, Response, freed, pulled
from henkei.studio.services import Services
from henkei.studio.tabs.base import Action, Basis, Tab, actions

Share = Annotated[Number, Field(ge=0, le=1)]
SURFACE = "surface"


class Show(Action[DesignState]):
    """Look at the surface of a level."""

    label: ClassVar[str] = "show level"
    level: Level

    def apply(self, state: DesignState, services: Services) -> DesignState:
        if self.level > state.recipe.levels:
            raise InvalidInput(
                f"there is no level {self.level}; the finest is {state.recipe.levels}, raise it to "
                "see more"
            )
        return state.model_copy(update={"shown": self.level})


class AddPin(Action[DesignState]):
    """Pin a vertex of a level where the surface of that level has it."""

    label: ClassVar[str] = "add pin"
    level: Level
    vertex: Index

    def apply(self, state: DesignState, services: Services) -> DesignState:
        at = positions_of(state, self.level, [self.vertex], services)[0]
        for name, pin in zip(state.recipe.names("pins"), state.recipe.pins, strict=True):
            if (pin.level, pin.point) == (self.level, self.vertex):
                raise InvalidInput(f"{name!r} is at this vertex of level {self.level} already")
        pin = Pin(
            name=new_name(state, "pin"), level=self.level, point=self.vertex, to=tuple(at.tolist())
        )
        return state.saying(pins=(*state.recipe.pins, pin))


class MovePin(Action[DesignState]):
    """Let a pin's point go to another place."""

    label: ClassVar[str] = "move pin"
    name: Name
    to: Point

    def apply(self, state: DesignState, services: Services) -> DesignState:
        _, _, pin = state.part(self.name)
        if not isinstance(pin, Pin):
            raise InvalidInput(f"{self.name!r} is no pin")
        return state.with_part(self.name, pin.model_copy(update={"to": self.to, "move": ORIGIN}))


class Draw(Action[DesignState]):
    """Begin a curve at a vertex of a level, or go on with it.

    It follows edges. Through its first vertex again it is closed, and ends.
    """

    label: ClassVar[str] = "draw curve"
    level: Level
    vertex: Index

    def apply(self, state: DesignState, services: Services) -> DesignState:
        positions_of(state, self.level, [self.vertex], services)
        stroke = state.stroke
        if stroke is None:
            begun = Stroke(level=self.level, through=(self.vertex,))
            return state.model_copy(update={"stroke": begun})
        if stroke.level != self.level:
            raise InvalidInput(
                f"the curve is drawn at level {stroke.level}; end it first, or go on at that level"
            )
        if self.vertex == stroke.through[-1]:
            return state
        longer = stroke.model_copy(update={"through": (*stroke.through, self.vertex)})
        path_of(state, longer, services)  # refused here where no edges lead there
        drawn = state.model_copy(update={"stroke": longer})
        return _curve_added(drawn, services) if self.vertex == stroke.through[0] else drawn


class EndCurve(Action[DesignState]):
    """Make a curve of what was drawn: it goes where the surface of its level has it."""

    label: ClassVar[str] = "add curve"

    def apply(self, state: DesignState, services: Services) -> DesignState:
        if state.stroke is None or len(state.stroke.through) < 2:
            raise InvalidInput("a curve needs at least two points; click them along the surface")
        return _curve_added(state, services)


class DropCurve(Action[DesignState]):
    """Leave what was drawn."""

    label: ClassVar[str] = "leave curve"

    def apply(self, state: DesignState, services: Services) -> DesignState:
        return state.model_copy(update={"stroke": None})


class MoveCurve(Action[DesignState]):
    """Move the line that a curve goes to: as a whole, or one of its points.

    index : of the point; none: all of them.
    by : how far from where it is.
    reach : how far along the line others follow, as a part of its length.
    """

    label: ClassVar[str] = "move curve"
    name: Name
    by: Point
    index: Index | None = None
    reach: Share = 0.0

    def apply(self, state: DesignState, services: Services) -> DesignState:
        _, _, curve = state.part(self.name)
        if not isinstance(curve, Curve):
            raise InvalidInput(f"{self.name!r} is no curve")
        line, by = line_of(state, self.name, curve, services), np.array(self.by)
        if self.index is None:
            line = line + by
        elif self.index >= len(line):
            raise InvalidInput(f"{self.name!r} has no point {self.index}, only {len(line)} points")
        else:
            line = pulled(line, self.index, by, self.reach)
        to = tuple(map(tuple, line.tolist()))
        return state.with_part(self.name, curve.model_copy(update={"to": to, "move": ORIGIN}))


class Remove(Action[DesignState]):
    """Take a pin, curve or derivative away."""

    label: ClassVar[str] = "remove"
    name: Name

    def apply(self, state: DesignState, services: Services) -> DesignState:
        said = state.model_copy(update={"recipe": named(state.recipe)})
        return _held(said.with_part(self.name, None), services)


class Rename(Action[DesignState]):
    """Give a pin, curve or derivative another name."""

    label: ClassVar[str] = "rename"
    name: Name
    to: Name

    def apply(self, state: DesignState, services: Services) -> DesignState:
        part = state.part(self.name)[2].model_copy(update={"name": self.to})
        return state.with_part(self.name, part).saying()


class Hold(Action[DesignState]):
    """Hold vertices of the cage where it has them, or let them go.

    vertices : none: all.
    """

    label: ClassVar[str] = "hold or let go"
    held: Flag
    vertices: tuple[Index, ...] | None = None

    def apply(self, state: DesignState, services: Services) -> DesignState:
        count = services.entry(state.cage).vertices
        chosen = frozenset(range(count) if self.vertices is None else self.vertices)
        missing = sorted(one for one in chosen if one >= count)
        if missing:
            raise InvalidInput(f"the cage has no vertices {some(missing)}; it has 0 to {count - 1}")
        now = freed(state.recipe, count)
        free = now - chosen if self.held else now | chosen
        unpin = "all" if len(free) == count else tuple(sorted(free))
        recipe = state.recipe.model_copy(update={"unpin": unpin})
        return _held(state.model_copy(update={"recipe": recipe}), services)


class Change(Action[DesignState]):
    """Change settings; those that are not named stay."""

    label: ClassVar[str] = "change settings"
    gamma: Positive | None = None
    axis_gamma: tuple[Positive, Positive, Positive] | Literal["off"] | None = None
    axis_smoothing: tuple[Flag, Flag, Flag] | None = None
    steps: Annotated[Index, Field(le=MOST_STEPS)] | None = None
    interpolating: Flag | None = None
    refinement: Literal["auto", "triangles", "quads"] | None = None
    about: str | None = None

    def apply(self, state: DesignState, services: Services) -> DesignState:
        changes = {name: value for name, value in dict(self).items() if value is not None}
        if self.gamma is not None:
            checked_gamma(self.gamma, state.recipe.levels)
        if self.axis_gamma == "off":
            changes["axis_gamma"] = None
        else:
            checked_axis_gamma(self.axis_gamma)
        if self.interpolating:
            changes["support"] = None
        changed = state.model_copy(update={"recipe": state.recipe.model_copy(update=changes)})
        if self.refinement is not None:
            _require_same_vertices(state, changed, services)
        return changed


class SetLevels(Action[DesignState]):
    """Refine the cage so many times."""

    label: ClassVar[str] = "change levels"
    levels: Level

    def apply(self, state: DesignState, services: Services) -> DesignState:
        recipe = state.recipe
        finer = [
            name
            for kind in KINDS
            for name, one in zip(recipe.names(kind), recipe.parts(kind), strict=True)
            if one.level > self.levels
        ]
        if finer:
            raise InvalidInput(
                f"{some(map(repr, finer))} would have no level any more; remove them first, or "
                f"keep at least {max(one.level for kind in KINDS for one in recipe.parts(kind))} "
                "levels"
            )
        changes: dict[str, Any] = {"levels": self.levels}
        if isinstance(recipe.gamma, tuple):
            changes["gamma"] = (*recipe.gamma, *recipe.gamma[-1:] * self.levels)[: self.levels + 1]
        shown = None if state.shown is None else min(state.shown, self.levels)
        stroke = state.stroke if state.stroke and state.stroke.level <= self.levels else None
        changed = state.model_copy(update={"shown": shown, "stroke": stroke})
        return changed.saying(**changes)


class Load(Action[DesignState]):
    """Take a whole recipe."""

    label: ClassVar[str] = "open recipe"
    recipe: dict[str, Any]

    def apply(self, state: DesignState, services: Services) -> DesignState:
        recipe = named(DesignRecipe.of(self.recipe))
        loaded = state.model_copy(update={"recipe": recipe, "shown": None, "stroke": None})
        engine = engine_of(loaded, services)
        finest = max((one.level for kind in KINDS for one in recipe.parts(kind)), default=0)
        engine.designer(recipe, max(finest, level_of(loaded, engine)))  # all fits, or is refused
        return loaded


class DesignTab(Tab[DesignState]):
    """Designing: the surface follows while pins, curves and gamma are moved."""

    def view(self, state: DesignState, services: Services) -> dict[str, Any]:
        if state.cage is None:
            return {"surfaces": {}, "next": "Open a coarse mesh, or one of the examples."}
        cage = {"data": services.drawn(services.entry(state.cage).surface)}
        view: dict[str, Any] = {"surfaces": {"cage": cage}}
        try:
            engine = engine_of(state, services)
            engine.settle()
            level = level_of(state, engine)
            data = _drawn(state, engine, level, services)
            view |= described(engine, state.recipe, level, services.progress)
            view["surfaces"] = {SURFACE: {"data": data, "live": True}, "cage": cage}
            if state.stroke is not None:
                view["path"] = path_of(state, state.stroke, services)
        except HenkeiError as error:
            view["problem"] = str(error)
        return view

    def frames(self, state: DesignState, services: Services) -> dict[str, Floats]:
        if state.cage is None:
            return {}
        engine = engine_of(state, services)
        level = level_of(state, engine)
        return {SURFACE: engine.live_positions(state.recipe, level, services.progress)}

    def basis(
        self, state: DesignState, what: Mapping[str, Any], services: Services
    ) -> Basis | None:
        """``what`` is the ``name`` of what is moved, with ``index`` and ``reach`` as in
        :class:`MoveCurve`; without a name, settings are about to be changed."""
        engine, name = engine_of(state, services), str(what.get("name"))
        level = level_of(state, engine)
        if what.get("name") is None:
            engine.begin(state.recipe, level)
            return None
        if state.part(name)[2].level > level:
            return None
        found: Response | None
        if what.get("index") is None:
            found = engine.response(state.recipe, level, name)
        else:
            one = {"index": what["index"], "reach": what.get("reach", 0.0)}
            step = TAB.action("move_curve", {"name": name, "by": [1.0, 1.0, 1.0], **one})
            moved = step.apply(state, services).recipe
            found = engine.difference(state.recipe, moved, level)
        return None if found is None else Basis(SURFACE, found.start, found.response)

    def settle(self, services: Services) -> None:
        engine = services.present("design")
        if isinstance(engine, Engine):
            engine.settle()


def _drawn(state: DesignState, engine: Engine, level: int, services: Services) -> str:
    """The blob with what the page draws of a level; the same whatever is asked of the surface."""
    key = (services.entry(state.cage).surface, engine.quads, level)

    def make() -> str:
        header, arrays = engine.drawable(state.recipe, level)
        return services.blobs.put_message(header, **arrays)

    return services.remembered(("design", *key), make)


def _require_same_vertices(state: DesignState, changed: DesignState, services: Services) -> None:
    """Refuse to cut faces in another way where constraints count on it."""
    finer = [one for kind in KINDS for one in state.recipe.parts(kind) if one.level]
    if finer and engine_of(state, services).quads != engine_of(changed, services).quads:
        raise InvalidInput(
            "pins and curves of level 1 and finer count on how faces are cut; remove them first"
        )
    engine_of(changed, services)


def _curve_added(state: DesignState, services: Services) -> DesignState:
    """With a curve in place of the stroke."""
    assert state.stroke is not None
    path = path_of(state, state.stroke, services)
    level = state.stroke.level
    line = positions_of(state, level, path, services)
    to = tuple(map(tuple, line.tolist()))
    curve = Curve(name=new_name(state, "curve"), level=level, path=tuple(path), to=to)
    ended = state.model_copy(update={"stroke": None})
    return ended.saying(curves=(*state.recipe.curves, curve))


def _held(state: DesignState, services: Services) -> DesignState:
    """The state, if something says where its surface is."""
    recipe = state.recipe
    count = services.entry(state.cage).vertices
    if len(freed(recipe, count)) < count or any(recipe.parts(kind) for kind in KINDS):
        return state
    raise InvalidInput(
        "then nothing would say where the surface is: hold a vertex of the cage, or add a pin first"
    )


TAB = DesignTab(
    "design",
    DesignState,
    actions(
        *(Show, AddPin, MovePin, Draw, EndCurve, DropCurve, MoveCurve, Remove, Rename),
        *(Hold, Change, SetLevels, Load),
    ),
)
