"""glTF 2.0 (.glb and .gltf), written: one static mesh."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.io.assemble import displayable, float32, warn_of_dropped
from henkei.io.gltf_buffers import container
from henkei.io.unique import first_appearances
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh, Surface

FLOAT, UNSIGNED = 5126, 5125
FOR_VERTICES, FOR_INDICES = 34962, 34963
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def encode(path: Path, surface: Surface) -> Iterator[bytes]:
    """A .glb, or a .gltf with its data embedded, as ``path`` says.

    Positions become float32 (a warning says where that rounds), polygons triangles. Vertices are
    split where the ``uv`` or ``normal`` of their corners differ. Written: normals (those given,
    else the mean of the faces'), ``uv`` (v turned to point down) and ``color``, taken as linear.
    """
    mesh = surface.triangulated() if isinstance(surface, PolygonMesh) else surface
    assert isinstance(mesh, Mesh)
    warn_of_dropped(
        "glTF",
        surface.attributes,
        vertex={"normal", "uv", "color"},
        corner={"normal", "uv"},
    )
    mesh = with_split_seams(mesh)
    arrays = {"POSITION": float32(mesh.vertices, "glTF"), "NORMAL": _unit_normals(mesh)}
    vertex = mesh.attributes.vertex
    if "uv" in vertex:
        uv = np.nan_to_num(np.asarray(vertex["uv"][:, :2], dtype=np.float64))
        arrays["TEXCOORD_0"] = (uv * (1, -1) + (0, 1)).astype(np.float32)
    if "color" in vertex:
        arrays["COLOR_0"] = displayable(vertex["color"], "glTF").astype(np.float32)
    tree, binary = _document(arrays, mesh.faces.astype(np.uint32))
    if len(binary) >= 2**32 - 2**20:
        raise InvalidInput("glTF holds at most 4 GB; write PLY instead")
    if path.suffix.lower() == ".gltf":
        uri = "data:application/octet-stream;base64," + base64.b64encode(binary).decode("ascii")
        tree["buffers"][0]["uri"] = uri
        yield json.dumps(tree, indent=1).encode()
    else:
        yield container(tree, binary)


def with_split_seams(mesh: Mesh) -> Mesh:
    """The mesh with ``uv`` and ``normal`` of corners at vertices, copies made where they differ.

    A mesh without them is returned as it is; else vertices come in order of first appearance.
    """
    corner = {
        n: np.asarray(mesh.attributes.corner[n], dtype=np.float64)
        for n in ("uv", "normal")
        if n in mesh.attributes.corner
    }
    if not corner:
        return mesh
    keys = [mesh.indices[:, None].astype(np.int64)]
    keys += [np.ascontiguousarray(values).view(np.int64) for values in corner.values()]
    first, indices = first_appearances(np.hstack(keys))
    kept = mesh.indices[first]
    vertex = {name: values[kept] for name, values in mesh.attributes.vertex.items()}
    vertex |= {name: values[first] for name, values in corner.items()}
    faces = indices.reshape(-1, 3).astype(np.int32)
    return Mesh(mesh.vertices[kept], faces, attributes=Attributes(vertex=vertex))


def _unit_normals(mesh: Mesh) -> NDArray[np.float32]:
    """Given normals, else those of the faces around; never zero, as the format demands."""
    normals = mesh.vertex_normals.copy()
    given = mesh.attributes.vertex.get("normal")
    if given is not None:
        usable = np.isfinite(given).all(axis=1) & (given != 0).any(axis=1)
        normals[usable] = given[usable]
    normals[~normals.any(axis=1)] = (0.0, 0.0, 1.0)
    normals /= np.abs(normals).max(axis=1, keepdims=True)
    unit: Floats = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return unit.astype(np.float32)


def _document(
    arrays: dict[str, NDArray[np.float32]], faces: NDArray[np.uint32]
) -> tuple[dict[str, Any], bytes]:
    """The JSON of one mesh, and its buffer."""
    tables = [*arrays.values(), faces.reshape(-1, 1)]
    accessors: list[dict[str, Any]] = []
    views = []
    binary = b""
    for table in tables:
        is_faces = table.dtype == np.uint32
        data = table.tobytes()
        views.append(
            {
                "buffer": 0,
                "byteOffset": len(binary),
                "byteLength": len(data),
                "target": FOR_INDICES if is_faces else FOR_VERTICES,
            }
        )
        accessors.append(
            {
                "bufferView": len(accessors),
                "componentType": UNSIGNED if is_faces else FLOAT,
                "count": len(table),
                "type": TYPES[table.shape[1]],
            }
        )
        binary += data
    positions = arrays["POSITION"]
    accessors[0] |= {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
    tree = {
        "asset": {"version": "2.0", "generator": "henkei"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {name: i for i, name in enumerate(arrays)},
                        "indices": len(arrays),
                        "material": 0,
                    }
                ]
            }
        ],
        "materials": [{"doubleSided": True, "pbrMetallicRoughness": {"metallicFactor": 0}}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    return tree, binary
