"""A surface designed as a recipe says, and a recipe from what was designed."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from henkei.design import Designer, DesignQuality, constraints
from henkei.design.paths import EXACT, Place
from henkei.design.refinement import connectivity, counts
from henkei.design.settings import checked_refinement
from henkei.errors import InvalidInput, some
from henkei.geometry.arguments import numbers
from henkei.mesh import Mesh, PolygonMesh, Surface
from henkei.progress import Progress, part, silent
from henkei.recipes import design as recipes
from henkei.recipes.design import KINDS, Constraint, DesignRecipe, Kind
from henkei.recipes.recipe import ORIGIN
from henkei.workflows.design_places import Places
from henkei.workflows.regions import naming

MET = 1e-9  # error of constraints, by the diagonal, up to which they count as met


@dataclass(frozen=True, eq=False)
class Designed:
    """A designed surface and how good it is.

    designer : with the constraints of the recipe, for further edits and other levels.
    surface : at the last level, with the attributes of the cage.
    warnings : why not to trust it, or what is left out; none if all is well.
    seconds : that solving took.
    """

    designer: Designer
    surface: Mesh | PolygonMesh
    quality: DesignQuality
    warnings: tuple[str, ...]
    seconds: float


def design_by_recipe(
    cage: Any,
    recipe: Any,
    *,
    levels: int | None = None,
    gamma: float | Sequence[float] | None = None,
    progress: Progress = silent,
) -> Designed:
    """Design a surface as a recipe says.

    Parameters
    ----------
    cage : as :class:`henkei.Designer` takes it.
    recipe : a :class:`henkei.recipes.design.DesignRecipe`, its data as a dictionary, or its file.
    levels, gamma : in place of the recipe's. Constraints of levels that are then finer than the
        last one are left out, with a warning; the others give the same surface at these levels.

    Raises
    ------
    HenkeiError : as :class:`henkei.Designer`; where a constraint does not fit the cage, the message
        names its field in the recipe.
    """
    recipe = DesignRecipe.from_any(recipe)
    chosen = adapted(recipe, levels=levels, gamma=gamma)
    designer = designer_of(cage, chosen, part(progress, 0.0, 0.3))
    constrain(designer, chosen)
    return solved(designer, left_out(recipe, chosen), part(progress, 0.3, 1.0))


def adapted(
    recipe: DesignRecipe,
    *,
    levels: int | None = None,
    gamma: float | Sequence[float] | None = None,
) -> DesignRecipe:
    """The recipe with other levels or gamma; constraints of finer levels are left out.

    Raises
    ------
    InvalidInput : a value is out of range, or the recipe has weights for fewer levels.
    """
    data = recipe.model_dump(exclude_defaults=True)
    if levels is not None:
        levels = DesignRecipe.of({"levels": levels}).levels
        data["levels"] = levels
        for kind in KINDS:
            # With their names, which would else count those that are left.
            data[kind] = [
                {**one.model_dump(exclude_defaults=True), "name": name}
                for one, name in zip(recipe.parts(kind), recipe.names(kind), strict=True)
                if one.level <= levels
            ]
        if isinstance(recipe.gamma, tuple) and levels < recipe.levels:
            data["gamma"] = recipe.gamma[: levels + 1]
    if gamma is not None:
        data["gamma"] = gamma if isinstance(gamma, float | int) else numbers(gamma).tolist()
        data["axis_gamma"] = None
    return DesignRecipe.of(data)


def left_out(recipe: DesignRecipe, chosen: DesignRecipe) -> list[str]:
    """A warning where an adapted recipe has no place for constraints of finer levels."""
    finer = [
        name
        for kind in KINDS
        for one, name in zip(recipe.parts(kind), recipe.names(kind), strict=True)
        if one.level > chosen.levels
    ]
    if not finer:
        return []
    return [f"left out, as they are of levels finer than {chosen.levels}: {some(map(repr, finer))}"]


def sizes(cage: Surface, recipe: DesignRecipe) -> list[tuple[int, int, int]]:
    """Vertices, edges and faces of each level, found without refining.

    Raises
    ------
    InvalidMesh : the cage cannot be refined.
    InvalidInput : not into triangles.
    """
    base = connectivity(cage)
    quads = checked_refinement(recipe.refinement, bool((base.sizes == 3).all()))
    return counts(base, quads, recipe.levels)


def designer_of(cage: Any, recipe: DesignRecipe, progress: Progress = silent) -> Designer:
    """A designer with the settings of a recipe, and no constraints but the pins of the cage.

    Raises
    ------
    HenkeiError : as :class:`henkei.Designer`.
    """
    designer = Designer(
        cage,
        recipe.levels,
        gamma=recipe.gamma,
        steps=recipe.steps,
        support=recipe.support,
        interpolating=recipe.interpolating,
        refinement=recipe.refinement,
        progress=progress,
    )
    designer.axis_gamma = recipe.axis_gamma
    designer.axis_smoothing = recipe.axis_smoothing
    return designer


def constrain(designer: Designer, recipe: DesignRecipe, places: Places | None = None) -> None:
    """Ask of the surface what a recipe asks.

    Parameters
    ----------
    places : where the recipe's points are; by default on the cage as it is refined.

    Raises
    ------
    InvalidInput : a constraint does not fit the cage; the message names its field.
    """
    if recipe.unpin:
        with naming("unpin"):
            designer.unpin(None if recipe.unpin == "all" else list(recipe.unpin))
    places = places or Places.on_cage(designer)
    for kind in KINDS:
        named = zip(recipe.parts(kind), recipe.names(kind), strict=True)
        for index, (one, name) in enumerate(named):
            add_constraint(designer, one, name, f"{kind}[{index}]", places)


def solved(
    designer: Designer, warnings: Sequence[str] = (), progress: Progress = silent
) -> Designed:
    """The surface, and how good it is; ``warnings`` come before its own."""
    start = time.perf_counter()
    surface = designer.solve(progress)
    seconds = time.perf_counter() - start
    quality = designer.quality
    return Designed(designer, surface, quality, (*warnings, *_doubts(quality)), seconds)


def recipe_of(designer: Designer, about: str = "") -> DesignRecipe:
    """The recipe that makes the same surface of the same cage, to the bit.

    Raises
    ------
    InvalidInput : a part of the surface is refined or smoothed alone, which recipes cannot say.
    """
    if not designer.is_whole:
        raise InvalidInput(
            "a recipe holds no levels that are refined only in part, and no part that is smoothed "
            "alone: end the latter with smooth_only(), and design without refine(faces)"
        )
    axis_gamma, gamma = designer.axis_gamma, designer.gamma
    free = np.flatnonzero(~designer.pinned).tolist()
    data: dict[str, Any] = {
        "about": about,
        "levels": designer.levels,
        "gamma": gamma if isinstance(gamma, float) else gamma.tolist(),
        "axis_gamma": None if axis_gamma is None else axis_gamma.tolist(),
        "axis_smoothing": designer.axis_smoothing,
        "steps": designer.steps,
        "support": designer.support,
        "interpolating": designer.interpolating,
        "refinement": designer.refinement,
        "unpin": "all" if len(free) == len(designer.pinned) else free,
        **{kind: [] for kind in KINDS},
    }
    for one in designer.constraints:
        kind, fields = _written(one)
        named = {} if one.name == f"{kind[:-1]} {len(data[kind]) + 1}" else {"name": one.name}
        data[kind].append({**named, "level": one.level, **fields, "to": one.target.tolist()})
    return DesignRecipe.of(data)


def _written(one: constraints.Constraint) -> tuple[Kind, dict[str, Any]]:
    """Under which key a constraint stands, and where it acts."""
    if isinstance(one, constraints.Pin):
        return "pins", {"point": _place_data(one.place)}
    if isinstance(one, constraints.Curve):
        fields = {"path": [_place_data(place) for place in one.path]}
        return "curves", fields if one.cutoff == EXACT else {**fields, "cutoff": one.cutoff}
    assert isinstance(one, constraints.Derivative)
    return "derivatives", {"point": _place_data(one.place), "direction": one.direction}


def _place_data(place: Place) -> Any:
    return place if isinstance(place, int) else {"face": place[0], "barycentric": place[1]}


def _doubts(quality: DesignQuality) -> list[str]:
    found = [str(conflict) for conflict in quality.conflicts]
    if quality.constraint_error > MET:
        found.append(
            f"constraints are met only up to {quality.constraint_error:.1e} of the diagonal; are "
            "two of them nearly the same?"
        )
    return found


def add_constraint(
    designer: Designer, one: Constraint, name: str, field: str, places: Places
) -> None:
    """Ask for one constraint; it gets its target once it is known to fit.

    Parameters
    ----------
    field : what messages call it, as in "pins[0]".

    Raises
    ------
    InvalidInput : it does not fit the cage.
    """
    match one:
        case recipes.Pin():
            place = places.place(one.level, one.point, f"{field}.point")
            with naming(field):
                pin = designer.pin(one.level, place, one.to or ORIGIN, name=name)
            if one.to is None:
                targets = places.moved(one.level, [pin.place], one.move)
            else:
                targets = places.brought(one.level, [pin.place], [one.to])
            designer.move(pin, targets[0])
        case recipes.Curve():
            path = _path(designer, one, field, places)
            line = one.to or [ORIGIN] * len(path)
            with naming(field):
                curve = designer.curve(one.level, path, line, name=name, cutoff=one.cutoff)
            if one.to is None:
                designer.move(curve, places.moved(one.level, curve.path, one.move))
            else:
                designer.move(curve, places.brought(one.level, curve.path, one.to))
        case recipes.Derivative():
            place = places.place(one.level, one.point, f"{field}.point")
            with naming(field):
                designer.derivative(one.level, place, one.direction, one.to, name=name)


def _path(designer: Designer, one: recipes.Curve, field: str, places: Places) -> Sequence[Any]:
    """The points of a curve; along edges if there are [x, y, z] among them."""
    path = [
        places.place(one.level, point, f"{field}.path[{index}]")
        for index, point in enumerate(one.path)
    ]
    if not any(isinstance(point, tuple) for point in one.path):
        return path
    through = [
        places.vertex(one.level, point) if isinstance(point, tuple) else place
        for point, place in zip(one.path, path, strict=True)
    ]
    with naming(f"{field}.path"):
        return designer.path(one.level, through)
