"""Quads and their layout in files, with what each format has a place for."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from henkei.errors import InvalidInput
from henkei.io import write
from henkei.io.meshio_calls import library
from henkei.io.model import SET
from henkei.mesh import Attributes, Mesh, PolygonMesh, Values
from henkei.quad import QuadResult
from henkei.quad.painting import painted_layout

COORDINATES = (".obj", ".ply")
NUMBERS = (".ply", ".vtk", ".vtp", ".vtu")
BY_MESHIO = (".vtu", ".msh", ".mesh")
QUADS = {
    ".obj": "quads with texture coordinates, patches as groups",
    ".ply": "quads with texture coordinates and patches",
    **dict.fromkeys((".vtk", ".vtp", ".vtu"), "quads with patches"),
    ".off": "quads",
    ".inp": "quads as shells S4, patches as element sets",
    **dict.fromkeys((".bdf", ".nas", ".dat", ".fem"), "quads as shells CQUAD4"),
    **dict.fromkeys((".msh", ".mesh"), "quads"),
}
"""What a file of quads holds, by its ending."""

LAYOUTS = (".obj", ".ply", ".off", ".vtk", ".vtp", ".glb", ".gltf")
"""Endings of formats that have colours."""


def require_ending(path: Path, *, layout: bool = False) -> None:
    """Refuse before the work what could not be written after it.

    Raises
    ------
    InvalidInput : the ending names no format for quads, or for a coloured layout.
    MissingDependency : the format needs ``henkei[formats]``.
    """
    known = LAYOUTS if layout else tuple(QUADS)
    suffix = path.suffix.lower()
    if suffix not in known:
        what = "a coloured layout is" if layout else "quads are"
        raise InvalidInput(
            f"{path}: {what} not written under the ending {suffix!r}; known are {', '.join(known)}"
        )
    if suffix in BY_MESHIO:
        library()


def write_quads(path: Path, result: QuadResult) -> None:
    """Write the quads, with patches and texture coordinates as far as the format holds them.

    OBJ has patches as groups, Abaqus as element sets ``PATCH_n``; see :data:`QUADS`.
    """
    suffix = path.suffix.lower()
    corner = {"uv": result.mesh.attributes.corner["uv"]} if suffix in COORDINATES else {}
    attributes = Attributes(corner=corner, face=_patches(suffix, result))
    write(path, PolygonMesh(result.mesh.vertices, result.mesh.faces, attributes=attributes))


def write_layout(path: Path, result: QuadResult) -> None:
    """Write the layout as coloured triangles, see :func:`henkei.quad.painting.painted_layout`."""
    painted, suffix = painted_layout(result.layout), path.suffix.lower()
    patch = painted.attributes.face["patch"]
    face: Values = {"patch": patch} if suffix in NUMBERS else {}
    face = {"group": patch} if suffix == ".obj" else face
    attributes = Attributes(vertex=painted.attributes.vertex, face=face)
    write(path, Mesh(painted.vertices, painted.faces, attributes=attributes))


def _patches(suffix: str, result: QuadResult) -> Values:
    """The patches as attributes of faces that the format holds."""
    if suffix in NUMBERS:
        return {"patch": result.patches}
    if suffix == ".obj":
        return {"group": result.patches}
    if suffix == ".inp":
        numbers = np.unique(result.patches).tolist()
        return {f"{SET}PATCH_{n}": (result.patches == n).astype(np.int8) for n in numbers}
    return {}
