"""Combining: two surfaces, what corresponds on them, and the one mesh that has both forms."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

from henkei.errors import InvalidInput
from henkei.recipes.combine import CombineRecipe
from henkei.recipes.recipe import Index, Number, Part
from henkei.studio.combine_view import described, shape_at
from henkei.studio.disks import REPAIRS, Disks, Kind, Side
from henkei.studio.figures import Figure
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
    repaired,
)

Option = Literal[
    "fill_holes", "drop_fill", "outer", "snap", "attributes", "flip_b", "align", "about"
]
ONE = {"pairs": "pair", "landmarks": "landmark"}


class Colour(Part):
    """What the result can be coloured by: a blob with ``rgb``, or with ``values`` and limits."""

    title: str
    per: Literal["vertex", "face"]
    data: BlobId
    colormap: str | None = None
    limits: tuple[Number, Number] | None = None
    unit: str = ""


class Combined(Result):
    """What was made; see :func:`henkei.studio.tasks.combine.run`.

    pairs, landmarks : the vertices that these became, in the recipe's order.
    """

    shapes: BlobId
    plane: BlobId
    turning: BlobId | None = None
    colours: tuple[Colour, ...] = ()
    figures: tuple[Figure, ...] = ()
    pairs: tuple[int, ...] = ()
    landmarks: tuple[int, ...] = ()


class CombineState(ResultState):
    """Two meshes, how they are combined, and what came of it."""

    slots: ClassVar[tuple[str, ...]] = ("a", "b")

    a: MeshId | None = None
    b: MeshId | None = None
    recipe: CombineRecipe = CombineRecipe()
    result: Combined | None = None

    def with_mesh(self, slot: str, mesh: str | None) -> Self:
        """Another mesh in a slot; of the recipe stays what is not about the one before."""
        recipe = self.recipe
        if getattr(self, slot) is not None:
            of_meshes = {"pairs": "auto", "landmarks": (), "outer": (None, None)}
            recipe = recipe.model_copy(update=of_meshes)
        return self.model_copy(update={slot: mesh, "recipe": recipe, "result": None})

    def saying(self, **changes: Any) -> CombineState:
        """With a recipe changed in some fields, checked as a whole."""
        data = self.recipe.model_dump(exclude_defaults=True) | changes
        return self.model_copy(update={"recipe": CombineRecipe.of(data)})


class Propose(Action[CombineState]):
    """Have the boundary pairs proposed by shape."""

    label: ClassVar[str] = "propose pairs"

    def apply(self, state: CombineState, services: Services) -> CombineState:
        return state.saying(pairs="auto")


class AddPair(Action[CombineState]):
    """Add a pair of corresponding vertices; pairs that were proposed are kept as they are."""

    label: ClassVar[str] = "add pair"
    kind: Kind
    a: Index
    b: Index

    def apply(self, state: CombineState, services: Services) -> CombineState:
        disks = ready(state, services)
        known = disks.vertices(self.kind, state.recipe)
        disks.a.require(self.kind, self.a, known[:, 0].tolist())
        disks.b.require(self.kind, self.b, known[:, 1].tolist())
        return state.saying(**{self.kind: [*known.tolist(), [self.a, self.b]]})


class MovePair(Action[CombineState]):
    """Move one end of a pair to another vertex."""

    label: ClassVar[str] = "move pair"
    kind: Kind
    index: Index
    side: Literal["a", "b"]
    vertex: Index

    def apply(self, state: CombineState, services: Services) -> CombineState:
        disks = ready(state, services)
        known = _known(disks, self.kind, self.index, state)
        column = 0 if self.side == "a" else 1
        if known[self.index][column] == self.vertex:
            return state
        taken = [row[column] if i != self.index else -1 for i, row in enumerate(known)]
        disks.sides[column].require(self.kind, self.vertex, taken)
        known[self.index][column] = self.vertex
        return state.saying(**{self.kind: known})


class RemovePair(Action[CombineState]):
    """Take a pair away."""

    label: ClassVar[str] = "remove pair"
    kind: Kind
    index: Index

    def apply(self, state: CombineState, services: Services) -> CombineState:
        known = _known(disks_of(state, services), self.kind, self.index, state)
        return state.saying(**{self.kind: known[: self.index] + known[self.index + 1 :]})


class Clear(Action[CombineState]):
    """Take all pairs away, or all landmarks."""

    label: ClassVar[str] = "clear pairs"
    kind: Kind

    def apply(self, state: CombineState, services: Services) -> CombineState:
        return state.saying(**{self.kind: []})


class Change(Action[CombineState]):
    """Change options; those that are not named stay."""

    label: ClassVar[str] = "change options"
    options: dict[Option, Any]

    def apply(self, state: CombineState, services: Services) -> CombineState:
        changes: dict[str, Any] = dict(self.options)  # type: ignore[arg-type]
        if self.options.get("fill_holes") is False:
            changes |= {"drop_fill": False, "outer": (None, None)}
        return state.saying(**changes)


class ChangeMorph(Action[CombineState]):
    """Change how the morph runs and is written; what is not named stays."""

    label: ClassVar[str] = "change morph"
    morph: dict[Literal["path", "time", "frames", "seconds", "sweep"], Any]

    def apply(self, state: CombineState, services: Services) -> CombineState:
        return state.saying(morph={**state.recipe.morph.model_dump(), **self.morph})


class Load(Action[CombineState]):
    """Take a whole recipe."""

    label: ClassVar[str] = "open recipe"
    recipe: dict[str, Any]

    def apply(self, state: CombineState, services: Services) -> CombineState:
        return state.model_copy(update={"recipe": CombineRecipe.of(self.recipe)})


class Combine(LongAction[CombineState]):
    """Combine both as the recipe says."""

    label: ClassVar[str] = "combine"

    def work(self, state: CombineState, services: Services) -> Work:
        trouble = disks_of(state, services).trouble(state.recipe)
        if trouble is not None:
            raise InvalidInput(trouble.message)
        request = {
            "meshes": [state.a, state.b],
            "of": state.digest,
            "a": services.entry(state.a).surface,
            "b": services.entry(state.b).surface,
            "recipe": state.recipe.model_dump(mode="json", exclude_defaults=True),
        }
        return Work("henkei.studio.tasks.combine:run", request, "Combine")

    def finished(self, state: CombineState, result: Mapping[str, Any]) -> CombineState:
        made = dict(result)
        if made.pop("meshes") != [state.a, state.b]:
            return state  # others were chosen meanwhile
        return state.model_copy(update={"result": Combined.model_validate(made)})


class Turn(LongAction[CombineState]):
    """Let the parts turn in the morph, and prepare that for the page."""

    label: ClassVar[str] = "change morph"

    def work(self, state: CombineState, services: Services) -> Work:
        if state.result is None:
            raise InvalidInput("there is nothing to turn yet; combine the meshes first")
        request = {"result": state.result.result}
        return Work("henkei.studio.tasks.combine:turn", request, "Prepare the morph")

    def finished(self, state: CombineState, result: Mapping[str, Any]) -> CombineState:
        if state.result is None or state.result.result != result["result"]:
            return state  # it was combined anew meanwhile
        turned = state.result.model_copy(update={"turning": result["turning"]})
        return state.saying(
            morph={**state.recipe.morph.model_dump(), "path": "rotation"}
        ).model_copy(update={"result": turned})


class CombineTab(Tab[CombineState]):
    """Combining, with the boundaries, pairs and troubles of the meshes as they are now."""

    def view(self, state: CombineState, services: Services) -> dict[str, Any]:
        disks = None if None in state.meshes.values() else disks_of(state, services)
        return described(state, disks, services)

    def product(self, state: CombineState, what: str, services: Services) -> Product:
        """The shape at a time, as in ``at 0.5``; or a mesh repaired, as in ``weld b``."""
        how, _, of = what.partition(" ")
        if how == "at":
            return shape_at(state, of, services)
        if how in REPAIRS and of in state.slots:
            return repaired(state.meshes[of], *REPAIRS[how], services)
        return super().product(state, what, services)


def disks_of(state: CombineState, services: Services) -> Disks:
    """Both meshes as they would be combined, kept while neither they nor what matters change.

    Raises
    ------
    InvalidInput : a mesh is not chosen or not open.
    """
    entries = services.entry(state.a), services.entry(state.b)
    recipe = state.recipe
    key = (
        *(entry.surface for entry in entries),
        *(entry.name for entry in entries),
        recipe.fill_holes,
        recipe.flip_b,
        recipe.outer,
    )

    def make() -> Disks:
        services.progress("looking at the meshes", 0.0)
        sides = [
            Side(name, entry.name, services.blobs.surface(entry.surface), recipe)  # type: ignore[arg-type]
            for name, entry in zip("ab", entries, strict=True)
        ]
        return Disks(*sides)

    return services.engine("combine", key, make)


def ready(state: CombineState, services: Services) -> Disks:
    """The same, if there is no trouble with the meshes themselves."""
    disks = disks_of(state, services)
    trouble = disks.a.trouble or disks.b.trouble
    if trouble is not None:
        raise InvalidInput(trouble.message)
    return disks


def _known(disks: Disks, kind: Kind, index: int, state: CombineState) -> list[list[int]]:
    """Pairs as vertices, with one of this index among them."""
    known: list[list[int]] = disks.vertices(kind, state.recipe).tolist()
    if index >= len(known):
        raise InvalidInput(f"there is no {ONE[kind]} {index + 1}; it may have been removed")
    return known


TAB = CombineTab(
    "combine",
    CombineState,
    actions(
        *(Propose, AddPair, MovePair, RemovePair, Clear, Change, ChangeMorph, Load),
        *(Combine, Turn),
    ),
)
