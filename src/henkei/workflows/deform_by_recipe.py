"""A mesh deformed as a recipe says."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from henkei.deform import Deformer, DeformQuality, Feature, Fixed, Handle, Pin, Settings
from henkei.errors import InvalidInput, some
from henkei.geometry.element_quality import ElementQuality, element_quality
from henkei.geometry.rotations import matrices_from_vectors
from henkei.interchange import surface_from
from henkei.mesh import Floats, Surface
from henkei.progress import Progress, part, silent
from henkei.recipes import deform as recipes
from henkei.recipes.deform import DeformRecipe
from henkei.recipes.recipe import LISTED, OnFace
from henkei.recipes.regions import Found
from henkei.workflows.deform_doubts import doubts, strains
from henkei.workflows.nearest_place import NearestPlace
from henkei.workflows.regions import Chosen, Regions, folder_of, naming, require_apart

NEAR = 0.01  # how far from the surface a point of it may be, as a fraction of its diagonal


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

    @cached_property
    def elements(self) -> ElementQuality:
        """Of the mesh at rest."""
        return element_quality(self.deformer.mesh)

    def prepare(self, recipe: DeformRecipe, progress: Progress = silent) -> None:
        """Factor the systems, for the recipe's method.

        Raises
        ------
        InvalidInput : nothing is fixed, or a connected piece of the surface is held by nothing.
        """
        if not any(held.weight is None for held in recipe.fixed):
            soft = " but softly" if recipe.fixed else ""
            raise InvalidInput(
                f'nothing is fixed{soft}; say what stays, as in "fixed": ["rim 1"] or '
                '"fixed": [{"box": [[null, null, null], [null, null, 0]]}]'
            )
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
                if kept.radius is not None:
                    feature.radius = kept.radius
        for pin, pinned in zip(self.pins, recipe.pins, strict=True):
            pin.move(pin.rest + pinned.move if pinned.to is None else pinned.to)


@dataclass(frozen=True, eq=False)
class Deformed:
    """A deformed mesh and how good it is.

    mesh : faces and attributes as given.
    elements : of this mesh.
    rotations : (n, 3, 3) of its vertices.
    largest_strain : change of the length of the edge that is stretched or squeezed most, as a
        fraction.
    radii : name -> at rest and now, of the circles whose radius is another.
    warnings : why not to trust it; none if all is well.
    seconds : that solving took, once all was prepared.
    """

    mesh: Surface
    quality: DeformQuality
    elements: ElementQuality
    rotations: Floats
    largest_strain: float
    radii: dict[str, tuple[float, float]]
    warnings: tuple[str, ...]
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
            "largest_strain": self.largest_strain,
        }


def staged(
    recipe: DeformRecipe,
    surface: Surface,
    *,
    folder: Path = Path(),
    regions: Regions | None = None,
) -> Staged:
    """A deformer that holds, moves and keeps what the recipe says, at rest and not yet prepared.

    Parameters
    ----------
    recipe : see :class:`henkei.recipes.deform.DeformRecipe`.
    surface : the mesh at rest.
    folder : that files which the recipe names are in.
    regions : of this surface, found as the recipe says, if they were made before.

    Raises
    ------
    HenkeiError : a region is empty or cannot be found on this surface, or as :class:`Deformer`; the
        message names the field of the recipe or the name of the part.
    """
    deformer = Deformer(surface, settings=Settings(**recipe.settings))
    regions = regions or Regions(surface, folder, recipe.finding.model_dump())
    found = {
        "fixed": [_one(*part, regions) for part in _parts(recipe, "fixed")],
        "features": [_named(*part, regions) for part in _parts(recipe, "features")],
        "handles": [_one(*part, regions) for part in _parts(recipe, "handles")],
    }
    everything = {kind: list(chain.from_iterable(several)) for kind, several in found.items()}
    require_apart(everything["fixed"], everything["features"] + everything["handles"])
    fixed = [deformer.fix(one.vertices, **one.options) for (one,) in found["fixed"]]
    features = [
        [deformer.feature(one.body, keep=kept.kept, **one.options) for one in several]
        for kept, several in zip(recipe.features, found["features"], strict=True)
    ]
    handles = [deformer.handle(one.vertices, **one.options) for (one,) in found["handles"]]
    pins = [
        deformer.pin(_point(pin.point, surface, place), weight=pin.weight, name=name)
        for pin, name, place in _parts(recipe, "pins")
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
    rest, mesh, quality = stage.deformer.mesh, stage.deformer.result, stage.deformer.quality
    elements, features = element_quality(mesh), stage.deformer.features
    return Deformed(
        mesh,
        quality,
        elements,
        stage.deformer.rotations,
        float(np.abs(strains(rest, mesh.vertices)).max(initial=0.0)),
        _new_radii(features),
        doubts(rest, mesh, quality, stage.elements, elements, features),
        seconds,
    )


def deform_by_recipe(
    mesh: Any, recipe: Any, *, folder: Path | None = None, progress: Progress = silent
) -> Deformed:
    """Deform a mesh as a recipe says.

    Parameters
    ----------
    mesh : as :class:`henkei.Deformer` takes it.
    recipe : a :class:`henkei.recipes.deform.DeformRecipe`, its data as a dictionary, or its file.
    folder : that files which the recipe names are in; by default that of the recipe's file.

    Raises
    ------
    InvalidInput : the recipe is given first.
    HenkeiError : as :meth:`henkei.DeformRecipe.read`, :func:`staged`, :meth:`Staged.prepare` and
        :func:`solved`.
    """
    if isinstance(mesh, DeformRecipe):
        raise InvalidInput("the mesh comes before the recipe: deform_by_recipe(mesh, recipe)")
    chosen = DeformRecipe.from_any(recipe)
    surface = surface_from(mesh)
    progress("finding regions", 0.0)
    stage = staged(chosen, surface, folder=folder_of(recipe) if folder is None else folder)
    stage.prepare(chosen, part(progress, 0.1, 0.8))
    progress("solving", 0.8)
    return solved(stage, chosen)


def _new_radii(features: Sequence[Feature]) -> dict[str, tuple[float, float]]:
    return {
        feature.name: (feature.rest_radius, feature.radius)
        for feature in features
        if feature.rest_radius and feature.radius and feature.radius != feature.rest_radius
    }


def _parts(recipe: DeformRecipe, kind: recipes.Kind) -> Iterator[tuple[Any, str, str]]:
    """Each part with its name, and where its region or point stands in the recipe."""
    field = "point" if kind == "pins" else "region"
    parts = zip(getattr(recipe, kind), recipe.names(kind), strict=True)
    for index, (one, name) in enumerate(parts):
        yield one, name, f"{kind}[{index}].{field}"


def _one(part: Any, name: str, place: str, regions: Regions) -> list[Chosen]:
    vertices = regions.vertices(part.region, place)
    found = regions.found(part.region.feature) if isinstance(part.region, Found) else []
    one = found[0] if len(found) == 1 else None
    return [Chosen(name, part.region, vertices, part.weight, one)]


def _named(kept: recipes.Feature, name: str, place: str, regions: Regions) -> list[Chosen]:
    """The features of an entry: of several by one name, each for itself."""
    if kept.name is not None or not isinstance(kept.region, Found):
        return _one(kept, name, place, regions)
    with naming(place):
        found = regions.found(kept.region.feature)
    return [
        Chosen(one.name, Found(feature=one.name), one.vertices, kept.weight, one) for one in found
    ]


def _relate(deformer: Deformer, recipe: DeformRecipe, features: Mapping[str, Feature]) -> None:
    """What the parts keep to each other: offsets and symmetry."""
    for index, (offset, name) in enumerate(
        zip(recipe.offsets, recipe.names("offsets"), strict=True)
    ):
        with naming(f"offsets[{index}].between"):
            for one in offset.between:
                if one not in features:
                    known = some(map(repr, features), LISTED)
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
        case OnFace():
            return point.face, np.array(point.barycentric)
        case recipes.OnEdge():
            return point.edge, 1 - point.at
        case int():
            return point
    with naming(place):
        return NearestPlace(surface, "the surface", NEAR).of(point)


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
