"""What a page is told of a design, beside its positions."""

from __future__ import annotations

from typing import Any

import numpy as np

from henkei.design import Designer, DesignQuality
from henkei.design.constraints import Constraint as Asked
from henkei.design.constraints import Curve, Derivative, Pin
from henkei.design.paths import Place
from henkei.progress import Progress
from henkei.recipes.design import KINDS, DesignRecipe
from henkei.studio.designing import Engine, freed
from henkei.workflows.design_by_recipe import MET, solved

MANY_VERTICES = 300_000  # from which on figures are left out, to be quick


def described(
    engine: Engine, recipe: DesignRecipe, level: int, progress: Progress
) -> dict[str, Any]:
    """Levels, constraints and figures of a design that is looked at at a level."""
    designer = engine.designer(recipe, level, progress)
    sizes = [engine.sizes[k] for k in range(recipe.levels + 1)]
    count = sizes[0].vertices
    free = freed(recipe, count)
    told: dict[str, Any] = {
        "shown": level,
        "levels": [{"vertices": size.vertices, "faces": size.faces} for size in sizes],
        "grid": engine.grid(level),
        "quads": engine.quads,
        "free": sorted(free),
        "let_go": len(free),
        "parts": _parts(engine, recipe, level, designer),
        "next": _next(recipe, len(free) == count),
        "figures": [
            {"label": "Vertices", "value": sizes[level].vertices, "hint": f"of level {level}"},
            {"label": "Faces", "value": sizes[level].faces, "hint": f"of level {level}"},
        ],
        "warnings": [],
    }
    if sizes[level].vertices <= MANY_VERTICES:
        designed = solved(designer, progress=progress)
        told["figures"] += _figures(designed.quality)
        told["warnings"] += designed.warnings
        told["conflicts"] = [list(one.names) for one in designed.quality.conflicts]
    return told


def _parts(
    engine: Engine, recipe: DesignRecipe, level: int, designer: Designer
) -> list[dict[str, Any]]:
    """The constraints by kind; those of levels that are not shown have no places."""
    asked = {one.name: one for one in designer.constraints}
    told = []
    for kind in KINDS:
        for name, one in zip(recipe.names(kind), recipe.parts(kind), strict=True):
            row: dict[str, Any] = {"kind": kind, "name": name, "level": one.level}
            if name in asked:
                row |= _placed(engine, asked[name])
            told.append(row)
    return told


def _placed(engine: Engine, one: Asked) -> dict[str, Any]:
    """The vertices that a constraint is at or near, and where it brings them."""
    if isinstance(one, Curve):
        places, line = one.path, one.target
        return {"path": [_vertex(engine, one.level, place) for place in places], "to": line}
    assert isinstance(one, Pin | Derivative)
    told = {"vertex": _vertex(engine, one.level, one.place)}
    return told if isinstance(one, Derivative) else {**told, "to": one.target}


def _vertex(engine: Engine, level: int, place: Place) -> int:
    """A vertex, or that of a face's corners which is nearest to a point in it."""
    if isinstance(place, int):
        return place
    face, weights = place
    faces = engine.faces(level)
    return int(faces.indices[faces.offsets[face] + int(np.argmax(weights))])


def _figures(quality: DesignQuality) -> list[dict[str, Any]]:
    asked = sum(quality.constraints)
    missed = quality.constraint_error
    figures: list[dict[str, Any]] = [
        {
            "label": "Pins and curves",
            "value": "met" if missed <= MET else f"missed by {100 * missed:.2g} %",
            "bad": missed > MET,
            "hint": f"The most, at their own level: {missed:.1e} of the diagonal; conflicts apart",
        }
    ]
    if quality.conflicts:
        figures.append({"label": "Conflicts", "value": len(quality.conflicts), "bad": True})
    if any(quality.offsets):
        figures.append(
            {
                "label": "Surface away from pins",
                "value": 100 * max(quality.offsets),
                "unit": "%",
                "hint": "The most, of the diagonal: finer levels add to what pins of coarse "
                "levels ask for. Pin at a finer level to be nearer",
            }
        )
    figures = figures if asked else []
    figures.append(
        {
            "label": "Roughness",
            "value": 100 * quality.roughness[-1],
            "unit": "%",
            "hint": "How far vertices are from the middle of their neighbours, of the diagonal. "
            "More gamma makes it smaller",
        }
    )
    return figures


def _next(recipe: DesignRecipe, all_free: bool) -> str:
    """What to do now."""
    asked = [one for kind in KINDS for one in recipe.parts(kind)]
    if not asked:
        return "Take the pin (P) and click the surface; then drag the pin."
    if all_free:
        return (
            "The cage holds nothing any more: the pins and curves alone say where the surface is."
        )
    if all(one.level <= 1 for one in asked):
        return "Choose a finer level for detail, or draw a curve (C). Then try gamma."
    return "Try gamma, or go on with pins and curves. Export when it is done."
