"""What can be said of quads before they are made: lines that they will follow, sizes, symmetry."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.creases import Folds
from henkei.mesh import Floats, Surface
from henkei.quad.features import feature_half_edges
from henkei.quad.plane_cut import Plane
from henkei.quad.sizing import relative_sizes, sizes_for
from henkei.quad.surfaces import Wound
from henkei.quad.symmetry import Half
from henkei.quad.wishes import wished_quads
from henkei.recipes.quad import QuadRecipe
from henkei.recipes.recipe import Point
from henkei.studio.services import Services
from henkei.workflows.quad_by_recipe import density_of, sharp_of, symmetry_of

LEAST_FOLD = 5.0  # degrees, of the folds that a page can choose from
MANY_FACES = 400_000  # from which on little is said, to be quick


class Preview:
    """A surface, looked at for making quads of it.

    Raises
    ------
    InvalidMesh : no quads can be made of it.
    """

    def __init__(self, surface: Surface) -> None:
        wound = Wound.of(surface)
        self.surface = surface
        self.mesh = wound.mesh
        self.area = float(self.mesh.face_areas.sum())
        self.border = int((self.mesh.topology.twin < 0).sum())
        self.large = self.mesh.face_count > MANY_FACES

    @property
    def densities(self) -> list[str]:
        """Names of the vertex attributes that can be one."""
        found = self.surface.attributes.vertex.items()
        return [name for name, values in found if _is_density(values)]

    def quads(self, recipe: QuadRecipe) -> float:
        """How many quads a recipe asks for.

        Raises
        ------
        InvalidInput : more than can be made.
        """
        return wished_quads(self.area, recipe.quads, recipe.edge_length)

    def sizes(self, recipe: QuadRecipe) -> Floats:
        """Wished length (n,) of quads' edges at each vertex, in the unit of the mesh.

        The density must not be in a file.

        Raises
        ------
        InvalidInput : the density cannot be used, or more quads are wished than can be made.
        """
        density = density_of(recipe, self.surface, Path())
        relative = relative_sizes(self.mesh, density)
        return sizes_for(self.mesh, relative, self.quads(recipe))

    def lines(self, recipe: QuadRecipe) -> dict[str, NDArray[Any]]:
        """The ``edges`` (k, 2) that quads will follow; boundaries come first.

        Where the recipe says an angle, those of all that fold by more than a few degrees, the
        sharpest first, with their ``angles`` (k,); of boundaries 360.

        Raises
        ------
        InvalidInput : the recipe names edges that there are not.
        """
        if isinstance(recipe.sharp, float):
            return self._folded
        kept = feature_half_edges(self.mesh, sharp_of(recipe), self.sizes(recipe))
        twin = self.mesh.topology.twin
        first = np.flatnonzero(kept & (twin < np.arange(len(twin))))
        return {"edges": self._ends(first[np.argsort(twin[first] >= 0, kind="stable")])}

    @cached_property
    def _folded(self) -> dict[str, NDArray[Any]]:
        folds = Folds(self.mesh)
        border = np.flatnonzero(self.mesh.topology.twin < 0)
        sharp = folds.sharp(LEAST_FOLD)
        sharp = sharp[np.argsort(-folds.angles[sharp], kind="stable")]
        angles = np.concatenate([np.full(len(border), 360.0), folds.angles[sharp]])
        edges = self._ends(np.concatenate([border, sharp]))
        return {"edges": edges, "angles": angles.astype(np.float32)}

    def _ends(self, half_edges: NDArray[Any]) -> NDArray[np.uint32]:
        mesh = self.mesh
        ends = np.stack([mesh.indices[half_edges], mesh.topology.target[half_edges]], axis=1)
        return ends.astype(np.uint32)

    def plane(self, recipe: QuadRecipe) -> tuple[Point, Point]:
        """A point of the recipe's plane of symmetry, the nearest to the surface's middle, and the
        normal."""
        plane = Plane.of(self.mesh, symmetry_of(recipe))
        used = self.mesh.vertices[self.mesh.faces]
        middle = (used.min(axis=(0, 1)) + used.max(axis=(0, 1))) / 2
        x, y, z = plane.put(middle[None])[0].tolist()
        a, b, c = plane.normal.tolist()
        return (x, y, z), (a, b, c)

    def require_symmetric(self, recipe: QuadRecipe) -> None:
        """Refuse a plane about which the surface is not symmetric.

        Raises
        ------
        HenkeiError : it is not; the message says where.
        """
        Half.of(self.mesh, symmetry_of(recipe))


def preview_of(blob: str, services: Services) -> Preview:
    """That of a surface's blob, kept while it is looked at."""

    def make() -> Preview:
        services.progress("looking at the mesh", 0.0)
        return Preview(services.blobs.surface(blob))

    return services.engine("quad", blob, make)


def _is_density(values: NDArray[Any]) -> bool:
    if values.ndim != 1 or values.dtype.kind not in "iuf":
        return False
    return bool(np.isfinite(values).all() and (values > 0).all())
