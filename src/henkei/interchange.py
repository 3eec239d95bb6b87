"""Meshes from whatever a user holds: paths, arrays, objects of other libraries."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.io import read
from henkei.mesh import Attributes, Mesh, PolygonMesh, simplest

Arrays = dict[str, NDArray[Any]]


def surface_from(source: Any) -> Mesh | PolygonMesh:
    """A mesh with its faces as they are, from whatever :meth:`Mesh.from_any` takes.

    Of objects of other libraries, arrays per vertex and per face come along as attributes; of
    trimesh, vertex colours as ``color`` and texture coordinates as ``uv``.

    Raises
    ------
    InvalidInput : the source is none of these.
    """
    if isinstance(source, Mesh | PolygonMesh):
        return source
    if isinstance(source, str | os.PathLike):
        return read(source)
    if isinstance(source, tuple) and len(source) == 2:
        return _from_arrays(*source)
    kind = type(source).__module__.partition(".")[0]
    if kind == "trimesh" and hasattr(source, "faces"):
        return Mesh(source.vertices, source.faces, attributes=_trimesh_attributes(source))
    if kind == "pyvista" and hasattr(source, "GetPolys"):
        return _from_pyvista(source)
    if kind == "meshio" and hasattr(source, "cells"):
        return _from_meshio(source)
    raise InvalidInput(
        f"cannot make a mesh from {type(source).__name__}; give a path, (vertices, faces), "
        "or a mesh of henkei, trimesh, PyVista or meshio"
    )


def _from_arrays(vertices: Any, faces: Any) -> Mesh | PolygonMesh:
    if not isinstance(faces, tuple) and _is_ragged(faces):
        return PolygonMesh.from_faces(vertices, faces)
    if isinstance(faces, tuple) or (np.ndim(faces) == 2 and np.shape(faces)[1] != 3):
        return PolygonMesh(vertices, faces)
    return Mesh(vertices, faces)


def _is_ragged(faces: Any) -> bool:
    """Whether this is a list of faces of several sizes."""
    listed = isinstance(faces, list) and all(isinstance(face, Sequence) for face in faces)
    return listed and len({len(face) for face in faces}) > 1


def _trimesh_attributes(source: Any) -> Attributes:
    visual: Any = getattr(source, "visual", None)
    vertex: Arrays = {}
    if getattr(visual, "kind", None) == "vertex":
        vertex["color"] = np.asarray(visual.vertex_colors) / 255
    uv = getattr(visual, "uv", None)
    if uv is not None and len(uv) == len(source.vertices):
        vertex["uv"] = np.asarray(uv, dtype=np.float64)
    return Attributes(vertex=vertex)


def _from_pyvista(source: Any) -> Mesh | PolygonMesh:
    cells = source.GetPolys()
    indices = np.asarray(cells.GetConnectivityArray())
    offsets = np.asarray(cells.GetOffsetsArray())
    attributes = Attributes(
        vertex=_rows(source.point_data, len(source.points)),
        face=_rows(source.cell_data, len(offsets) - 1),
    )
    return simplest(PolygonMesh(source.points, (indices, offsets), attributes=attributes))


def _from_meshio(source: Any) -> Mesh | PolygonMesh:
    chosen = [i for i, b in enumerate(source.cells) if b.type in ("triangle", "quad", "polygon")]
    faces = [list(face) for i in chosen for face in source.cells[i].data]
    face = {
        name: np.concatenate([np.asarray(blocks[i]) for i in chosen])
        for name, blocks in source.cell_data.items()
        if chosen
    }
    vertex = _rows(source.point_data, len(source.points))
    attributes = Attributes(vertex=vertex, face=_rows(face, len(faces)))
    return simplest(PolygonMesh.from_faces(source.points, faces, attributes))


def _rows(arrays: Mapping[str, Any], count: int) -> Arrays:
    """Arrays with one row for each, by name."""
    tables = {name: np.asarray(values) for name, values in arrays.items()}
    return {name: values for name, values in tables.items() if len(values) == count}
