"""What all tabs share: actions make the next state of one; its view says what is seen.

A tab's state is the recipe of its method, and the meshes it is for. An action is data that came
from the page, checked when it is made; the same action that is committed at the end of a drag is
tried many times a second while it lasts.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import PurePath
from typing import Annotated, Any, ClassVar, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, ValidationError

from henkei.errors import InvalidInput, some
from henkei.mesh import Floats, Surface
from henkei.recipes.recipe import Name, Part, Recipe, meant, reason
from henkei.recipes.text import pretty
from henkei.studio.services import Services

Kind = TypeVar("Kind", bound=Recipe)
BlobId = Annotated[str, Strict(), Field(pattern="^[0-9a-f]{32}$")]
MeshId = Annotated[str, Strict(), Field(pattern="^[a-z0-9]{1,16}$")]
Flag = Annotated[bool, Strict()]


class TabState(Part):
    """What a tab holds; it is saved and restored, done and undone as a whole.

    slots : its fields that name an open mesh.
    """

    slots: ClassVar[tuple[str, ...]] = ()

    @property
    def made(self) -> str | None:
        """The blob of the result, where the tab keeps one that belongs to its recipe."""
        return None

    @property
    def meshes(self) -> dict[str, str | None]:
        """The mesh in each slot."""
        return {slot: getattr(self, slot) for slot in self.slots}

    def with_mesh(self, slot: str, mesh: str | None) -> Self:
        """Another mesh in a slot; what was said of the one before is dropped."""
        return type(self)(**{**self.meshes, slot: mesh})


class Result(Part):
    """What was made by a recipe, as a tab keeps it.

    of : digest of all that it was made by.
    result : its blob.
    """

    of: str
    result: BlobId


class ResultState(TabState):
    """The state of a tab that keeps what was made, until that is made anew."""

    recipe: Recipe
    result: Result | None = None

    @property
    def made(self) -> str | None:
        result = self.result
        return result.result if result is not None and result.of == self.digest else None

    @property
    def digest(self) -> str:
        """Of all that the result depends on."""
        return digest(self.recipe)


def digest(recipe: Recipe, more: str = "") -> str:
    """Of all in a recipe that a result depends on, and of more; how it is morphed is not in it."""
    said = recipe.model_dump(exclude_defaults=True, exclude={"about", "schema_file", "morph"})
    return sha256(f"{pretty(said)}{more}".encode()).hexdigest()[:32]


def changed(recipe: Kind, changes: dict[str, Any]) -> Kind:
    """A recipe with other values of some fields, checked as a whole; None is a default."""
    data = recipe.model_dump(exclude_defaults=True) | changes
    return type(recipe).of({name: value for name, value in data.items() if value is not None})


State = TypeVar("State", bound=TabState)


class Action(Part, Generic[State]):
    """Something a person does in a tab.

    label : for undo, as in "pin vertex".
    """

    label: ClassVar[str] = "change"

    @abstractmethod
    def apply(self, state: State, services: Services) -> State:
        """The next state.

        Raises
        ------
        HenkeiError : it cannot be done; the message says why and what to do.
        """


@dataclass(frozen=True)
class Work:
    """Long work for a process of its own.

    function : ``module:name`` in :mod:`henkei.studio.tasks`.
    request : plain data for it.
    title : for the progress bar.
    """

    function: str
    request: dict[str, Any]
    title: str


class Use(Action[State]):
    """Put an open mesh into a slot."""

    label: ClassVar[str] = "choose mesh"
    slot: Name
    mesh: MeshId | None

    def apply(self, state: State, services: Services) -> State:
        if self.slot not in state.slots:
            raise InvalidInput(f"there is no slot {self.slot!r}; known are {some(state.slots)}")
        if self.mesh is not None:
            services.entry(self.mesh)
        return state.with_mesh(self.slot, self.mesh)


class LongAction(Action[State]):
    """An action whose result comes later."""

    @abstractmethod
    def work(self, state: State, services: Services) -> Work:
        """What is to be done.

        Raises
        ------
        HenkeiError : it is clear beforehand that it can't be.
        """

    @abstractmethod
    def finished(self, state: State, result: Mapping[str, Any]) -> State:
        """The state with the result of the work; ``state`` may have changed since it began."""

    def apply(self, state: State, services: Services) -> State:
        return state


@dataclass(frozen=True)
class Product:
    """A surface that was made, to be opened as a mesh; fields as those of a mesh that is open."""

    surface: str
    name: str
    vertices: int
    faces: int
    about: str = ""

    @classmethod
    def of(cls, surface: Surface, name: str, services: Services, about: str = "") -> Product:
        """A surface that is now put among the blobs."""
        blob = services.blobs.put_surface(surface)
        return cls(blob, name, len(surface.vertices), surface.face_count, about)


@dataclass(frozen=True, eq=False)
class Basis:
    """How a surface answers a drag, for the page to blend by itself.

    positions are ``start + response * translation``; ``response`` is (n,), one factor for each
    vertex, or (n, 3), one for each axis, or (3, n, 3), what a unit along each axis adds.
    """

    surface: str
    start: Floats
    response: Floats


@dataclass(frozen=True)
class Tab(Generic[State]):
    """A tab as the session knows it; the default is one that shows nothing that moves."""

    name: str
    state: type[State]
    actions: Mapping[str, type[Action[State]]] = field(default_factory=dict)

    def action(self, name: Any, arguments: Mapping[str, Any]) -> Action[State]:
        """The action of a name, checked.

        Raises
        ------
        InvalidInput : there is none, or an argument is missing, unknown or not usable.
        """
        if not isinstance(name, str) or name not in self.actions:
            hint = meant(name, list(self.actions))
            raise InvalidInput(f"tab {self.name!r} has no action {str(name)[:40]!r}{hint}")
        try:
            return self.actions[name].model_validate(arguments)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            place = ".".join(str(step) for step in first["loc"][:6])
            raise InvalidInput(f"{name}: {place}: {reason(first)}"[:600]) from None

    def view(self, state: State, services: Services) -> dict[str, Any]:
        """What the page cannot know by itself: surfaces, figures, lists, warnings."""
        return {"surfaces": {}}

    def product(self, state: State, what: str, services: Services) -> Product:
        """A surface that was made here, by what it is called in the view.

        Raises
        ------
        InvalidInput : there is none.
        """
        raise InvalidInput(f"no {what[:40]!r} was made here that could be opened as a mesh")

    def frames(self, state: State, services: Services) -> dict[str, Floats]:
        """Positions (n, 3) of the surfaces that move, by the key they have in the view."""
        return {}

    def basis(self, state: State, what: Mapping[str, Any], services: Services) -> Basis | None:
        """How the surface answers the drag that begins, if it is linear in it."""
        return None

    def settle(self, services: Services) -> None:
        """The drag is over, or what it began from is old."""


def drawn(state: TabState, services: Services) -> dict[str, Any]:
    """The surfaces of a view: the open mesh in each slot that has one."""
    chosen = {slot: state.meshes[slot] for slot in state.slots}
    return {
        slot: {"data": services.drawn(services.entry(mesh).surface)}
        for slot, mesh in chosen.items()
        if mesh is not None
    }


def repaired(
    mesh: str | None, repair: Callable[[Surface], Surface], called: str, services: Services
) -> Product:
    """An open mesh after a repair; ``called`` what its name tells of that."""
    entry = services.entry(mesh)
    made = repair(services.blobs.surface(entry.surface))
    return Product.of(made, f"{PurePath(entry.name).stem}, {called}", services)


def actions(*kinds: type[Action[Any]]) -> dict[str, type[Action[Any]]]:
    """Actions by name, class ``AddPair`` as ``add_pair``, and that of choosing a mesh."""
    every: tuple[type[Action[Any]], ...] = (Use, *kinds)
    return {_snake(kind.__name__): kind for kind in every}


def _snake(name: str) -> str:
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")


def indices(array: NDArray[Any]) -> tuple[int, ...]:
    """As a recipe holds them."""
    return tuple(np.asarray(array).tolist())
