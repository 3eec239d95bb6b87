"""What the page shows of two meshes to be combined, and what can be kept of what was made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from henkei.errors import InvalidInput
from henkei.recipes.combine import CombineRecipe
from henkei.recipes.pairs import Pair
from henkei.studio.disks import Disks, Kind, Side
from henkei.studio.morphs import MOST_TURNED, delay, time_of
from henkei.studio.services import Services
from henkei.studio.tabs.base import Product, drawn
from henkei.workflows.morph_by_recipe import way_of

if TYPE_CHECKING:
    from henkei.studio.tabs.combine import Combined, CombineState


def described(state: CombineState, disks: Disks | None, services: Services) -> dict[str, Any]:
    """The view of a state.

    disks : its meshes as they would be combined; None where one is missing.
    """
    surfaces = drawn(state, services)
    view: dict[str, Any] = {"surfaces": surfaces, "next": "", "ready": False}
    if disks is None:
        return view | {"next": _begin(surfaces)}
    trouble = disks.trouble(state.recipe)
    advice = disks.advice(state.recipe) if trouble is None else None
    view |= {
        "sides": {side.name: _side(side) for side in disks.sides},
        "pairs": _rows(disks, "pairs", state.recipe),
        "landmarks": _rows(disks, "landmarks", state.recipe),
        "trouble": None if trouble is None else asdict(trouble),
        "ready": trouble is None,
        "advice": None if advice is None else asdict(advice),
        "turnable": MOST_TURNED,
        "snaps": any(map(_of_points, (state.recipe.pairs, state.recipe.landmarks))),
    }
    if state.result is not None:
        view["result"] = _made(state, state.result, services)
    return view | {"next": _next(state, trouble is None)}


def _rows(disks: Disks, kind: Kind, recipe: CombineRecipe) -> list[dict[str, int]]:
    return [{"a": a, "b": b} for a, b in disks.vertices(kind, recipe).tolist()]


def _of_points(pairs: str | tuple[Pair, ...]) -> bool:
    return bool(pairs) and not isinstance(pairs, str) and not isinstance(pairs[0][0], int)


def _side(side: Side) -> dict[str, Any]:
    """What the page shows of a mesh beside its surface."""
    loops = [
        {
            "vertex": loop.vertex,
            "vertices": loop.vertices,
            "length": loop.length,
            "outer": loop.outer,
        }
        for loop in side.loops
    ]
    return {"loops": loops, "sound": side.boundary is not None}


def _made(state: CombineState, result: Combined, services: Services) -> dict[str, Any]:
    """What the page shows of a result."""
    return {
        **result.model_dump(exclude={"of", "result"}),
        "current": state.made is not None,
        "delay": delay(state.recipe.morph, result.result, services),
    }


def shape_at(state: CombineState, at: str, services: Services) -> Product:
    """The shape at a time from 0 to 1."""
    if state.result is None:
        raise InvalidInput("there is no shape to keep yet; combine the meshes first")
    time = time_of(at)
    services.progress("making the shape", 0.0)
    result = services.blobs.result(state.result.result)
    way = way_of(state.recipe.morph, result)
    shape = result.at(time, path=way["path_kind"], time=way["time"], delay=way["delay"])
    a, b = (Path(services.entry(mesh).name).stem for mesh in (state.a, state.b))
    told = f"the combined mesh of both at time {time:.3g}"
    return Product.of(shape, f"{a} to {b}, {time:.3g}", services, told)


def _begin(chosen: Mapping[str, Any]) -> str:
    if chosen:
        return "Open the second mesh, or choose one that is open."
    return "Open two meshes, or the example with two heads."


def _next(state: CombineState, sound: bool) -> str:
    """What to do now, in a sentence."""
    if not sound:
        return ""
    if state.result is None:
        if state.recipe.pairs == "auto":
            return (
                "Pairs around both boundaries are proposed: look whether they belong together, "
                "then combine."
            )
        return "Combine, or mark what else corresponds."
    if state.made is None:
        return "Something was changed since: combine again to see it."
    if not state.recipe.landmarks:
        return (
            "Scrub the morph. Where features do not meet, mark them as landmarks on both, "
            "and combine again."
        )
    return "Scrub the morph, or export it."
