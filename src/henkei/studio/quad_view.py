"""What a page is told of quads that are wished, and of those that were made."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from henkei.errors import HenkeiError
from henkei.quad.quality import QuadQuality
from henkei.recipes.quad import QuadRecipe
from henkei.studio.figures import figure
from henkei.studio.quad_preview import Preview, preview_of
from henkei.studio.services import Services
from henkei.studio.tasks.quad import KINDS

if TYPE_CHECKING:
    from henkei.studio.tabs.quad import Made, QuadState

LAYOUTS = {"field": "lines of a cross field", "vsa": "flat patches"}
FAR = 0.02  # of the diagonal: a distance that is seen
OFF = 0.15  # of the number that was asked for


def described(state: QuadState, services: Services) -> dict[str, Any]:
    """The surfaces, and what can be said of them."""
    entry = services.entry(state.mesh)
    view: dict[str, Any] = {
        "surfaces": {"input": {"data": services.drawn(entry.surface)}},
    }
    if state.result is not None:
        view["surfaces"]["quads"] = {"data": state.result.quads}
        view["result"] = told_of(state.result) | {"current": state.made is not None}
    if state.cage is not None:
        view["surfaces"]["cage"] = {"data": state.cage.cage}
    try:
        preview = preview_of(entry.surface, services)
        view["wish"] = measured(preview)
        preview.quads(state.recipe)  # refuses what cannot be made
        view["wish"] |= wish(preview, state.recipe, entry.surface, services)
        if state.recipe.symmetry is not None and not preview.large:
            asked = ("quad", "symmetry", entry.surface, state.recipe.symmetry)
            refusal = services.remembered(asked, lambda: _asymmetry(preview, state.recipe))
            view |= {"trouble": refusal} if refusal else {}
    except HenkeiError as error:
        view["trouble"] = str(error)
    return view | {"next": _next(state, "trouble" in view)}


# What is wished


def measured(preview: Preview) -> dict[str, Any]:
    """What is known of the surface itself.

    Its ``area``; how many edges are on its ``border``; ``densities``, the attributes that can be
    one; whether it is ``large``.
    """
    return {
        "area": preview.area,
        "border": preview.border,
        "densities": preview.densities,
        "large": preview.large,
    }


def wish(preview: Preview, recipe: QuadRecipe, blob: str, services: Services) -> dict[str, Any]:
    """What is known of the quads before they are made; nothing where the surface is large.

    ``lines``, a blob with the edges that will be kept, see
    :meth:`henkei.studio.quad_preview.Preview.lines`; ``sizes``, a blob with the edge length at each
    vertex, if these differ; ``plane`` of symmetry.

    Raises
    ------
    HenkeiError : what the recipe asks for cannot be had.
    """
    told: dict[str, Any] = {}
    if preview.large:
        return told

    def remembered(what: str, *on: object, make: Callable[[], Any]) -> Any:
        return services.remembered(("quad", what, blob, *on), make)

    def lines() -> str:
        return services.blobs.put_message({"kind": "lines"}, **preview.lines(recipe))

    def sizes() -> dict[str, Any]:
        values = preview.sizes(recipe)
        limits = float(values.min()), float(values.max())
        return {"data": services.values(values), "limits": limits}

    sized = (recipe.quads, recipe.edge_length, recipe.density)
    by_angle = isinstance(recipe.sharp, float)
    told["lines"] = remembered("lines", by_angle or (recipe.sharp, *sized), make=lines)
    if recipe.density is not None:
        told["sizes"] = remembered("sizes", *sized, make=sizes)
    if recipe.symmetry is not None:
        told["plane"] = preview.plane(recipe)
    return told


def _asymmetry(preview: Preview, recipe: QuadRecipe) -> str | None:
    """Why the surface is not symmetric as the recipe says; None if it is."""
    try:
        preview.require_symmetric(recipe)
    except HenkeiError as error:
        return str(error)
    return None


def _next(state: QuadState, trouble: bool) -> str:
    """What to do now, in a sentence."""
    if trouble:
        return ""
    if state.result is None:
        return "Choose how many quads there should be, then make them."
    if state.made is None:
        return "Settings were changed since: make the quads again."
    return "Look at quality and patches, hold C to compare with the input, or export them."


# What was made


def told_of(result: Made) -> dict[str, Any]:
    """What the page shows of quads beside their surface."""
    return {
        "details": result.details,
        "kinds": [
            {"label": kind.label, "colour": kind.color, "count": count}
            for kind, count in zip(KINDS, result.irregular, strict=True)
        ],
        "figures": figures(result.quality, result.wished),
        "warnings": warnings(result.quality),
        "worst": result.quality.worst_scaled_jacobian,
    }


def figures(quality: QuadQuality, wished: int | None) -> list[dict[str, Any]]:
    """What tells whether to trust them: rows of label and value, ``bad`` where one is not good."""
    q = quality
    asked = f"{wished:,} were asked for" if wished else ""
    rows = [
        figure(
            "Quads", q.quads, asked, wished is not None and abs(q.quads - wished) > OFF * wished
        ),
        figure("Irregular vertices", q.irregular, "inside, where other than four quads meet"),
        figure("Patches", q.patches, f"bounded by {LAYOUTS.get(q.layout, q.layout)}"),
        figure(
            "Worst shape",
            round(q.worst_scaled_jacobian, 3),
            "scaled Jacobian: 1 for a rectangle, 0 or less for a folded quad",
            q.worst_scaled_jacobian <= 0,
        ),
        figure("Mean shape", round(q.mean_scaled_jacobian, 3), "likewise, over all quads"),
        figure(
            "Corners off square",
            round(q.mean_angle_deviation, 1),
            "how far corners are from 90 degrees, on average",
            unit="°",
        ),
        figure("Folded quads", q.inverted, "a corner is turned inside out", q.inverted > 0),
        figure("Flipped quads", q.flipped, "they face against the surface", q.flipped > 0),
        _percent("Quads off the input", q.distance_to_input, "at most"),
        _percent("Input off the quads", q.distance_from_input, "at most"),
        _percent("Mean distance", q.mean_distance, "both ways"),
    ]
    if q.asymmetry:
        rows.append(_percent("Input off its mirror image", q.asymmetry, "at most"))
    return rows


def warnings(quality: QuadQuality) -> list[str]:
    """What is not as it should be, and what to do."""
    q, told = quality, []
    if q.flipped:
        told.append(
            f"{_many(q.flipped, 'quad faces', 'quads face')} against the surface: something there "
            "is thinner than a quad. Ask for more quads, or for a density that is higher there."
        )
    if q.inverted:
        told.append(
            f"{_many(q.inverted, 'quad is', 'quads are')} folded; the quality view shows where. "
            "Ask for more quads, try another layout or seed, or keep fewer sharp edges."
        )
    if q.turned_faces:
        told.append(
            f"{_many(q.turned_faces, 'face', 'faces')} of the input wound against the others; the "
            "quads all wind as most of them do."
        )
    return told


def _percent(label: str, fraction: float, of: str) -> dict[str, Any]:
    hint = f"{of}, in percent of the diagonal of the bounding box"
    return figure(label, float(f"{100 * fraction:.2g}"), hint, fraction > FAR, "%")


def _many(number: int, one: str, many: str) -> str:
    return f"{number:,} {one if number == 1 else many}"
