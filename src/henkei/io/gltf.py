"""glTF 2.0 (.glb and .gltf), read. Writing is in ``gltf_write``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.assemble import assemble
from henkei.io.gltf_buffers import Document, item
from henkei.mesh import Attributes, Floats, Surface

TRIANGLES, STRIP, FAN = 4, 5, 6
HARMLESS = re.compile(
    "KHR_(materials_|texture_|lights_|animation_|xmp|mesh_quantization).*|EXT_texture_.*"
)


def decode(path: Path, data: bytes) -> Surface:
    """The surface of a glTF file: all triangles of its scene as one mesh.

    Nodes' transforms are applied; primitives follow one after the other, with the face attribute
    ``material`` where they have different ones. ``NORMAL``, ``TEXCOORD_0`` (v turned to point up)
    and ``COLOR_0`` become the vertex attributes ``normal``, ``uv`` and ``color``. Points, lines,
    skins, morph targets and animations are left out. Vertices stay split as they are in the file.
    """
    document = Document.of(path, data)
    try:
        needed = [str(name) for name in document.json.get("extensionsRequired", [])]
        for name in needed:
            if not HARMLESS.fullmatch(name):
                raise InvalidFile(
                    f"{path}: it needs the glTF extension {name}, which is not read; "
                    "export it without compression"
                )
        parts = [
            part
            for mesh, transform in _instances(document)
            for primitive in item(document.json, "meshes", mesh)["primitives"]
            if (part := _Part(document, primitive, transform)).faces is not None
        ]
        return _joined(path, parts)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise InvalidFile(f"{path}: damaged glTF, {type(error).__name__}: {error}") from error


def _instances(document: Document) -> Iterator[tuple[int, Floats]]:
    """Every mesh of the scene with its transform to the world."""
    tree = document.json
    nodes = tree.get("nodes", [])
    if not nodes:
        yield from ((mesh, np.eye(4)) for mesh in range(len(tree.get("meshes", []))))
        return
    if tree.get("scenes"):
        roots = item(tree, "scenes", tree.get("scene", 0)).get("nodes", [])
    else:
        children = {child for node in nodes for child in node.get("children", [])}
        roots = [index for index in range(len(nodes)) if index not in children]
    stack = [(root, np.eye(4)) for root in reversed(roots)]
    seen = set()
    while stack:
        index, parent = stack.pop()
        if index in seen:
            raise InvalidFile(f"{document.path}: node {index} has two parents")
        seen.add(index)
        node = item(tree, "nodes", index)
        transform = parent @ _local(node)
        if "mesh" in node:
            yield node["mesh"], transform
        stack += [(child, transform) for child in reversed(node.get("children", []))]


def _local(node: dict[str, Any]) -> Floats:
    """A node's matrix."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    x, y, z, w = (float(value) for value in node.get("rotation", (0, 0, 0, 1)))
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix[:3, :3] = rotation * np.array(node.get("scale", (1, 1, 1)), dtype=np.float64)
    matrix[:3, 3] = np.array(node.get("translation", (0, 0, 0)), dtype=np.float64)
    return matrix


