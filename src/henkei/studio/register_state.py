"""What the register tab holds: two meshes, how one is registered onto the other, and the result."""

from __future__ import annotations

from pathlib import PurePath
from typing import Any, ClassVar, Literal, Self

from henkei.recipes.recipe import Number, Part
from henkei.recipes.register import RegisterRecipe, is_mediator_file
from henkei.register.mediators import SPHERE
from henkei.studio.figures import Figure
from henkei.studio.named_files import require_no_files
from henkei.studio.registering import SIDES, Both, Side
from henkei.studio.services import Services
from henkei.studio.tabs.base import BlobId, MeshId, Result, ResultState, changed, digest


class Colour(Part):
    """What model or target can be coloured by: a blob with ``values``, and their limits."""

    title: str
    on: Literal["model", "target"]
    per: Literal["vertex", "face"]
    data: BlobId
    colormap: str
    limits: tuple[Number, Number]
    unit: str = ""


class Registered(Result):
    """What was made; see :func:`henkei.studio.tasks.register.run`.

    landmarks : vertices of the model, in the recipe's order.
    missed : a vertex of the target that is farthest from the model.
    """

    shapes: BlobId
    turning: BlobId | None = None
    colours: tuple[Colour, ...] = ()
    figures: tuple[Figure, ...] = ()
    warnings: tuple[str, ...] = ()
    landmarks: tuple[int, ...] = ()
    missed: int | None = None


class RegisterState(ResultState):
    """Two meshes, how one is registered onto the other, and what came of it.

    mediator : the mesh that is the mediator, if it is none by name; the recipe has its file's name.
    """

    slots: ClassVar[tuple[str, ...]] = SIDES

    source: MeshId | None = None
    target: MeshId | None = None
    mediator: MeshId | None = None
    recipe: RegisterRecipe = RegisterRecipe()
    result: Registered | None = None

    @property
    def meshes(self) -> dict[str, str | None]:
        """The mesh in each slot; that of the mediator only if it has one."""
        own = {} if self.mediator is None else {"mediator": self.mediator}
        return {"source": self.source, "target": self.target, **own}

    @property
    def digest(self) -> str:
        """Of all in the recipe that the result depends on, and of the mediator."""
        return digest(self.recipe, str(self.mediator))

    def with_mesh(self, slot: str, mesh: str | None) -> Self:
        """Another mesh in a slot; of the recipe stays what is not about the one before."""
        dropped: dict[str, Any] = {}
        if slot == "mediator":
            dropped = {"mediator": SPHERE}
        elif getattr(self, slot) is not None:
            dropped = {"landmarks": (), "regions": None}
        recipe = self.recipe.model_copy(update=dropped)
        return self.model_copy(update={slot: mesh, "recipe": recipe, "result": None})

    def saying(self, **changes: Any) -> RegisterState:
        """With a recipe changed in some fields, checked as a whole; None is a default."""
        return self.with_recipe(changed(self.recipe, changes))

    def with_recipe(self, recipe: RegisterRecipe) -> RegisterState:
        """With another recipe, whose mediator stays a mesh only if it names one.

        Raises
        ------
        InvalidInput : it names files of labels.
        """
        require_no_files(recipe, "the recipe")
        own = self.mediator if is_mediator_file(recipe.mediator) else None
        return self.model_copy(update={"recipe": recipe, "mediator": own})


def both_of(state: RegisterState, services: Services) -> Both:
    """Both meshes as they would be registered, kept while they are the same.

    Raises
    ------
    InvalidInput : a mesh is not chosen or not open.
    """
    entries = services.entry(state.source), services.entry(state.target)
    key = tuple((entry.surface, entry.name) for entry in entries)

    def make() -> Both:
        services.progress("looking at the meshes", 0.0)
        return Both(
            *(
                Side(name, entry.name, services.blobs.surface(entry.surface))
                for name, entry in zip(SIDES, entries, strict=True)
            )
        )

    return services.engine("register", key, make)


def file_of(mesh: str) -> str:
    """What a recipe calls the file of a mesh of this name."""
    return mesh if PurePath(mesh).suffix else f"{mesh}.ply"
