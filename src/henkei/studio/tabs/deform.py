"""Deforming live: regions that stay, move and keep their shape; a recipe of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from henkei.deform.constraints import Keep as Kept
from henkei.errors import HenkeiError, InvalidInput
from henkei.geometry.selection import grown
from henkei.mesh import Floats
from henkei.recipes.deform import DeformRecipe, Feature, Fixed, Handle, Move, Pin, Symmetry
from henkei.recipes.recipe import Index, Name, Number, Part, Point, Positive
from henkei.recipes.regions import Found, Region
from henkei.studio.deform_parts import expanded, free_of, meant, mirrored
from henkei.studio.deform_state import DeformState as DeformState
from henkei.studio.deform_state import (
    Kind,
    RegionKind,
    checked,
    engine_of,
    positions_known,
    positions_of,
    regions_of,
)
from henkei.studio.deform_view import described
from henkei.studio.deforming import Engine
from henkei.studio.named_files import require_no_files
from henkei.studio.selection import Mode, Outline, combined, inverted, outlined, shrunk
from henkei.studio.services import Services
from henkei.studio.tabs.base import Action, Basis, Flag, Tab, actions

SURFACE = "mesh"


class Select(Action[DeformState]):
    """Select the vertices inside an outline on the picture of the surface as it is now."""

    label: ClassVar[str] = "select"
    outline: Outline
    mode: Mode = "replace"

    def apply(self, state: DeformState, services: Services) -> DeformState:
        surface = services.surface(state.mesh)
        now = replace(surface, vertices=positions_of(state, services))
        chosen, hidden = outlined(now, self.outline)
        if hidden:
            services.tell(
                f"all {hidden:,} vertices in there are hidden behind the surface; look from the "
                "other side, or select hidden ones too"
            )
        return state.selecting(combined(state.selection, chosen, self.mode))


class SelectVertices(Action[DeformState]):
    """Select vertices by number; none, to select nothing."""

    label: ClassVar[str] = "select"
    vertices: tuple[Index, ...]
    mode: Mode = "replace"

    def apply(self, state: DeformState, services: Services) -> DeformState:
        for vertex in (max(self.vertices),) if self.vertices else ():
            _require_vertex(vertex, state, services)
        chosen = np.array(self.vertices, np.int64)
        return state.selecting(combined(state.selection, chosen, self.mode))


class SelectRegion(Action[DeformState]):
    """Select a region as recipes say it, such as the name of what was found."""

    label: ClassVar[str] = "select"
    region: Region
    mode: Mode = "replace"

    def apply(self, state: DeformState, services: Services) -> DeformState:
        require_no_files(DeformRecipe(fixed=(Fixed(region=self.region),)), "the region")
        chosen = regions_of(state, services).vertices(self.region)
        return state.selecting(combined(state.selection, chosen, self.mode))


class Grow(Action[DeformState]):
    """Add rings of neighbours to the selection, or take its outer rings away."""

    label: ClassVar[str] = "grow selection"
    rings: int = Field(default=1, ge=-1000, le=1000)

    def apply(self, state: DeformState, services: Services) -> DeformState:
        region, surface = np.array(state.selection, np.int64), services.surface(state.mesh)
        if not len(region):
            raise InvalidInput("nothing is selected yet; draw around some vertices first")
        if self.rings >= 0:
            chosen = grown(surface, region, self.rings)
        else:
            chosen = shrunk(surface, region, -self.rings)
        return state.selecting(tuple(chosen.tolist()))


class Invert(Action[DeformState]):
    """Select what is not selected."""

    label: ClassVar[str] = "invert selection"

    def apply(self, state: DeformState, services: Services) -> DeformState:
        region = np.array(state.selection, np.int64)
        return state.selecting(tuple(inverted(services.surface(state.mesh), region).tolist()))


class Find(Action[DeformState]):
    """Look for form features on a mesh where that takes long."""

    label: ClassVar[str] = "find features"

    def apply(self, state: DeformState, services: Services) -> DeformState:
        services.entry(state.mesh)
        return state.model_copy(update={"sought": True})


class Add(Action[DeformState]):
    """Make a part of the selection; vertices that other parts have are left out, and told."""

    label: ClassVar[str] = "add region"
    kind: RegionKind

    def apply(self, state: DeformState, services: Services) -> DeformState:
        if not state.selection:
            raise InvalidInput("nothing is selected; select some vertices first")
        whole = meant(state, regions_of(state, services))
        region, left_out = free_of(state, services, whole, self.kind)
        if region is None:
            raise InvalidInput("all of these vertices belong to other parts already")
        if left_out:
            services.tell(f"{left_out:,} vertices that other parts have were left out")
        part: Part
        if self.kind == "features":
            part = _feature(state, services, whole, region)
        else:
            name = state.new_name(self.kind)
            part = (Fixed if self.kind == "fixed" else Handle)(name=name, region=region)
        parts = (*getattr(state.recipe, self.kind), part)
        return checked(state.saying(**{self.kind: parts}).selecting(()), services)


class Keep(Action[DeformState]):
    """Tick or untick what was found: each becomes a feature, or is one no more."""

    label: ClassVar[str] = "keep features"
    names: tuple[Name, ...]
    kept: Flag = True

    def apply(self, state: DeformState, services: Services) -> DeformState:
        if not self.kept:
            return self._dropped(state, services)
        left_out: dict[str, int] = {}
        for name in self.names:
            if state.keeper(name) is not None:
                continue
            whole = Found(feature=name)
            region, left_out[name] = free_of(state, services, whole, "features")
            if region is not None:
                part = _feature(state, services, whole, region)
                state = state.saying(features=(*state.recipe.features, part))
        told = ", ".join(f"{count:,} of {name}" for name, count in left_out.items() if count)
        if self.names and not any(state.keeper(name) for name in self.names):
            raise InvalidInput(f"these vertices belong to other parts already: {told}")
        if told:
            services.tell(f"vertices that other parts have were left out: {told}")
        return checked(state, services)

    def _dropped(self, state: DeformState, services: Services) -> DeformState:
        for name in self.names:
            keeper = state.keeper(name)
            if keeper is not None:
                instead = expanded(
                    state.part("features", keeper), name, regions_of(state, services)
                )
                kept = {**state.parts("features"), keeper: None}
                features = (*(one for one in kept.values() if one is not None), *instead)
                state = _without_offsets(
                    state.model_copy(
                        update={"recipe": state.recipe.model_copy(update={"features": features})}
                    )
                )
        return state


class Remove(Action[DeformState]):
    """Take a part away, and offsets that need it."""

    label: ClassVar[str] = "remove region"
    kind: Kind
    name: Name

    def apply(self, state: DeformState, services: Services) -> DeformState:
        state = state.named()
        state.part(self.kind, self.name)
        return _without_offsets(state.with_part(self.kind, self.name, None))


class Rename(Action[DeformState]):
    """Give a part another name."""

    label: ClassVar[str] = "rename region"
    kind: Kind
    name: Name
    to: Name

    def apply(self, state: DeformState, services: Services) -> DeformState:
        part = state.part(self.kind, self.name).model_copy(update={"name": self.to})
        offsets = tuple(
            one.model_copy(
                update={"between": tuple(self.to if n == self.name else n for n in one.between)}
            )
            for one in state.recipe.offsets
        )
        state = state.with_part(self.kind, self.name, part)
        return checked(state.saying(offsets=offsets), services)


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
    keep: Kept = "rigid"

    def apply(self, state: DeformState, services: Services) -> DeformState:
        before: Feature = state.part("features", self.name)
        radius = self.radius if self.keep == "circle" else None
        keep = None if self.keep == "rigid" else self.keep
        part = before.model_copy(update={"scale": self.scale, "radius": radius, "keep": keep})
        state = state.with_part("features", self.name, part)
        return state if part.kept == before.kept else checked(state, services)


class AddPin(Action[DeformState]):
    """Pin a vertex where it is."""

    label: ClassVar[str] = "pin vertex"
    vertex: Index

    def apply(self, state: DeformState, services: Services) -> DeformState:
        _require_vertex(self.vertex, state, services)
        x, y, z = positions_known(state, services)[self.vertex].tolist()
        pin = Pin(name=state.new_name("pins"), point=self.vertex, to=(x, y, z))
        return checked(state.saying(pins=(*state.recipe.pins, pin)), services)


class MovePin(Action[DeformState]):
    """Put a pin to another place."""

    label: ClassVar[str] = "move pin"
    name: Name
    to: Point

    def apply(self, state: DeformState, services: Services) -> DeformState:
        changes = {"to": self.to, "move": (0.0, 0.0, 0.0)}
        part = state.part("pins", self.name).model_copy(update=changes)
        return state.with_part("pins", self.name, part)


class Mirror(Action[DeformState]):
    """Keep the result symmetric about a plane across an axis, or give that up.

    at : the coordinate of the plane; where it is not said, one about which the mesh is symmetric.
    """

    label: ClassVar[str] = "symmetry"
    axis: Literal["x", "y", "z"] | None
    at: Number | None = None

    def apply(self, state: DeformState, services: Services) -> DeformState:
        plane: Symmetry | None = None
        if self.axis is not None:
            plane = mirrored(services.surface(state.mesh), self.axis, self.at)
        return checked(state.saying(symmetry=plane), services)


class Change(Action[DeformState]):
    """Change fields of the recipe that are no parts: method, symmetry, offsets, finding."""

    label: ClassVar[str] = "change settings"
    recipe: dict[Literal["method", "symmetry", "offsets", "finding", "about", "settings"], Any]

    def apply(self, state: DeformState, services: Services) -> DeformState:
        data = state.recipe.model_dump(exclude_defaults=True) | {**self.recipe}
        changed = state.model_copy(update={"recipe": DeformRecipe.of(data)})
        return changed if set(self.recipe) <= {"method", "about"} else checked(changed, services)


class Load(Action[DeformState]):
    """Take a whole recipe."""

    label: ClassVar[str] = "open recipe"
    recipe: dict[str, Any]

    def apply(self, state: DeformState, services: Services) -> DeformState:
        services.entry(state.mesh)
        recipe = DeformRecipe.of(self.recipe)
        require_no_files(recipe, "the recipe")
        return checked(state.model_copy(update={"recipe": recipe}).named(), services)


class DeformTab(Tab[DeformState]):
    """Deforming: the mesh moves while a handle is dragged."""

    def view(self, state: DeformState, services: Services) -> dict[str, Any]:
        if state.mesh is None:
            return {"surfaces": {}}
        drawn = services.drawn(services.entry(state.mesh).surface)
        surfaces = {SURFACE: {"data": drawn, "live": True}}
        return {"surfaces": surfaces, **described(state, services)}

    def frames(self, state: DeformState, services: Services) -> dict[str, Floats]:
        return {} if state.mesh is None else {SURFACE: positions_of(state, services)}

    def basis(
        self, state: DeformState, what: Mapping[str, Any], services: Services
    ) -> Basis | None:
        name = str(what.get("name"))
        handles = {} if state.mesh is None or state.missing else state.parts("handles")
        if name not in handles or state.recipe.method != "linear":
            return None
        try:
            drag = engine_of(state, services).drag(state.recipe, name)
        except HenkeiError:
            return None  # the view tells why
        return Basis(SURFACE, drag.positions(), drag.response)

    def settle(self, services: Services) -> None:
        engine = services.present("deform")
        if isinstance(engine, Engine):
            engine.settle()


def _feature(state: DeformState, services: Services, whole: Region, region: Region) -> Feature:
    """A feature of a region, which is what was found or a part of it, kept as suggested."""
    if not isinstance(whole, Found):
        return Feature(name=state.new_name("features"), region=region)
    keep: Kept | None = regions_of(state, services).found(whole.feature)[0].suggested_keep
    if keep == "rigid" or (keep == "circle" and region is not whole):
        keep = None  # a part of a circle need not tell its radius
    return Feature(name=None if region is whole else whole.feature, region=region, keep=keep)


def _without_offsets(state: DeformState) -> DeformState:
    """Without offsets between features that are no more."""
    known = state.recipe.names("features")
    offsets = tuple(one for one in state.recipe.offsets if set(one.between) <= set(known))
    return state.saying(offsets=offsets)


def _require_vertex(vertex: int, state: DeformState, services: Services) -> None:
    count = services.entry(state.mesh).vertices
    if vertex >= count:
        raise InvalidInput(f"vertex {vertex} does not exist; there are {count}, counted from 0")


TAB = DeformTab(
    "deform",
    DeformState,
    actions(
        *(Select, SelectVertices, SelectRegion, Grow, Invert, Find, Add, Keep, Remove, Rename),
        *(MoveHandle, SetFeature, AddPin, MovePin, Mirror, Change, Load),
    ),
)
