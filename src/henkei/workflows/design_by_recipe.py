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
from henkei.geometry.distance import ClosestPoints
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh, Surface
from henkei.progress import Progress, part, silent
from henkei.recipes import design as recipes
from henkei.recipes.design import KINDS, Constraint, DesignRecipe, Kind
from henkei.recipes.recipe import ORIGIN, Point
from henkei.topology import Ints
from henkei.workflows.regions import naming

NEAR = 0.1  # how far from the refined cage a point of it may be, as a fraction of its diagonal
MET = 1e-9  # error of constraints, by the diagonal, up to which they count as met
NEWTON = 8  # steps to the bilinear weights of a point; of parallelograms the first is exact


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
    recipe: DesignRecipe,
    *,
    levels: int | None = None,
    gamma: float | Sequence[float] | None = None,
    progress: Progress = silent,
) -> Designed:
    """Design a surface as a recipe says.

    Parameters
    ----------
    cage : as :class:`henkei.Designer` takes it.
    recipe : see :class:`henkei.recipes.design.DesignRecipe`.
    levels, gamma : in place of the recipe's. Constraints of levels that are then finer than the
        last one are left out, with a warning; the others give the same surface at these levels.

    Raises
    ------
    HenkeiError : as :class:`henkei.Designer`; where a constraint does not fit the cage, the message
        names its field in the recipe.
    """
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


def constrain(designer: Designer, recipe: DesignRecipe) -> None:
    """Ask of the surface what a recipe asks.

    Raises
    ------
    InvalidInput : a constraint does not fit the cage; the message names its field.
    """
    if recipe.unpin:
        with naming("unpin"):
            designer.unpin(None if recipe.unpin == "all" else list(recipe.unpin))
    refined = _Refined(designer)
    for kind in KINDS:
        named = zip(recipe.parts(kind), recipe.names(kind), strict=True)
        for index, (one, name) in enumerate(named):
            _add(designer, one, name, f"{kind}[{index}]", refined)


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
    """The recipe that makes the same surface of the same cage, to the bit."""
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


def position(surface: Surface, place: Place) -> Floats:
    """Where a place of a surface is, (3,)."""
    if isinstance(place, int):
        corners, weights = [place], [1.0]
    else:
        corners, weights = _corners(surface, place[0]).tolist(), list(place[1])
    there: Floats = np.tensordot(weights, surface.vertices[corners], 1)
    return there


def _doubts(quality: DesignQuality) -> list[str]:
    found = [str(conflict) for conflict in quality.conflicts]
    if quality.constraint_error > MET:
        found.append(
            f"constraints are met only up to {quality.constraint_error:.1e} of the diagonal; are "
            "two of them nearly the same?"
        )
    return found


def _add(designer: Designer, one: Constraint, name: str, field: str, refined: _Refined) -> None:
    """Ask for one constraint; one that is told by how far it moves goes there from the origin."""
    match one:
        case recipes.Pin():
            place = refined.place(one.level, one.point, f"{field}.point")
            with naming(field):
                pin = designer.pin(one.level, place, one.to or ORIGIN, name=name)
            if one.to is None:
                there = position(refined.surface(one.level), pin.place)
                designer.move(pin, there + one.move)
        case recipes.Curve():
            path = [
                refined.place(one.level, point, f"{field}.path[{index}]")
                for index, point in enumerate(one.path)
            ]
            line = one.to or [ORIGIN] * len(path)
            with naming(field):
                curve = designer.curve(one.level, path, line, name=name, cutoff=one.cutoff)
            if one.to is None:
                surface = refined.surface(one.level)
                there = np.array([position(surface, place) for place in curve.path])
                designer.move(curve, there + one.move)
        case recipes.Derivative():
            place = refined.place(one.level, one.point, f"{field}.point")
            with naming(field):
                designer.derivative(one.level, place, one.direction, one.to, name=name)


class _Refined:
    """The cage as it is refined, where points are looked for that a recipe gives as [x, y, z]."""

    def __init__(self, designer: Designer) -> None:
        self._designer = designer
        self._surfaces: dict[int, Mesh | PolygonMesh] = {}
        self._triangles: dict[int, tuple[Mesh, ClosestPoints]] = {}

    def place(self, level: int, point: recipes.Place, field: str) -> Place:
        """A point of a level as a designer takes it.

        Raises
        ------
        InvalidInput : [x, y, z] is far from the refined cage; the message names the field.
        """
        match point:
            case int():
                return point
            case recipes.OnFace():
                return point.face, point.barycentric
        with naming(field):
            return self._nearest(level, point)

    def surface(self, level: int) -> Mesh | PolygonMesh:
        """The cage at a level."""
        if level not in self._surfaces:
            self._surfaces[level] = self._designer.flat(level)
        return self._surfaces[level]

    def _nearest(self, level: int, point: Point) -> Place:
        surface = self.surface(level)
        if level not in self._triangles:
            numbered = Attributes(face={"face": np.arange(surface.face_count)})
            faces = surface.indices, surface.offsets
            mesh = PolygonMesh(surface.vertices, faces, attributes=numbered).triangulated()
            self._triangles[level] = mesh, ClosestPoints(mesh)
        mesh, closest = self._triangles[level]
        places, distances = closest.query([point])
        triangle, weights = int(places.face[0]), places.barycentric[0]
        if distances[0] > NEAR * surface.diagonal:
            digits = 6 - int(np.floor(np.log10(surface.diagonal)))
            there = weights @ surface.vertices[mesh.faces[triangle]]
            raise InvalidInput(
                f"{list(point)} is {distances[0]:.4g} away from the cage as refined to level "
                f"{level}, more than {NEAR:.0%} of its diagonal; the point nearest to it is "
                f"{(np.round(there, digits) + 0.0).tolist()}"
            )
        face = int(mesh.attributes.face["face"][triangle])
        corners = _corners(surface, face)
        found = np.zeros(len(corners))
        np.add.at(found, [corners.tolist().index(v) for v in mesh.faces[triangle]], weights)
        if len(corners) == 4:
            found = _bilinear(surface.vertices[corners], found)
        return face, tuple(found.tolist())


def _corners(surface: Surface, face: int) -> Ints:
    return surface.indices[surface.offsets[face] : surface.offsets[face + 1]]


def _bilinear(corners: Floats, weights: Floats) -> Floats:
    """Weights of the bilinear function on a quad (4, 3) for the point that weights on one of its
    triangles give, or on a quad that is not planar one near it."""
    point = weights @ corners
    u, v = weights[1] + weights[2], weights[2] + weights[3]
    for _ in range(NEWTON):
        slopes = np.column_stack(
            [
                (1 - v) * (corners[1] - corners[0]) + v * (corners[2] - corners[3]),
                (1 - u) * (corners[3] - corners[0]) + u * (corners[2] - corners[1]),
            ]
        )
        step = np.linalg.lstsq(slopes, point - _grid_weights(u, v) @ corners)[0]
        u, v = np.clip([u + step[0], v + step[1]], 0, 1).tolist()
    return _grid_weights(u, v)


def _grid_weights(u: float, v: float) -> Floats:
    return np.array([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
