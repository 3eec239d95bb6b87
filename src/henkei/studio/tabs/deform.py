"""Deforming live: regions that stay, move and keep their shape; a recipe of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Literal

import numpy as np

from henkei.errors import HenkeiError, InvalidInput
from henkei.geometry.creases import Indices
from henkei.geometry.selection import grown
from henkei.mesh import Floats, Surface
from henkei.recipes.deform import DeformRecipe, Feature, Fixed, Handle, Move, Pin
from henkei.recipes.recipe import Index, Name, Part, Point, Positive
from henkei.recipes.regions import Found, Region, Vertices
from henkei.studio.deforming import Engine, structure
from henkei.studio.selection import Mode, Outline, combined, outlined
from henkei.studio.services import Services
from henkei.studio.tabs.base import Action, Basis, MeshId, Tab, TabState, actions
from henkei.workflows.regions import Regions

Kind = Literal["fixed", "handles", "features", "pins"]
MANY_VERTICES = 300_000  # from which on figures are left out, to be quick


class DeformState(TabState):
    """The mesh, what is selected on it, and what is done to it."""

    slots: ClassVar[tuple[str, ...]] = ("mesh",)
    mesh: MeshId | None = None
    selection: tuple[Index, ...] = ()
    recipe: DeformRecipe = DeformRecipe()

    def selecting(self, vertices: tuple[int, ...]) -> DeformState:
        """With another selection."""
        return self.model_copy(update={"selection": vertices})

    def saying(self, **changes: Any) -> DeformState:
        """With a recipe changed in some fields, checked as a whole."""
        recipe = self.recipe.model_copy(update=changes)
        checked = DeformRecipe.of(recipe.model_dump(exclude_defaults=True))
        return self.model_copy(update={"recipe": checked})

    def parts(self, kind: Kind) -> dict[str, Any]:
        """The parts of the recipe of one kind, by name."""
        return dict(zip(self.recipe.names(kind), getattr(self.recipe, kind), strict=True))

    def part(self, kind: Kind, name: str) -> Any:
        """A part of the recipe.

        Raises
        ------
        InvalidInput : there is none of this name.
        """
        parts = self.parts(kind)
        if name not in parts:
            raise InvalidInput(f"there is no {name!r} among {kind}; it may have been removed")
        return parts[name]

    def with_part(self, kind: Kind, name: str, part: Part | None) -> DeformState:
        """With another part in place of one, or without it. Only its form is checked."""
        parts = {**self.parts(kind), name: part}
        kept = tuple(one for one in parts.values() if one is not None)
        recipe = self.recipe.model_copy(update={kind: kept})
        return self.model_copy(update={"recipe": recipe})


class Select(Action[DeformState]):
    """Select the vertices inside an outline on the picture of the surface as it is now."""

    label: ClassVar[str] = "select"
    outline: Outline
    mode: Mode = "replace"

    def apply(self, state: DeformState, services: Services) -> DeformState:
        chosen = outlined(_now(state, services), self.outline)
        return state.selecting(combined(state.selection, chosen, self.mode))


class SelectVertices(Action[DeformState]):
    """Select vertices by number; none, to select nothing."""

    label: ClassVar[str] = "select"
    vertices: tuple[Index, ...]
    mode: Mode = "replace"

    def apply(self, state: DeformState, services: Services) -> DeformState:
        count = services.entry(state.mesh).vertices
        if self.vertices and max(self.vertices) >= count:
            raise InvalidInput(f"vertex {max(self.vertices)} does not exist; there are {count}")
        chosen = np.array(self.vertices, np.int64)
        return state.selecting(combined(state.selection, chosen, self.mode))


class SelectRegion(Action[DeformState]):
    """Select a region as recipes say it, such as the name of what was found."""

    label: ClassVar[str] = "select"
    region: Region
    mode: Mode = "replace"

    def apply(self, state: DeformState, services: Services) -> DeformState:
        chosen = _regions(state, services).vertices(self.region)
        return state.selecting(combined(state.selection, chosen, self.mode))


class Grow(Action[DeformState]):
    """Add rings of neighbours to the selection."""

    label: ClassVar[str] = "grow selection"
    rings: Index = 1

    def apply(self, state: DeformState, services: Services) -> DeformState:
        region = np.array(state.selection, np.int64)
        if not len(region):
            raise InvalidInput("nothing is selected yet; draw around some vertices first")
        chosen = grown(services.surface(state.mesh), region, self.rings)
        return state.selecting(tuple(chosen.tolist()))


class Add(Action[DeformState]):
    """Make a part of the selection, or of what was found under a name.

    Vertices that another part has already are left out of a selection, which is told.
    """

    label: ClassVar[str] = "add region"
    kind: Literal["fixed", "handles", "features"]
    found: Name | None = None

    def apply(self, state: DeformState, services: Services) -> DeformState:
        region, keep = self._region(state, services), None
        name = None if isinstance(region, Found) else _new_name(state, self.kind)
        part: Part
        if self.kind == "features":
            if isinstance(region, Found):
                keep = _suggested(state, region.feature, services)
            part = Feature(name=name or self.found, region=region, keep=keep)
        else:
            part = (Fixed if self.kind == "fixed" else Handle)(name=name, region=region)
        parts = (*getattr(state.recipe, self.kind), part)
        return state.saying(**{self.kind: parts}).selecting(())

    def _region(self, state: DeformState, services: Services) -> Region:
        """What was found, or the selection; without what other parts have already."""
        regions = _regions(state, services)
        if self.found is None and not state.selection:
            raise InvalidInput("nothing is selected; select some vertices first")
        whole: Region = (
            Vertices(vertices=state.selection) if self.found is None else Found(feature=self.found)
        )
        wanted, taken = regions.vertices(whole), self._taken(state, regions)
        free = np.setdiff1d(wanted, taken)
        if not len(free):
            raise InvalidInput("all of these vertices belong to other parts already")
        if len(free) == len(wanted):
            return whole
        services.tell(f"{len(wanted) - len(free):,} vertices that other parts have were left out")
        return Vertices(vertices=tuple(free.tolist()))

    def _taken(self, state: DeformState, regions: Regions) -> Indices:
        """The vertices that other parts have; fixed ones may share theirs."""
        kinds: tuple[Kind, ...] = ("fixed", "handles", "features")
        taken = [
            regions.vertices(part.region)
            for kind in kinds
            if not kind == self.kind == "fixed"
            for part in state.parts(kind).values()
        ]
        return np.concatenate([np.empty(0, np.int64), *taken])


class Remove(Action[DeformState]):
    """Take a part away."""

    label: ClassVar[str] = "remove region"
    kind: Kind
    name: Name

    def apply(self, state: DeformState, services: Services) -> DeformState:
        state.part(self.kind, self.name)
        offsets = tuple(one for one in state.recipe.offsets if self.name not in one.between)
        return state.with_part(self.kind, self.name, None).saying(offsets=offsets)


class Rename(Action[DeformState]):
    """Give a part another name."""

    label: ClassVar[str] = "rename region"
    kind: Kind
    name: Name
    to: Name

    def apply(self, state: DeformState, services: Services) -> DeformState:
        part = state.part(self.kind, self.name).model_copy(update={"name": self.to})
        return state.with_part(self.kind, self.name, part).saying()


class MoveHandle(Action[DeformState]):
    """Put a handle into a pose, counted from rest."""

    label: ClassVar[str] = "move handle"
    name: Name
    move: Move

    def apply(self, state: DeformState, services: Services) -> DeformState:
        part = state.part("handles", self.name).model_copy(update={"move": self.move})
        return state.with_part("handles", self.name, part)


class SetFeature(Action[DeformState]):
    """Scale a feature, give its circle another radius, or say what survives."""

    label: ClassVar[str] = "change feature"
    name: Name
    scale: Positive = 1.0
    radius: Positive | None = None
    keep: Literal["rigid", "circle", "plane", "line"] | None = None

    def apply(self, state: DeformState, services: Services) -> DeformState:
        changes = {"scale": self.scale, "radius": self.radius, "keep": self.keep}
        part = state.part("features", self.name).model_copy(update=changes)
        return state.with_part("features", self.name, Feature(**dict(part)))


class AddPin(Action[DeformState]):
    """Pin a vertex where it is."""

    label: ClassVar[str] = "pin vertex"
    vertex: Index

    def apply(self, state: DeformState, services: Services) -> DeformState:
        at = _positions(state, services)[self.vertex].tolist()
        pin = Pin(name=_new_name(state, "pins"), point=self.vertex, to=tuple(at))
        return state.saying(pins=(*state.recipe.pins, pin))


class MovePin(Action[DeformState]):
    """Put a pin to another place."""

    label: ClassVar[str] = "move pin"
    name: Name
    to: Point

    def apply(self, state: DeformState, services: Services) -> DeformState:
        part = state.part("pins", self.name).model_copy(update={"to": self.to})
        return state.with_part("pins", self.name, part)


class Change(Action[DeformState]):
    """Change fields of the recipe that are no parts: method, symmetry, offsets, finding."""

    label: ClassVar[str] = "change settings"
    recipe: dict[Literal["method", "symmetry", "offsets", "finding", "about", "settings"], Any]

    def apply(self, state: DeformState, services: Services) -> DeformState:
        data = state.recipe.model_dump(exclude_defaults=True)
        data |= {**self.recipe}
        return state.model_copy(update={"recipe": DeformRecipe.of(data)})


class Load(Action[DeformState]):
    """Take a whole recipe."""

    label: ClassVar[str] = "open recipe"
    recipe: dict[str, Any]

    def apply(self, state: DeformState, services: Services) -> DeformState:
        services.entry(state.mesh)
        return state.model_copy(update={"recipe": DeformRecipe.of(self.recipe)})


class DeformTab(Tab[DeformState]):
    """Deforming: the mesh moves while a handle is dragged."""

    def view(self, state: DeformState, services: Services) -> dict[str, Any]:
        if state.mesh is None:
            return {"surfaces": {}}
        surface = services.entry(state.mesh).surface
        regions = _regions(state, services)
        view: dict[str, Any] = {
            "surfaces": {"mesh": {"data": services.drawn(surface), "live": True}},
            "found": [_found(feature) for feature in regions.features.values()],
            "parts": [],
            "figures": None,
            "warnings": [],
        }
        try:
            view["parts"] = _parts(state, regions)
            engine = _engine(state, services)
            if engine is None:
                view["missing"] = _missing(state.recipe)
            elif len(regions.surface.vertices) <= MANY_VERTICES:
                deformed = engine.deformed(state.recipe)
                view["figures"], view["warnings"] = deformed.figures, list(deformed.warnings)
        except HenkeiError as error:
            view["problem"] = str(error)
        return view

    def frames(self, state: DeformState, services: Services) -> dict[str, Floats]:
        return {} if state.mesh is None else {"mesh": _positions(state, services)}

    def basis(
        self, state: DeformState, what: Mapping[str, Any], services: Services
    ) -> Basis | None:
        engine, name = _engine(state, services), str(what.get("name"))
        if engine is None or name not in state.parts("handles"):
            return None
        drag = engine.drag(state.recipe, name)
        return Basis("mesh", drag.positions(), drag.response)

    def settle(self, services: Services) -> None:
        engine = services.present("deform")
        if isinstance(engine, Engine):
            engine.settle()


def _regions(state: DeformState, services: Services) -> Regions:
    """The regions of the mesh, with its form features found once."""
    surface = services.entry(state.mesh).surface
    finding = state.recipe.finding.model_dump()
    key = ("regions", surface, *finding.values())
    return services.remembered(
        key, lambda: Regions(services.blobs.surface(surface), finding=finding)
    )


def _engine(state: DeformState, services: Services) -> Engine | None:
    """The deformer, prepared; None while nothing is held or nothing can move."""
    if _missing(state.recipe):
        return None
    regions = _regions(state, services)
    key = (services.entry(state.mesh).surface, structure(state.recipe))
    return services.engine("deform", key, lambda: Engine(state.recipe, regions, services.progress))


def _missing(recipe: DeformRecipe) -> str | None:
    """What is to be done before anything moves."""
    if not any(one.weight is None for one in recipe.fixed):
        return "Select a region that shall stay, and fix it."
    if not (recipe.handles or recipe.features or recipe.pins):
        return "Select a region to be moved, and make it a handle."
    return None


def _positions(state: DeformState, services: Services) -> Floats:
    engine = _engine(state, services)
    if engine is None:
        return services.surface(state.mesh).vertices
    return engine.positions(state.recipe)


def _now(state: DeformState, services: Services) -> Surface:
    """The surface as it is deformed."""
    return replace(services.surface(state.mesh), vertices=_positions(state, services))


def _parts(state: DeformState, regions: Regions) -> list[dict[str, Any]]:
    """Each part with its vertices, and what its controls start from."""
    kinds: Sequence[Kind] = ("fixed", "handles", "features")
    listed = [
        _part(kind, name, part, regions)
        for kind in kinds
        for name, part in state.parts(kind).items()
    ]
    return listed + [
        {"kind": "pins", "name": name, "vertices": [pin.point], "to": pin.to}
        for name, pin in state.parts("pins").items()
    ]


def _part(kind: Kind, name: str, part: Any, regions: Regions) -> dict[str, Any]:
    vertices: Indices = regions.vertices(part.region, name)
    centre = regions.surface.vertices[vertices].mean(axis=0)
    told = {"kind": kind, "name": name, "vertices": vertices, "centre": centre.tolist()}
    if isinstance(part, Handle):
        told["move"] = part.move.model_dump()
    if isinstance(part, Feature):
        found = regions.features.get(name)
        rest = getattr(getattr(found, "circle", None), "radius", None)
        told |= {"keep": part.kept, "scale": part.scale, "radius": part.radius}
        told["rest_radius"] = rest
    return told


def _found(feature: Any) -> dict[str, Any]:
    return {
        "name": feature.name,
        "kind": type(feature).__name__.lower(),
        "figures": feature.figures,
        "vertices": feature.vertices,
    }


def _suggested(state: DeformState, name: str, services: Services) -> Any:
    kept = _regions(state, services).found(name)[0].suggested_keep
    return None if kept == "rigid" else kept


def _new_name(state: DeformState, kind: Kind) -> str:
    """The first of ``handle 1`` and so on that no part has."""
    kinds: Sequence[Kind] = ("fixed", "handles", "features", "pins")
    taken = {name for each in kinds for name in state.recipe.names(each)}
    one = kind.removesuffix("s")
    return next(name for i in range(1, len(taken) + 2) if (name := f"{one} {i}") not in taken)


TAB = DeformTab(
    "deform",
    DeformState,
    actions(
        *(Select, SelectVertices, SelectRegion, Grow, Add, Remove, Rename),
        *(MoveHandle, SetFeature, AddPin, MovePin, Change, Load),
    ),
)
