"""Quads of a mesh: how many, along which edges, and what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

from henkei.quad.quality import QuadQuality
from henkei.recipes.quad import Plane, QuadRecipe
from henkei.recipes.recipe import Index, Part
from henkei.studio.named_files import require_no_files
from henkei.studio.quad_view import described
from henkei.studio.services import Services
from henkei.studio.tabs.base import (
    Action,
    BlobId,
    LongAction,
    MeshId,
    Product,
    Result,
    ResultState,
    Tab,
    Work,
    actions,
    changed,
)

Option = Literal[
    "quads", "edge_length", "layout", "patches", "sharp", "density", "symmetry", "seed", "about"
]
OTHER = {"quads": "edge_length", "edge_length": "quads"}


class Made(Result):
    """Quads that were made; see :func:`henkei.studio.tasks.quad.run`.

    wished : how many it asked for.
    irregular : how many irregular vertices there are of each kind.
    """

    surface: BlobId
    about: str
    quads: BlobId
    details: BlobId
    quality: QuadQuality
    irregular: tuple[Index, ...]
    wished: Index | None = None

    @property
    def vertices(self) -> int:
        """How many the quads have."""
        return self.quality.vertices

    @property
    def faces(self) -> int:
        """How many quads there are."""
        return self.quality.quads


class Cage(Part):
    """A cage that was made; see :func:`henkei.studio.tasks.quad.cage`."""

    surface: BlobId
    about: str
    cage: BlobId
    vertices: Index
    faces: Index


class QuadState(ResultState):
    """The mesh, what is wished, and the quads that were made."""

    slots: ClassVar[tuple[str, ...]] = ("mesh",)

    mesh: MeshId | None = None
    recipe: QuadRecipe = QuadRecipe()
    result: Made | None = None
    cage: Cage | None = None

    def with_mesh(self, slot: str, mesh: str | None) -> Self:
        """Another mesh; of the recipe stays what is not about the one before."""
        recipe = self.recipe if self.mesh is None else _for_any(self.recipe)
        return type(self)(mesh=mesh, recipe=recipe)

    def saying(self, **changes: Any) -> QuadState:
        """With a recipe changed in some fields, checked as a whole; None is a default."""
        return self.with_recipe(changed(self.recipe, changes))

    def with_recipe(self, recipe: QuadRecipe) -> QuadState:
        """With another recipe.

        Raises
        ------
        InvalidInput : it names a file.
        """
        require_no_files(recipe, "the recipe")
        return self.model_copy(update={"recipe": recipe})


class Change(Action[QuadState]):
    """Change options; those that are not named stay, and null is the default of one."""

    label: ClassVar[str] = "change settings"
    options: dict[Option, Any]

    def apply(self, state: QuadState, services: Services) -> QuadState:
        changes: dict[str, Any] = dict(self.options)  # type: ignore[arg-type]
        for size, other in OTHER.items():
            if changes.get(size) is not None:
                changes.setdefault(other, None)
        if changes.get("layout") == "field":
            changes.setdefault("patches", None)
        return state.saying(**changes)


class Load(Action[QuadState]):
    """Take a whole recipe."""

    label: ClassVar[str] = "open recipe"
    recipe: dict[str, Any]

    def apply(self, state: QuadState, services: Services) -> QuadState:
        return state.with_recipe(QuadRecipe.of(self.recipe))


class Run(LongAction[QuadState]):
    """Make the quads as the recipe says."""

    label: ClassVar[str] = "make quads"

    def work(self, state: QuadState, services: Services) -> Work:
        asked = _asked(state, services) | {"of": state.digest}
        return Work("henkei.studio.tasks.quad:run", asked, "Make quads")

    def finished(self, state: QuadState, result: Mapping[str, Any]) -> QuadState:
        return _with(state, "result", Made, result)


class MakeCage(LongAction[QuadState]):
    """Make a cage of few quads, with the recipe's edges, symmetry, layout and seed."""

    label: ClassVar[str] = "make cage"

    def work(self, state: QuadState, services: Services) -> Work:
        asked = _asked(state, services)
        return Work("henkei.studio.tasks.quad:cage", asked, "Make cage")

    def finished(self, state: QuadState, result: Mapping[str, Any]) -> QuadState:
        return _with(state, "cage", Cage, result)


def _asked(state: QuadState, services: Services) -> dict[str, Any]:
    return {
        "mesh": state.mesh,
        "surface": services.entry(state.mesh).surface,
        "recipe": state.recipe.model_dump(mode="json", exclude_defaults=True),
    }


def _with(state: QuadState, field: str, kind: type[Part], result: Mapping[str, Any]) -> QuadState:
    """With what was made, unless another mesh was chosen meanwhile."""
    made = dict(result)
    if made.pop("mesh") != state.mesh:
        return state
    return state.model_copy(update={field: kind.model_validate(made)})


class QuadTab(Tab[QuadState]):
    """Quads, with the edges that they will follow as they are now."""

    def view(self, state: QuadState, services: Services) -> dict[str, Any]:
        if state.mesh is None:
            return {"surfaces": {}, "next": "Open a mesh, or one of the examples."}
        return described(state, services)

    def product(self, state: QuadState, what: str, services: Services) -> Product:
        made = {"quads": state.result, "cage": state.cage}.get(what)
        if made is None:
            return super().product(state, what, services)
        name = f"{services.entry(state.mesh).name} {what}"
        return Product(made.surface, name, made.vertices, made.faces, made.about)


def _for_any(recipe: QuadRecipe) -> QuadRecipe:
    """What a recipe says of any mesh: without edges, attributes, planes and lengths of one."""
    changes: dict[str, Any] = {"edge_length": None}
    if isinstance(recipe.sharp, tuple):
        changes["sharp"] = None
    if recipe.density != "curvature":
        changes["density"] = None
    if isinstance(recipe.symmetry, Plane):
        changes["symmetry"] = None
    return recipe.model_copy(update=changes)


TAB = QuadTab("quad", QuadState, actions(Change, Load, Run, MakeCage))
