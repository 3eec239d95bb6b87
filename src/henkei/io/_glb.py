"""Building blocks of a glTF 2.0 file: arrays become accessors, the document becomes bytes.

Format: Khronos Group, "glTF 2.0 Specification", https://registry.khronos.org/glTF/specs/2.0/.
"""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.io.gltf_buffers import container

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
TRIANGLES = 4
COMPONENTS = {"u1": 5121, "u2": 5123, "u4": 5125, "f4": 5126}
SHAPES = {(): "SCALAR", (2,): "VEC2", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}
LIMIT = 2**32 - 2**20  # bytes of a binary file's arrays


class Builder:
    """A glTF document that grows: add arrays, fill ``content``, take the bytes.

    content : the JSON; ``accessors``, ``bufferViews`` and ``buffers`` are added at the end.
    """

    def __init__(self) -> None:
        self.content: dict[str, Any] = {"asset": {"version": "2.0", "generator": "henkei"}}
        self._accessors: list[dict[str, Any]] = []
        self._views: list[dict[str, Any]] = []
        self._blocks: list[bytes] = []
        self._length = 0

    def add(self, array: NDArray[Any], target: int | None = None, bounds: bool = False) -> int:
        """Number of the accessor of a new array, one row per element, in a view of its own.

        Parameters
        ----------
        array : (n, ...) of uint8, uint16, uint32 or float32; rows of 4 bytes or a multiple of it
            where ``target`` is ARRAY_BUFFER.
        target : ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER or none.
        bounds : whether to state the smallest and largest value of each component.
        """
        data = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
        view: dict[str, Any] = {"buffer": 0, "byteOffset": self._length, "byteLength": data.nbytes}
        if target is not None:
            view["target"] = target
        accessor: dict[str, Any] = {
            "bufferView": len(self._views),
            "componentType": COMPONENTS[data.dtype.str[1:]],
            "count": len(data),
            "type": SHAPES[data.shape[1:]],
        }
        if bounds:
            columns = data.reshape(len(data), -1).T
            accessor["min"] = [column.min().item() for column in columns]
            accessor["max"] = [column.max().item() for column in columns]
        self._views.append(view)
        self._accessors.append(accessor)
        self._append(data.tobytes())
        return len(self._accessors) - 1

    def add_triangles(self, faces: NDArray[Any], vertex_count: int) -> int:
        """Number of the accessor of triangle corners, in the smallest type that holds them."""
        small = vertex_count <= np.iinfo(np.uint16).max  # the largest value is reserved
        dtype = np.uint16 if small else np.uint32
        return self.add(faces.reshape(-1).astype(dtype), ELEMENT_ARRAY_BUFFER)

    def glb(self) -> bytes:
        """The binary file (.glb).

        Raises
        ------
        InvalidInput : more than 4 GiB.
        """
        if self._length > LIMIT:
            raise InvalidInput(
                f"a .glb file holds at most 4 GiB, this needs {self._length} bytes; "
                "write fewer faces, or frames as PLY"
            )
        return container(self._tree({"byteLength": self._length}), b"".join(self._blocks))

    def gltf(self) -> bytes:
        """The text file (.gltf) with the arrays inside."""
        data = base64.b64encode(b"".join(self._blocks)).decode("ascii")
        uri = f"data:application/octet-stream;base64,{data}"
        tree = self._tree({"byteLength": self._length, "uri": uri})
        return json.dumps(tree, separators=(",", ":")).encode("ascii")

    def _append(self, block: bytes) -> None:
        padded = block + bytes(-len(block) % 4)
        self._blocks.append(padded)
        self._length += len(padded)

    def _tree(self, buffer: dict[str, Any]) -> dict[str, Any]:
        return {
            **self.content,
            "accessors": self._accessors,
            "bufferViews": self._views,
            "buffers": [buffer],
        }