class _Part:
    """One primitive, in the world; ``faces`` is None for points and lines."""

    def __init__(self, document: Document, primitive: dict[str, Any], transform: Floats) -> None:
        self.faces: NDArray[np.int64] | None = None
        mode = primitive.get("mode", TRIANGLES)
        if mode not in (TRIANGLES, STRIP, FAN):
            return
        given = primitive["attributes"]
        self.material = int(primitive.get("material", -1))
        self.vertices = _vectors(document, given["POSITION"], 3)
        if "indices" in primitive:
            indices = document.accessor(primitive["indices"]).reshape(-1)
            if indices.dtype.kind != "u":
                raise InvalidFile(f"{document.path}: indices are {indices.dtype}, not unsigned")
        else:
            indices = np.arange(len(self.vertices))
        self.faces = _triangles(document.path, indices.astype(np.int64), mode)
        self.attributes: dict[str, Floats] = {}
        for name, key, widths in (
            ("normal", "NORMAL", (3,)),
            ("uv", "TEXCOORD_0", (2,)),
            ("color", "COLOR_0", (3, 4)),
        ):
            if key in given:
                self.attributes[name] = _vectors(document, given[key], *widths)
                if len(self.attributes[name]) != len(self.vertices):
                    raise InvalidFile(f"{document.path}: {key} and POSITION differ in length")
        if "uv" in self.attributes:
            self.attributes["uv"] = self.attributes["uv"] * (1, -1) + (0, 1)
        if not np.array_equal(transform, np.eye(4)):
            self._move(transform)

    def _move(self, transform: Floats) -> None:
        linear = transform[:3, :3]
        with np.errstate(all="ignore"):
            self.vertices = self.vertices @ linear.T + transform[:3, 3]
            if "normal" in self.attributes:
                cofactors = np.cross(np.roll(linear, -1, axis=0), np.roll(linear, 1, axis=0))
                normal = self.attributes["normal"] @ cofactors.T
                length = np.linalg.norm(normal, axis=1, keepdims=True)
                self.attributes["normal"] = normal / np.where(length > 0, length, 1)
        if np.linalg.det(linear) < 0:
            assert self.faces is not None
            self.faces = self.faces[:, ::-1]
            if "normal" in self.attributes:
                self.attributes["normal"] = -self.attributes["normal"]


def _vectors(document: Document, index: int, *widths: int) -> Floats:
    values = document.accessor(index)
    if values.shape[1] not in widths:
        raise InvalidFile(f"{document.path}: accessor {index} has {values.shape[1]} components")
    return values.astype(np.float64)


def _triangles(path: Path, indices: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    if mode == TRIANGLES:
        if len(indices) % 3:
            raise InvalidFile(f"{path}: {len(indices)} indices are not whole triangles")
        return indices.reshape(-1, 3)
    count = max(len(indices) - 2, 0)
    steps = np.arange(count)
    if mode == FAN:
        return np.stack([indices[1 : count + 1], indices[2:], np.repeat(indices[:1], count)], 1)
    odd = steps % 2
    return np.stack([indices[:count], indices[steps + 1 + odd], indices[steps + 2 - odd]], axis=1)


def _joined(path: Path, parts: list[_Part]) -> Surface:
    """All parts as one surface."""
    counts = [len(part.vertices) for part in parts]
    starts = np.cumsum([0, *counts])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=False)]
    for part in parts:
        assert part.faces is not None
        if part.faces.size and part.faces.max() >= len(part.vertices):
            raise InvalidFile(
                f"{path}: a face names vertex {part.faces.max()} (counted from 0) of a primitive "
                f"with {len(part.vertices)} vertices"
            )
    materials = np.repeat([part.material for part in parts], [len(part.faces) for part in parts])  # type: ignore[arg-type]
    several = len(np.unique(materials)) > 1
    joined = np.concatenate(faces) if faces else np.empty((0, 3), dtype=np.int64)
    return assemble(
        path,
        np.concatenate([part.vertices for part in parts]) if parts else np.empty((0, 3)),
        joined.reshape(-1),
        np.full(len(joined), 3, dtype=np.int64),
        Attributes(
            vertex=_shared(parts, counts),
            face={"material": materials.astype(np.int32)} if several else {},
        ),
    )


def _shared(parts: list[_Part], counts: list[int]) -> dict[str, Floats]:
    """Attributes of all parts; where a part has none, white for colours and NaN for the others."""
    shared = {}
    for name in ("normal", "uv", "color"):
        given = [part.attributes[name] for part in parts if name in part.attributes]
        if not given:
            continue
        width = max(values.shape[1] for values in given)
        table = np.full((sum(counts), width), 1.0 if name == "color" else np.nan)
        start = 0
        for part, count in zip(parts, counts, strict=True):
            if name in part.attributes:
                values = part.attributes[name]
                table[start : start + count, : values.shape[1]] = values
            start += count
        shared[name] = table
    return shared
