"""What the deform tab holds, and what is kept ready to work with it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from fnmatch import fnmatchcase
from typing import Any, ClassVar, Literal, get_args
from weakref import ref

import numpy as np

from henkei.errors import HenkeiError, InvalidInput
from henkei.geometry.creases import Indices
from henkei.mesh import Floats
from henkei.progress import Progress
from henkei.recipes.deform import DeformRecipe, Feature, Move
from henkei.recipes.recipe import Index, Part
from henkei.recipes.regions import Found
from henkei.studio.aside import at_once
from henkei.studio.deforming import Engine, Preparing, structure
from henkei.studio.services import Services
from henkei.studio.tabs.base import Flag, MeshId, TabState
from henkei.workflows.regions import Regions

Kind = Literal["fixed", "handles", "features", "pins"]
RegionKind = Literal["fixed", "handles", "features"]
KINDS: tuple[Kind, ...] = get_args(Kind)
REGION_KINDS: tuple[RegionKind, ...] = get_args(RegionKind)


LONG = 50_000  # vertices from which on nobody waits for systems to be factored


class DeformState(TabState):
    """The mesh, what is selected on it, and what is done to it.

    sought : form features are listed, however long it takes to find them.
    """

    slots: ClassVar[tuple[str, ...]] = ("mesh",)
    mesh: MeshId | None = None
    selection: tuple[Index, ...] = ()
    sought: Flag = False
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

    def named(self) -> DeformState:
        """With the name that each part goes by written down, so that no other part takes it."""
        recipe = self.recipe
        for kind in KINDS:
            parts = tuple(
                part
                if part.name or (isinstance(part, Feature) and isinstance(part.region, Found))
                else part.model_copy(update={"name": name})
                for name, part in self.parts(kind).items()
            )
            recipe = recipe.model_copy(update={kind: parts})
        return self.model_copy(update={"recipe": recipe})

    def new_name(self, kind: Kind) -> str:
        """The first of ``handle 1`` and so on that no part has."""
        taken = {name for each in KINDS for name in self.recipe.names(each)}
        one = kind.removesuffix("s")
        numbers = range(1, len(taken) + 2)
        return next(name for number in numbers if (name := f"{one} {number}") not in taken)

    def keeper(self, found: str) -> str | None:
        """The name of the feature that keeps what was found under a name; None if none does."""
        for name, part in self.parts("features").items():
            whole = isinstance(part.region, Found) and fnmatchcase(found, part.region.feature)
            if whole or name == found:
                return name
        return None

    @property
    def missing(self) -> str | None:
        """What is to be done before anything can move; None if nothing is."""
        if not any(one.weight is None for one in self.recipe.fixed):
            return (
                "Select a region that is to stay, by rectangle (R), lasso (L) or brush (B), and "
                "press Fix."
            )
        if not (self.recipe.handles or self.recipe.features or self.recipe.pins):
            return "Select a region that is to be moved (R, L or B), and press Handle."
        return None

    @property
    def next(self) -> str | None:
        """What a person who begins is told to do; None once something was moved."""
        if self.missing:
            return self.missing
        recipe = self.recipe
        if recipe.pins or any(one.move != Move() for one in recipe.handles):
            return None
        if any(one.scale != 1 or one.radius is not None for one in recipe.features):
            return None
        if not recipe.handles:
            return "Choose a feature under Parts to change its size, or add a handle to move."
        return "Click on a handle, and drag its arrows and rings."


def regions_of(state: DeformState, services: Services) -> Regions:
    """The regions of the mesh, with its form features, which are found when first asked for."""
    surface = services.entry(state.mesh).surface
    finding = state.recipe.finding.model_dump()

    def make() -> Regions:
        return Regions(services.blobs.surface(surface), finding=finding)

    return services.remembered(("regions", surface, *finding.values()), make)


def engine_of(state: DeformState, services: Services) -> Engine:
    """The deformer of the recipe.

    Raises
    ------
    HenkeiError : the recipe does not fit the mesh.
    """
    latest = _latest(state, services)
    return services.engine(
        "deform", _key(state, services), lambda: _engine(state, services, latest)
    )


def checked(state: DeformState, services: Services) -> DeformState:
    """The same state; what was prepared for another recipe is given up only if this one fits.

    Raises
    ------
    HenkeiError : the recipe does not fit the mesh: parts overlap, say, or a pad is not planar.
    """
    engine = _engine(state, services, _latest(state, services))
    services.engine("deform", _key(state, services), lambda: engine)
    return state


def _key(state: DeformState, services: Services) -> tuple[Any, ...]:
    """What an engine is made for."""
    return services.entry(state.mesh).surface, structure(state.recipe)


def _latest(state: DeformState, services: Services) -> Floats | None:
    """Positions (n, 3) of this mesh that were shown last, if any were."""
    engine = services.present("deform")
    same = isinstance(engine, Engine) and engine.stage.deformer.mesh is services.surface(state.mesh)
    return engine.latest if same else None


def _engine(state: DeformState, services: Services, latest: Floats | None) -> Engine:
    def run(engine: Engine, work: Callable[[Progress], None]) -> Future[None]:
        kept = ref(engine)
        if services.aside is None or services.entry(state.mesh).vertices < LONG:
            return at_once(work, services.progress)
        return services.aside.start(
            "Prepare the deformation",
            work,
            wanted=lambda: services.has_engine("deform", kept()),
            then=lambda: services.renew("deform"),
        )

    return Engine(state.recipe, regions_of(state, services), run, latest)


def positions_of(state: DeformState, services: Services) -> Floats:
    """Where the vertices (n, 3) are drawn: deformed, or where that is not possible, as before."""
    rest = services.surface(state.mesh).vertices
    if state.missing:
        return rest
    try:
        return engine_of(state, services).positions(state.recipe)
    except HenkeiError:
        engine = services.present("deform")
        if isinstance(engine, Engine) and engine.latest is not None:
            return engine.latest
        return rest


def positions_known(state: DeformState, services: Services) -> Floats:
    """The same, but never those of another recipe because this one is not prepared yet.

    Raises
    ------
    Preparing : they are not known.
    """
    if not state.missing:
        try:
            return engine_of(state, services).positions(state.recipe)
        except Preparing:
            raise
        except HenkeiError:
            pass
    return positions_of(state, services)


def taken(state: DeformState, services: Services, kinds: tuple[RegionKind, ...]) -> Indices:
    """The vertices of all parts of some kinds."""
    regions = regions_of(state, services)
    found = [regions.vertices(one.region) for kind in kinds for one in state.parts(kind).values()]
    return np.unique(np.concatenate([np.empty(0, np.int64), *found]))
