"""What a page is told of two meshes to be registered, and of what came of it."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from henkei.errors import InvalidInput
from henkei.geometry.alignment import surface_similarity
from henkei.geometry.correspondence import Correspondence
from henkei.geometry.interpolation import between
from henkei.mesh import Floats
from henkei.recipes.register import is_mediator_file
from henkei.register import Registration
from henkei.studio.morphs import MOST_TURNED, delay, time_of
from henkei.studio.registering import Both, Side, Trouble
from henkei.studio.services import Services
from henkei.studio.tabs.base import Product, drawn
from henkei.workflows.morph_by_recipe import way_of

if TYPE_CHECKING:
    from henkei.studio.register_state import Registered, RegisterState

FEW = 3  # landmarks, below which it is a guess


def begin(state: RegisterState, services: Services) -> dict[str, Any]:
    """What there is to say while a mesh is missing."""
    told = {
        (False, False): "Open two meshes: the source, which keeps its vertices and faces, and the "
        "target, whose form it takes on. Or open the example, in which an animal becomes a man.",
        (True, False): "Open the target, whose form the source takes on.",
        (False, True): "Open the source, which keeps its vertices and faces.",
    }[state.source is not None, state.target is not None]
    return {"surfaces": drawn(state, services), "next": told, "ready": False, "landmarks": []}


def described(both: Both, state: RegisterState, services: Services) -> dict[str, Any]:
    """Both surfaces, the landmarks, what is wrong, the result, and what to do next."""
    trouble = wrong(both, state, services)
    view: dict[str, Any] = {
        "surfaces": drawn(state, services),
        "landmarks": [asdict(one) for one in both.marked(state.recipe.landmarks)],
        "labels": [_labels(side) for side in both.sides],
        "trouble": None if trouble is None else asdict(trouble),
        "ready": trouble is None,
        "turnable": len(both.source.vertices) <= MOST_TURNED,
        "next": "" if trouble is not None else _next(state),
    }
    if state.result is not None:
        view["result"] = _made(state, state.result, services)
        view["warnings"] = list(state.result.warnings) if state.made else []
    return view


def wrong(both: Both, state: RegisterState, services: Services) -> Trouble | None:
    """Why it cannot be registered as it is."""
    recipe = state.recipe
    if is_mediator_file(recipe.mediator) and state.mediator is None:
        return Trouble("the mesh that is the mediator is not open; choose another mediator")
    surfaces = tuple(services.entry(mesh).surface for mesh in (state.source, state.target))
    titles = tuple(side.title for side in both.sides)
    return services.remembered(
        ("wrong", surfaces, titles, recipe.landmarks), lambda: both.wrong(recipe.landmarks)
    )


def placed(result: Registration) -> Correspondence:
    """The correspondence with the source moved onto the target, so that only the form changes."""
    correspondence = result.correspondence
    onto = surface_similarity(correspondence)
    start: Floats = correspondence.vertices_a
    if onto.scale > 0:
        start = onto.undo(start)
    return replace(correspondence, vertices_a=start)


def shape_at(state: RegisterState, at: str, services: Services) -> Product:
    """The shape at a time from 0 to 1, as it is seen: in the place of the target."""
    if state.result is None:
        raise InvalidInput("there is no shape to keep yet; register the meshes first")
    time = time_of(at)
    services.progress("making the shape", 0.0)
    result = services.blobs.result(state.result.result)
    way = way_of(state.recipe.morph, result)
    path = way.pop("path_kind")
    shape = result.mesh if time == 1 else between(placed(result), time, path=path, **way)
    source, target = (
        PurePath(services.entry(mesh).name).stem for mesh in (state.source, state.target)
    )
    name = f"{source} on {target}" if time == 1 else f"{source} to {target}, {time:.3g}"
    return Product.of(shape, name, services)


def _labels(side: Side) -> list[str]:
    """Attributes of the vertices that can be labels of regions."""
    values = side.surface.attributes.vertex
    return [name for name, one in values.items() if one.ndim == 1 and one.dtype.kind in "iu"]


def _made(state: RegisterState, result: Registered, services: Services) -> dict[str, Any]:
    """What the page shows of a result."""
    return {
        **result.model_dump(exclude={"of", "result", "warnings"}),
        "current": state.made is not None,
        "delay": delay(state.recipe.morph, result.result, services),
    }


def _next(state: RegisterState) -> str:
    """What to do now, in a sentence."""
    count = len(state.recipe.landmarks)
    if state.result is None:
        if count == 0:
            return (
                "Take the tool Landmark and click what corresponds, left and then right: the nose, "
                "tips of limbs, ears. Without landmarks it is a guess. Then register."
            )
        return "Register, or mark more of what corresponds."
    if state.made is None:
        return "Something was changed since: register again to see it."
    if count < FEW:
        return (
            "Scrub the morph. Where its half-way shape looks wrong, set landmarks on both meshes, "
            "and register again."
        )
    return "Scrub the morph, look at the figures, or export it."
