"""What a page is told of a deformation, beside its positions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import HenkeiError
from henkei.recipes.deform import Move, Pin
from henkei.studio.deform_parts import knows_features
from henkei.studio.deform_state import DeformState, engine_of, regions_of
from henkei.studio.deforming import Engine, Preparing
from henkei.studio.figures import figure
from henkei.studio.packing import KIND
from henkei.studio.services import Services
from henkei.workflows.deform_by_recipe import Deformed
from henkei.workflows.deform_doubts import LONGER, SOUND
from henkei.workflows.regions import Regions

MANY_VERTICES = 200_000  # from which on figures are left out, and features found when asked for
STRETCHED = 0.3  # of their length, by which the edges of a sound result change at most
ROUNDING = 1e-9  # of the diagonal, up to which what is to be met exactly is


def described(state: DeformState, services: Services) -> dict[str, Any]:
    """Found features, parts, figures, and what is to be done next."""
    regions = regions_of(state, services)
    many = len(regions.surface.vertices) > MANY_VERTICES
    told: dict[str, Any] = {
        "selected": len(state.selection),
        "found": None,
        "parts": [],
        "figures": [],
        "warnings": [],
        "trouble": None,
        "preparing": False,
        "next": state.next,
        "linear": state.recipe.method == "linear",
    }
    if state.sought or not many or knows_features(regions):
        told["found"] = _found(state, regions, services)
    try:
        engine = engine_of(state, services)
        told["parts"] = list(_parts(state, engine, services))
        if not state.missing and many:
            engine.positions(state.recipe)
        elif not state.missing:
            deformed = engine.deformed(state.recipe)
            told["figures"] = _figures(deformed, engine)
            told["warnings"] = list(deformed.warnings)
    except Preparing:
        told["preparing"] = True
    except HenkeiError as error:
        told["trouble"] = str(error)
    return told


def _found(state: DeformState, regions: Regions, services: Services) -> list[dict[str, Any]]:
    """What was found, and by which part it is kept."""
    if not knows_features(regions):
        services.progress("looking for holes, lines and pads", 0.0)
    finding = state.recipe.finding.model_dump()
    key = ("found", services.entry(state.mesh).surface, *finding.values())

    def make() -> list[dict[str, Any]]:
        vertices = regions.surface.vertices
        return [
            {
                "name": feature.name,
                "kind": feature.kind,
                "figures": feature.figures,
                "count": len(feature.vertices),
                "ids": _ids(feature.vertices, services),
                "at": int(feature.vertices[_nearest(vertices[feature.vertices], feature.centre)]),
            }
            for feature in regions.features.values()
        ]

    rows = services.remembered(key, make)
    return [{**row, "part": state.keeper(row["name"])} for row in rows]


def _nearest(points: NDArray[Any], to: NDArray[Any]) -> int:
    return int(((points - to) ** 2).sum(axis=1).argmin())


def _ids(vertices: NDArray[Any], services: Services) -> str:
    """A blob with vertex numbers."""
    return services.blobs.put_message({"kind": KIND}, values=vertices.astype(np.uint32))


def _parts(state: DeformState, engine: Engine, services: Services) -> Iterator[dict[str, Any]]:
    """Each part with its vertices, and what its controls start from."""
    stage, recipe = engine.stage, state.recipe
    stage.pose(recipe)
    for name, fixed in zip(state.parts("fixed"), stage.fixed, strict=True):
        yield _region("fixed", name, fixed.vertices, services)
    for (name, handle), posed in zip(state.parts("handles").items(), stage.handles, strict=True):
        told = _region("handles", name, posed.vertices, services)
        yield {**told, "centre": posed.centre.tolist(), "move": _move(handle.move, posed)}
    for (name, kept), features in zip(state.parts("features").items(), stage.features, strict=True):
        vertices = np.concatenate([one.vertices for one in features])
        rest = features[0].rest_radius if len(features) == 1 and kept.kept == "circle" else None
        told = _region("features", name, vertices, services)
        told |= {"keep": kept.kept, "scale": kept.scale, "radius": kept.radius}
        yield {**told, "rest_radius": rest, "several": len(features)}
    for (name, pin), pinned in zip(state.parts("pins").items(), stage.pins, strict=True):
        yield {"kind": "pins", "name": name, "vertex": _vertex(pin), "to": pinned.target.tolist()}


def _region(kind: str, name: str, vertices: NDArray[Any], services: Services) -> dict[str, Any]:
    ids = _ids(vertices, services)
    return {"kind": kind, "name": name, "count": len(vertices), "ids": ids}


def _vertex(pin: Pin) -> int | None:
    return pin.point if isinstance(pin.point, int) else None


def _move(move: Move, posed: Any) -> dict[str, Any]:
    """A pose about the centroid, its rotation as a vector in degrees."""
    plain = move.about is None and isinstance(move.rotation, tuple)
    rotation = move.rotation if plain else np.degrees(posed.rotation).tolist()
    translation = move.translation if plain else posed.translation.tolist()
    return {"translation": translation, "rotation": rotation, "scale": move.scale}


def _figures(deformed: Deformed, engine: Engine) -> list[dict[str, Any]]:
    """How good the result is, in words."""
    quality, elements, rest = deformed.quality, deformed.elements, engine.stage.elements
    worst, before = elements.worst_scaled_jacobian, rest.worst_scaled_jacobian
    rows = [
        figure(
            "Stretch of edges",
            _percent(quality.strain),
            "99 % of the edges are stretched or squeezed by no more than this",
            bad=quality.strain > STRETCHED,
        ),
        figure(
            "Largest stretch",
            _percent(deformed.largest_strain),
            "of the one edge that is stretched or squeezed most",
            bad=deformed.largest_strain > LONGER - 1,
        ),
        figure(
            "Worst face",
            f"{worst:.3f}",
            f"its scaled Jacobian: 1 is ideal, below 0 it is inside out; at rest {before:.3f}",
            bad=worst < SOUND <= before or worst <= 0,
        ),
        figure(
            "Folded triangles",
            quality.flipped,
            "triangles that face against the surface around them",
            bad=quality.flipped > 0,
        ),
        figure(
            "Features kept",
            _to(quality.feature_error, engine),
            "farthest that a vertex of a feature is from the shape it keeps",
            bad=quality.feature_error > ROUNDING,
        ),
        figure(
            "Places met",
            _to(quality.hard_position_error, engine),
            "farthest that what is fixed, moved or pinned is from its place",
            bad=quality.hard_position_error > ROUNDING,
        ),
    ]
    for name, (at_rest, now) in deformed.radii.items():
        rows.append(figure(f"Radius of {name}", f"{now:.5g}", f"at rest {at_rest:.5g}"))
    return rows


def _to(error: float, engine: Engine) -> str:
    """An error that is a fraction of the diagonal, in the unit of the mesh."""
    if error <= ROUNDING:
        return "exactly"
    return f"to {error * engine.stage.deformer.mesh.diagonal:.3g}"


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"
