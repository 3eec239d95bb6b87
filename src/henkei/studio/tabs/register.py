"""Registering: a source takes on the form of a target, vertex for vertex."""

from __future__ import annotations

from typing import Any, ClassVar, Self

from henkei.recipes.register import RegisterRecipe
from henkei.studio.services import Services
from henkei.studio.tabs.base import Action, MeshId, Tab, TabState, actions


class RegisterState(TabState):
    """Two meshes, and how one is registered onto the other."""

    slots: ClassVar[tuple[str, ...]] = ("source", "target")

    source: MeshId | None = None
    target: MeshId | None = None
    recipe: RegisterRecipe = RegisterRecipe()

    def with_mesh(self, slot: str, mesh: str | None) -> Self:
        """Another mesh in a slot; options stay."""
        recipe = self.recipe.model_copy(update={"landmarks": (), "regions": None})
        return self.model_copy(update={slot: mesh, "recipe": recipe})


class Load(Action[RegisterState]):
    """Take a whole recipe."""

    label: ClassVar[str] = "open recipe"
    recipe: dict[str, Any]

    def apply(self, state: RegisterState, services: Services) -> RegisterState:
        return state.model_copy(update={"recipe": RegisterRecipe.of(self.recipe)})


class RegisterTab(Tab[RegisterState]):
    """Registering."""

    def view(self, state: RegisterState, services: Services) -> dict[str, Any]:
        surfaces = {
            slot: {"data": services.drawn(services.entry(mesh).surface)}
            for slot, mesh in state.meshes.items()
            if mesh is not None
        }
        return {"surfaces": surfaces}


TAB = RegisterTab("register", RegisterState, actions(Load))
