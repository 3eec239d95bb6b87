"""Registering: a source takes on the form of a target, vertex for vertex."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePath
from typing import Any, ClassVar, Literal

from pydantic import Field

from henkei.errors import InvalidInput
from henkei.recipes.recipe import Index, Name, Part
from henkei.recipes.register import MEDIATORS, RegisterRecipe, is_mediator_file
from henkei.studio.register_state import Registered, RegisterState, both_of, file_of
from henkei.studio.register_view import begin, described, shape_at, wrong
from henkei.studio.registering import REMEDIES, SIDES, SideName
from henkei.studio.services import Services
from henkei.studio.tabs.base import (
    Action,
    LongAction,
    MeshId,
    Product,
    Tab,
    Work,
    actions,
    repaired,
)

Option = Literal["distortion", "seed", "rule", "regions", "settings", "about"]
MOST_TEXT = 300_000  # characters of a file of landmarks, so that two fit into a message


class AddLandmark(Action[RegisterState]):
    """Add a pair of corresponding vertices; among pairs of points, as where these vertices are."""

    label: ClassVar[str] = "add landmark"
    source: Index
    target: Index

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        both = both_of(state, services)
        marked = both.marked(state.recipe.landmarks)
        both.source.require(self.source, [one.source for one in marked])
        both.target.require(self.target, [one.target for one in marked if not one.points])
        pair = both.pair(self.source, self.target, state.recipe.landmarks)
        return state.saying(landmarks=[*state.recipe.landmarks, pair])


class MoveLandmark(Action[RegisterState]):
    """Move one end of a landmark to another vertex."""

    label: ClassVar[str] = "move landmark"
    index: Index
    side: SideName
    vertex: Index

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        pairs = _with(state, self.index)
        both, side = both_of(state, services), SIDES.index(self.side)
        others = [
            -1 if i == self.index or (one.points and side) else getattr(one, self.side)
            for i, one in enumerate(both.marked(pairs))
        ]
        both.sides[side].require(self.vertex, others)
        moved: list[Any] = list(pairs[self.index])
        of_points = not isinstance(moved[side], int)
        moved[side] = both.place(side, self.vertex) if of_points else self.vertex
        pairs[self.index] = tuple(moved)
        return state.saying(landmarks=pairs)


class RemoveLandmark(Action[RegisterState]):
    """Take a landmark away."""

    label: ClassVar[str] = "remove landmark"
    index: Index

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        pairs = _with(state, self.index)
        return state.saying(landmarks=pairs[: self.index] + pairs[self.index + 1 :])


class ClearLandmarks(Action[RegisterState]):
    """Take all landmarks away."""

    label: ClassVar[str] = "clear landmarks"

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        return state.saying(landmarks=[])


class SetMediator(Action[RegisterState]):
    """Choose the mediator: one by name, or an open mesh."""

    label: ClassVar[str] = "choose mediator"
    name: Name | None = None
    mesh: MeshId | None = None

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        if (self.name is None) == (self.mesh is None):
            raise InvalidInput("a mediator is one by name, or an open mesh")
        if self.mesh is not None:
            file = file_of(services.entry(self.mesh).name)
            return state.model_copy(update={"mediator": self.mesh}).saying(mediator=file)
        if self.name not in MEDIATORS:
            raise InvalidInput(f"mediators by name are {', '.join(MEDIATORS)}, not {self.name!r}")
        return state.saying(mediator=self.name)


class Swap(Action[RegisterState]):
    """Exchange source and target."""

    label: ClassVar[str] = "swap"

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        recipe = state.recipe
        turned = {
            "landmarks": tuple((b, a) for a, b in recipe.landmarks),
            "regions": recipe.regions and recipe.regions[::-1],
        }
        changes = {"source": state.target, "target": state.source, "result": None}
        return state.model_copy(update={**changes, "recipe": recipe.model_copy(update=turned)})


class Change(Action[RegisterState]):
    """Change options; those that are not named stay, and null is the default of one."""

    label: ClassVar[str] = "change options"
    options: dict[Option, Any]

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        return state.saying(**self.options)


class ChangeMorph(Action[RegisterState]):
    """Change how the morph runs and is written; what is not named stays."""

    label: ClassVar[str] = "change morph"
    morph: dict[Literal["path", "time", "frames", "seconds", "sweep"], Any]

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        return state.saying(morph={**state.recipe.morph.model_dump(), **self.morph})


class Load(Action[RegisterState]):
    """Take a whole recipe. A mediator that it names as a file is the open mesh of that name."""

    label: ClassVar[str] = "open recipe"
    recipe: dict[str, Any]

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        recipe = RegisterRecipe.of(self.recipe)
        if not is_mediator_file(recipe.mediator):
            return state.with_recipe(recipe)
        wanted = PurePath(recipe.mediator).name
        found = [one.id for one in services.meshes if file_of(one.name) == wanted]
        if not found:
            raise InvalidInput(
                f"the recipe's mediator is the file {wanted!r}; open that mesh first, then the "
                "recipe again"
            )
        return state.model_copy(update={"mediator": found[-1]}).with_recipe(recipe)


class File(Part):
    """A file of landmarks that a page has read."""

    name: str = Field(max_length=200)
    text: str = Field(max_length=MOST_TEXT)


class ReadLandmarks(LongAction[RegisterState]):
    """Take landmarks from files of this or other programs, in place of those there are: one with
    pairs, or one for each mesh."""

    label: ClassVar[str] = "open landmarks"
    files: tuple[File, ...] = Field(min_length=1, max_length=2)

    def work(self, state: RegisterState, services: Services) -> Work:
        asked = _asked(state, services) | {"files": [one.model_dump() for one in self.files]}
        return Work("henkei.studio.tasks.landmarks:run", asked, "Open landmarks")

    def finished(self, state: RegisterState, result: Mapping[str, Any]) -> RegisterState:
        if result["meshes"] != [state.source, state.target]:
            return state  # others were chosen meanwhile
        return state.saying(landmarks=result["landmarks"])


class Run(LongAction[RegisterState]):
    """Register the source onto the target as the recipe says."""

    label: ClassVar[str] = "register"

    def work(self, state: RegisterState, services: Services) -> Work:
        trouble = wrong(both_of(state, services), state, services)
        if trouble is not None:
            raise InvalidInput(trouble.message)
        own = None if state.mediator is None else services.entry(state.mediator).surface
        asked = _asked(state, services) | {"mediator": own, "of": state.digest}
        return Work("henkei.studio.tasks.register:run", asked, "Register")

    def finished(self, state: RegisterState, result: Mapping[str, Any]) -> RegisterState:
        made = dict(result)
        if made.pop("meshes") != [state.source, state.target]:
            return state
        return state.model_copy(update={"result": Registered.model_validate(made)})


class Turn(LongAction[RegisterState]):
    """Let the parts turn in the morph, and prepare that for the page."""

    label: ClassVar[str] = "change morph"

    def work(self, state: RegisterState, services: Services) -> Work:
        if state.result is None:
            raise InvalidInput("there is nothing to turn yet; register the meshes first")
        request = {"result": state.result.result, "shapes": state.result.shapes}
        return Work("henkei.studio.tasks.register:turn", request, "Prepare the morph")

    def finished(self, state: RegisterState, result: Mapping[str, Any]) -> RegisterState:
        if state.result is None or state.result.result != result["result"]:
            return state  # it was registered anew meanwhile
        turned = state.result.model_copy(update={"turning": result["turning"]})
        morph = state.recipe.morph.model_copy(update={"path": "rotation"})
        return state.saying(morph=morph.model_dump()).model_copy(update={"result": turned})


class RegisterTab(Tab[RegisterState]):
    """Registering, with the landmarks and troubles of the meshes as they are now."""

    def view(self, state: RegisterState, services: Services) -> dict[str, Any]:
        if state.source is None or state.target is None:
            return begin(state, services)
        return described(both_of(state, services), state, services)

    def product(self, state: RegisterState, what: str, services: Services) -> Product:
        kind, _, of = what.partition(" ")
        if kind == "at":
            return shape_at(state, of, services)
        if kind not in REMEDIES or state.meshes.get(of) is None:
            return super().product(state, what, services)
        services.progress("repairing", 0.0)
        return repaired(state.meshes[of], *REMEDIES[kind], services)


def _with(state: RegisterState, index: int) -> list[Any]:
    """The landmarks, with one of this index among them."""
    pairs = list(state.recipe.landmarks)
    if index >= len(pairs):
        raise InvalidInput(f"there is no landmark {index + 1}; it may have been removed")
    return pairs


def _asked(state: RegisterState, services: Services) -> dict[str, Any]:
    """What work is for."""
    return {
        "meshes": [state.source, state.target],
        "source": services.entry(state.source).surface,
        "target": services.entry(state.target).surface,
        "names": [services.entry(mesh).name for mesh in (state.source, state.target)],
        "recipe": state.recipe.model_dump(mode="json", exclude_defaults=True),
    }


TAB = RegisterTab(
    "register",
    RegisterState,
    actions(
        *(AddLandmark, MoveLandmark, RemoveLandmark, ClearLandmarks, SetMediator, Swap),
        *(Change, ChangeMorph, Load, ReadLandmarks, Run, Turn),
    ),
)
