"""What the page shows of two meshes to be combined, and what can be kept of what was made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from henkei.errors import InvalidInput
from henkei.mesh import Floats, Surface
from henkei.recipes.combine import CombineRecipe
from henkei.recipes.pairs import Pair
from henkei.studio.disks import REPAIRS, Disks, Kind, Repair, Side
from henkei.studio.services import Services
from henkei.studio.tabs.base import Product
from henkei.studio.turning import MOST_TURNED
from henkei.workflows.morph_by_recipe import swept, way_of

if TYPE_CHECKING:
    from henkei.studio.tabs.combine import Combined, CombineState


def described(state: CombineState, disks: Disks | None, services: Services) -> dict[str, Any]:
    """The view of a state.

    disks : its meshes as they would be combined; None where one is missing.
    """
    chosen = {slot: mesh for slot, mesh in state.meshes.items() if mesh is not None}
    surfaces = {
        slot: {"data": services.drawn(services.entry(mesh).surface)}
        for slot, mesh in chosen.items()
    }
    view: dict[str, Any] = {"surfaces": surfaces, "next": "", "ready": False}
    if disks is None:
        return view | {"next": _begin(chosen)}
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
        "delay": _delay(state, result, services),
    }


def _delay(state: CombineState, result: Combined, services: Services) -> str | None:
    """A blob with the time at which each vertex starts; None if all start at once."""
    side = state.recipe.morph.sweep
    if side is None:
        return None

    def make() -> str:
        vertices: Floats = services.blobs.get_message(result.shapes).arrays["positions"]
        return services.values(swept(vertices.astype(np.float64), side))

    return services.remembered(("delay", result.shapes, side), make)


def shape_at(state: CombineState, at: str, services: Services) -> Product:
    """The shape at a time from 0 to 1."""
    if state.result is None:
        raise InvalidInput("there is no shape to keep yet; combine the meshes first")
    try:
        time = float(at)
    except ValueError:
        raise InvalidInput(f"a time from 0 to 1 names a shape, not {at[:40]!r}") from None
    services.progress("making the shape", 0.0)
    result = services.blobs.result(state.result.result)
    way = way_of(state.recipe.morph, result)
    shape = result.at(time, path=way["path_kind"], time=way["time"], delay=way["delay"])
    a, b = (Path(services.entry(mesh).name).stem for mesh in (state.a, state.b))
    told = f"the combined mesh of both at time {time:.3g}"
    return _product(shape, f"{a} to {b}, {time:.3g}", told, services)


def repaired(state: CombineState, repair: Repair, slot: str, services: Services) -> Product:
    """A mesh after a repair."""
    entry = services.entry(state.meshes[slot])
    function, called = REPAIRS[repair]
    surface = function(services.blobs.surface(entry.surface))
    return _product(surface, f"{Path(entry.name).stem}, {called}", "", services)


def _product(surface: Surface, name: str, about: str, services: Services) -> Product:
    return Product(
        surface=services.blobs.put_surface(surface),
        name=name,
        vertices=len(surface.vertices),
        faces=surface.face_count,
        about=about,
    )


def _begin(chosen: Mapping[str, str]) -> str:
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
