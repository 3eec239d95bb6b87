"""Designed surfaces in files: what each format holds of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from henkei.errors import InvalidInput
from henkei.io import write
from henkei.io.meshio_calls import library
from henkei.io.others import DECKS, WRITTEN
from henkei.io.whole_folder import whole_folder
from henkei.mesh import Mesh, Surface
from henkei.recipes.design import DesignRecipe

TEXTURED = (".obj", ".ply", ".glb", ".gltf")
"""Endings of formats that have texture coordinates."""
SPLIT = (".glb", ".gltf", ".stl")
"""Endings of formats that hold triangles only."""
ENDINGS = (".obj", ".ply", ".off", ".stl", ".glb", ".gltf", ".vtk", ".vtp", *DECKS, *WRITTEN)

CAGE, RECIPE = "cage.obj", "recipe.json"
"""Names of what a person edits."""


def require_ending(path: Path, corners: int) -> None:
    """Refuse before the work what could not be written after it.

    Parameters
    ----------
    corners : of the largest face.

    Raises
    ------
    InvalidInput : the ending names no format for surfaces, or for faces of so many corners.
    MissingDependency : the format needs ``henkei[formats]``.
    """
    suffix = path.suffix.lower()
    if suffix == ".png":
        raise InvalidInput(f"{path}: a picture is asked for by --picture {path}")
    if suffix not in ENDINGS:
        raise InvalidInput(
            f"{path}: nothing is written under the ending {suffix!r}; known are "
            f"{', '.join(ENDINGS)}"
        )
    if suffix in WRITTEN:
        library()
    if corners > 4 and suffix in (*DECKS, *WRITTEN) and suffix != ".vtu":
        raise InvalidInput(
            f"{path}: {suffix} holds triangles and quads, the cage has faces with {corners} "
            "corners; write finer levels only, or .obj"
        )


def held(path: Path, surface: Surface) -> str:
    """What a file holds of a surface, in words."""
    suffix, attributes = path.suffix.lower(), surface.attributes
    sizes = np.diff(surface.offsets)
    split = suffix in SPLIT
    kind = "quad" if (sizes == 4).all() else "polygon"
    kind = "triangle" if split or isinstance(surface, Mesh) else kind
    count = int((sizes - 2).sum()) if split else surface.face_count
    faces = f"{count:,} {kind}{'s' if count > 1 else ''}"
    textured = suffix in TEXTURED and ("uv" in attributes.corner or "uv" in attributes.vertex)
    return f"{faces} with texture coordinates" if textured else faces


def write_example(folder: Path, cage: Surface, recipe: DesignRecipe) -> tuple[Path, Path]:
    """Write a cage and a recipe into a folder, to edit; it is made if it is not there.

    Raises
    ------
    InvalidInput : the folder has files of these names already, or cannot be written.
    """
    paths = folder / CAGE, folder / RECIPE
    for path in paths:
        if path.exists():
            raise InvalidInput(f"{path} is there already, maybe edited; name another folder")
    with whole_folder(folder) as place:
        write(place / CAGE, cage)
        recipe.write(place / RECIPE)
    return paths
