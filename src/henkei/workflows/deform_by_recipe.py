"""A mesh deformed as a recipe says."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from henkei.deform import Deformer, DeformQuality, Feature, Fixed, Handle, Pin, Settings
from henkei.errors import InvalidInput, some
from henkei.geometry.distance import ClosestPoints
from henkei.geometry.element_quality import ElementQuality, element_quality
from henkei.geometry.rotations import matrices_from_vectors
from henkei.mesh import Attributes, Floats, PolygonMesh, Surface
from henkei.progress import Progress, part, silent
from henkei.recipes import deform as recipes
from henkei.recipes.deform import DeformRecipe
from henkei.recipes.recipe import Point
from henkei.recipes.regions import Found
from henkei.workflows.regions import Regions, naming

P = TypeVar("P")


@dataclass(eq=False)
class Staged:
    """A deformer with the parts of a recipe, in the recipe's order.

    features : of each entry one, or as many as its name stands for, such as ``"hole *"``.
    seconds : that preparing took.
    """

    deformer: Deformer
    fixed: list[Fixed]
    features: list[list[Feature]]
    handles: list[Handle]
    pins: list[Pin]
    seconds: float = 0.0

    def prepare(self, recipe: DeformRecipe, progress: Progress = silent) -> None:
        """Factor the systems, for the recipe's method."""
        start = time.perf_counter()
        self.deformer.prepare(progress, method=recipe.method)
        self.seconds = time.perf_counter() - start

    def pose(self, recipe: DeformRecipe) -> None:
        """Move all parts to where the recipe has them, whatever they were before.

        Parameters
        ----------
        recipe : with the parts that this was made of; only what it says of moves, sizes and targets
            may differ.

        Raises
        ------
        InvalidInput : a scale or radius is not positive; the message names the part.
        """
        for handle, moved in zip(self.handles, recipe.handles, strict=True):
            _move(handle, moved.move)
        for features, kept in zip(self.features, recipe.features, strict=True):
            for feature in features:
                feature.scale = kept.scale
                if feature.rest_radius is not None:
                    feature.radius = feature.rest_radius if kept.radius is None else kept.radius
        for pin, pinned in zip(self.pins, recipe.pins, strict=True):
            pin.move(pin.rest + pinned.move if pinned.to is None else pinned.to)


@dataclass(frozen=True, eq=False)
class Deformed:
    """A deformed mesh and how good it is.

    mesh : faces and attributes as given.
    elements : of this mesh.
    seconds : that solving took, once all was prepared.
    """

    mesh: Surface
    quality: DeformQuality
    elements: ElementQuality
    seconds: float

    @property
    def figures(self) -> dict[str, float]:
        """What tells whether to trust it, in one row."""
        return {
            "worst_scaled_jacobian": self.elements.worst_scaled_jacobian,
            "worst_aspect_ratio": self.elements.worst_aspect_ratio,
            "feature_error": self.quality.feature_error,
            "hard_position_error": self.quality.hard_position_error,
            "flipped": self.quality.flipped,
            "strain": self.quality.strain,
        }


def staged(recipe: DeformRecipe, surface: Surface, *, folder: Path = Path()) -> Staged:
    """A deformer that holds, moves and keeps what the recipe says, at rest and not yet prepared.

    Parameters
    ----------
    recipe : see :class:`henkei.recipes.deform.DeformRecipe`.
    surface : the mesh at rest.
    folder : that files which the recipe names are in.

    Raises
    ------
    HenkeiError : a region is empty or cannot be found on this surface, or as :class:`Deformer`; the
        message names the field of the recipe or the name of the part.
    """
    deformer = Deformer(surface, settings=Settings(**recipe.settings))
    regions = Regions(surface, folder, recipe.finding.model_dump())
    fixed = [
        deformer.fix(regions.vertices(held.region, place), weight=held.weight, name=name)
        for held, name, place in _parts(recipe.fixed, recipe.names("fixed"), "fixed")
    ]
    features = [
        [
            deformer.feature(vertices, keep=kept.kept, weight=kept.weight, name=own_name)
            for own_name, vertices in _bodies(kept, name, regions, place)
        ]
        for kept, name, place in _parts(recipe.features, recipe.names("features"), "features")
    ]
    handles = [
        deformer.handle(regions.vertices(moved.region, place), weight=moved.weight, name=name)
        for moved, name, place in _parts(recipe.handles, recipe.names("handles"), "handles")
    ]
    pins = [
        deformer.pin(_point(pin.point, surface, place), weight=pin.weight, name=name)
        for pin, name, place in _parts(recipe.pins, recipe.names("pins"), "pins")
    ]
    _relate(deformer, recipe, {f.name: f for several in features for f in several})
    return Staged(deformer, fixed, features, handles, pins)


def solved(stage: Staged, recipe: DeformRecipe) -> Deformed:
    """Pose the parts as the recipe says, and solve.

    Raises
    ------
    HenkeiError : as :meth:`Staged.pose` and :meth:`henkei.Deformer.solve`.
    """
    start = time.perf_counter()
    stage.pose(recipe)
    stage.deformer.solve(method=recipe.method)
    seconds = time.perf_counter() - start
    mesh = stage.deformer.result
    return Deformed(mesh, stage.deformer.quality, element_quality(mesh), seconds)


def deform_by_recipe(
    recipe: DeformRecipe,
    surface: Surface,
    *,
    folder: Path = Path(),
    progress: Progress = silent,
) -> Deformed:
    """Deform a mesh as a recipe says; see :func:`staged` for parameters and errors."""
    progress("finding regions", 0.0)
    stage = staged(recipe, surface, folder=folder)
    stage.prepare(recipe, part(progress, 0.1, 0.8))
    progress("solving", 0.8)
    return solved(stage, recipe)


def _parts(parts: Sequence[P], names: Sequence[str], kind: str) -> Iterator[tuple[P, str, str]]:
    """Each part with its name, and where its region or point stands in the recipe."""
    field = "point" if kind == "pins" else "region"
    for index, (one, name) in enumerate(zip(parts, names, strict=True)):
        yield one, name, f"{kind}[{index}].{field}"


def _bodies(
    kept: recipes.Feature, name: str, regions: Regions, place: str
) -> list[tuple[str, NDArray[np.int64]]]:
    """Name and vertices of each feature of an entry: of several by one name, each for itself."""
    if kept.name is None and isinstance(kept.region, Found):
        with naming(place):
            return [(found.name, found.vertices) for found in regions.found(kept.region.feature)]
    return [(name, regions.vertices(kept.region, place))]


def _relate(deformer: Deformer, recipe: DeformRecipe, features: Mapping[str, Feature]) -> None:
    """What the parts keep to each other: offsets and symmetry."""
    for index, (offset, name) in enumerate(
        zip(recipe.offsets, recipe.names("offsets"), strict=True)
    ):
        with naming(f"offsets[{index}].between"):
            for one in offset.between:
                if one not in features:
                    known = some(map(repr, features), 12)
                    raise InvalidInput(f"there is no feature {one!r}; there are {known}")
            first, second = (features[one] for one in offset.between)
            deformer.keep_offset(first, second, name=name)
    if recipe.symmetry:
        plane = recipe.symmetry
        with naming("symmetry"):
            deformer.symmetry(plane.point, plane.normal, tolerance=plane.tolerance)


def _point(point: recipes.Place, surface: Surface, place: str) -> Any:
    """A point of the surface as :meth:`Deformer.pin` takes it."""
    match point:
        case recipes.OnFace():
            return point.face, np.array(point.barycentric)
        case recipes.OnEdge():
            return point.edge, 1 - point.at
        case int():
            return point
    with naming(place):
        return _nearest(point, surface)


def _nearest(point: Point, surface: Surface) -> tuple[int, Floats]:
    """Face of the surface, and a weight for each of its corners, nearest to a point."""
    number = Attributes(face={"face": np.arange(surface.face_count)})
    numbered = PolygonMesh(
        (surface.vertices), (surface.indices, surface.offsets), attributes=number
    )
    triangles = numbered.triangulated()
    places, _ = ClosestPoints(triangles).query([point])
    triangle = int(places.face[0])
    face = int(triangles.attributes.face["face"][triangle])
    corners = surface.indices[surface.offsets[face] : surface.offsets[face + 1]]
    weights = np.zeros(len(corners))
    for vertex, weight in zip(triangles.faces[triangle], places.barycentric[0], strict=True):
        weights[np.flatnonzero(corners == vertex)[0]] += weight
    return face, weights


def _move(handle: Handle, move: recipes.Move) -> None:
    """Pose a handle, which turns and scales about its centroid, about any point."""
    degrees = move.rotation
    if isinstance(degrees, recipes.Turn):
        axis = np.array(degrees.axis) / np.abs(degrees.axis).max()
        degrees_vector = degrees.angle * axis / np.linalg.norm(axis)
    else:
        degrees_vector = np.array(degrees)
    rotation = np.radians(degrees_vector)
    translation = np.array(move.translation)
    if move.about is not None:
        arm = handle.centre - move.about
        turned = matrices_from_vectors(rotation[None])[0] @ arm
        translation = translation + move.scale * turned - arm
    handle.move(translation=translation, rotation=rotation, scale=move.scale)
