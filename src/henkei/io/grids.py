"""Models through ``meshio``: VTK (.vtu), Gmsh (.msh), Medit (.mesh) and others; and .vtk."""

from __future__ import annotations

import re
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile, InvalidInput, some
from henkei.io import vtk_grid
from henkei.io.cells import KINDS
from henkei.io.meshio_calls import library, quiet, reason
from henkei.io.model import SET, Block, Groups, Model, Rows, Source, build
from henkei.mesh import Floats

WRITTEN = {".vtu": "vtu", ".vtk": "", ".msh": "gmsh", ".mesh": "medit"}
PROPERTIES = ("gmsh:physical", "medit:ref", "su2:tag", "avsucd:material", "property")
GMSH = re.compile(rb"\$MeshFormat\s+(\d+)\.(\d+)\s+([01])")
Arrays = dict[str, NDArray[Any]]


def read(path: Path, data: bytes) -> Model:
    """The model of a file that meshio reads, with its arrays of numbers.

    Raises
    ------
    InvalidFile : damaged, or no shells and solids.
    MissingDependency : meshio is not installed.
    """
    mesh = _legacy(path, data) if path.suffix.lower() == ".vtk" else _mesh(path)
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InvalidFile(f"{path}: coordinates of shape {points.shape}")
    nodes = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    kept = [i for i, block in enumerate(mesh.cells) if block.type in (*KINDS, "polygon")]
    values = _element_values(mesh, kept)
    blocks, position = [], 0
    for i in kept:
        for kind, table in _tables(path, mesh.cells[i], len(nodes)):
            ids = position + np.arange(len(table)) + 1
            blocks.append(Block(kind, kind, table, ids, _part(values, ids - 1)))
            position += len(table)
    unread: dict[str, int] = {}
    for block in mesh.cells:
        if block.type not in (*KINDS, "polygon"):
            unread[block.type] = unread.get(block.type, 0) + len(block.data)
    node_values = _numbers(mesh.point_data, len(nodes))
    if path.suffix.lower() == ".msh":
        node_values.pop("gmsh:dim_tags", None)
    groups = Groups(
        {**_from_masks(node_values), **_node_sets(mesh, len(nodes))},
        {**_from_masks(values), **_element_sets(mesh, kept)},
    )
    return build(
        Source(path, "meshio", (mesh, data[:200])),
        nodes,
        np.arange(1, len(nodes) + 1),
        blocks,
        groups,
        unread=unread,
        node_values=node_values,
        element_values=values,
    )


def _mesh(path: Path) -> Any:
    meshio = library()
    with quiet() as printed:
        try:
            return meshio.read(path)
        except (Exception, SystemExit) as error:  # meshio ends the process where it knows no way
            raise InvalidFile(f"{path}: damaged, {reason(error, printed)}") from error


def _legacy(path: Path, data: bytes) -> Any:
    """A legacy VTK file; meshio reads few of its forms."""
    points, blocks, vertex, face = vtk_grid.decode(path, data)
    ends = np.cumsum([len(table) for _, table in blocks])
    try:
        return library().Mesh(
            points,
            blocks,
            point_data={n: v for n, v in vertex.items() if len(v) == len(points)},
            cell_data={n: np.split(v, ends[:-1]) for n, v in face.items() if len(v) == ends[-1]},
        )
    except ValueError as error:
        raise InvalidFile(f"{path}: damaged ({error})") from error


def _tables(path: Path, block: Any, count: int) -> Iterator[tuple[str, Rows]]:
    """The nodes of a block's elements; polygons with as many corners as the first few have."""
    try:
        table = np.asarray(block.data, dtype=np.int64)
    except ValueError:
        for row in block.data:
            yield from _checked(path, "polygon", np.asarray([row], dtype=np.int64), count)
        return
    yield from _checked(path, block.type, table, count)


def _checked(path: Path, kind: str, table: Rows, count: int) -> Iterator[tuple[str, Rows]]:
    bad = np.flatnonzero(((table < 0) | (table >= count)).any(axis=1))
    if len(bad):
        raise InvalidFile(
            f"{path}: {kind} {bad[0]} names a vertex that does not exist; there are {count}"
        )
    if kind != "polygon" and table.shape[1] != KINDS[kind].size:
        raise InvalidFile(f"{path}: {kind} of {table.shape[1]} nodes")
    yield kind, table


def _element_values(mesh: Any, kept: list[int]) -> Arrays:
    """Arrays of numbers by element, of the blocks that are read."""
    total = sum(len(mesh.cells[i].data) for i in kept)
    joined = {
        name: np.concatenate([np.asarray(blocks[i]) for i in kept]) if kept else np.empty(0)
        for name, blocks in mesh.cell_data.items()
    }
    values = _numbers(joined, total)
    for name in PROPERTIES:
        if name in values and values[name].dtype.kind in "iu" and values[name].ndim == 1:
            values.setdefault("property", values[name].astype(np.int64))
    return values


def _part(values: Arrays, rows: Rows) -> Rows:
    given = values.get("property")
    if given is None or given.dtype.kind not in "iu" or given.ndim != 1:
        return np.zeros(len(rows), dtype=np.int64)
    return given[rows].astype(np.int64)


def _numbers(arrays: Mapping[str, Any], rows: int) -> Arrays:
    given = {name: np.asarray(values) for name, values in arrays.items()}
    return {n: v for n, v in given.items() if v.dtype.kind in "iuf" and len(v) == rows}


def _from_masks(values: Arrays) -> dict[str, Rows]:
    """Sets that are arrays called ``set NAME``; they are taken out of the arrays."""
    names = [n for n, v in values.items() if n.startswith(SET) and v.ndim == 1]
    return {name.removeprefix(SET): np.flatnonzero(values.pop(name)) for name in names}


def _node_sets(mesh: Any, count: int) -> dict[str, Rows]:
    sets = {name: np.unique(np.asarray(rows, np.int64)) for name, rows in mesh.point_sets.items()}
    return {n: rows[(rows >= 0) & (rows < count)] for n, rows in sets.items()}


def _element_sets(mesh: Any, kept: list[int]) -> dict[str, Rows]:
    sizes = [len(mesh.cells[i].data) for i in kept]
    starts = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    found = {}
    for name, parts in mesh.cell_sets.items():
        if name.startswith("gmsh:") or len(parts) != len(mesh.cells):
            continue
        rows = [
            starts[k] + np.asarray(parts[i] if parts[i] is not None else [], dtype=np.int64)
            for k, i in enumerate(kept)
        ]
        found[name] = np.unique(np.concatenate([starts[:0], *rows]))
    return found


def encode(path: Path, model: Model, nodes: Floats) -> Iterator[bytes]:
    """A model as .vtu, .vtk, .msh or .mesh, through meshio.

    A model of the same format keeps all that meshio has read. Of others, numbers, properties and
    sets become the arrays ``node``, ``element``, ``property`` and ``set NAME``.
    """
    library()
    suffix = path.suffix.lower()
    if suffix not in WRITTEN:
        raise InvalidInput(f"{path}: {suffix} is read, not written; write .vtu instead")
    same = model.source.format == "meshio" and model.source.path.suffix.lower() == suffix
    mesh = _moved(path, model, nodes) if same else _made(path, model, nodes)
    if suffix == ".vtk":
        blocks = [(block.type, np.asarray(block.data)) for block in mesh.cells]
        face = {name: np.concatenate(values) for name, values in mesh.cell_data.items()}
        yield from vtk_grid.encode(np.asarray(mesh.points), blocks, mesh.point_data, face)
        return
    options, name = _options(suffix, model.source.content[1] if same else b""), WRITTEN[suffix]
    with tempfile.TemporaryDirectory() as folder, quiet() as printed:
        file = Path(folder) / f"model{suffix}"
        try:
            mesh.write(file, file_format=options.pop("file_format", name), **options)
        except (Exception, SystemExit) as error:
            raise InvalidInput(f"cannot write {path}: {reason(error, printed)}") from error
        data = file.read_bytes()
    yield data


def _options(suffix: str, start: bytes) -> dict[str, Any]:
    """Version and form of the file that was read."""
    found = GMSH.match(start.lstrip())
    if suffix == ".msh" and found:
        return {
            "file_format": "gmsh22" if found[1] == b"2" else "gmsh",
            "binary": found[3] == b"1",
        }
    if suffix == ".msh":
        return {"file_format": "gmsh22", "binary": False}
    return {}


def _moved(path: Path, model: Model, nodes: Floats) -> Any:
    """The mesh as it was read, with new points."""
    mesh = model.source.content[0].copy()
    flat = np.shape(mesh.points)[1] == 2
    if flat and (nodes[:, 2] != 0).any():
        warnings.warn("the file had two coordinates a point, now it has three", stacklevel=5)
    if "gmsh:dim_tags" in mesh.point_data and "gmsh:physical" not in mesh.cell_data:
        mesh.cell_data["gmsh:physical"] = [np.zeros(len(b.data), np.int32) for b in mesh.cells]
    mesh.points = nodes[:, :2].copy() if flat and not nodes[:, 2].any() else nodes.copy()
    return mesh


def _made(path: Path, model: Model, nodes: Floats) -> Any:
    """A mesh with the elements of a model, and what is known of them as arrays."""
    blocks = [block for block in model.blocks if len(block.ids)]
    holes = [block.name for block in blocks if (block.nodes < 0).any()]
    if holes:
        raise InvalidInput(
            f"cannot write {path}: elements of type {some(sorted(set(holes)))} lack mid-side nodes"
        )
    if model.unread:
        listed = some(sorted(model.unread))
        warnings.warn(f"elements of type {listed} are not written to {path}", stacklevel=5)
    total = sum(len(block.ids) for block in model.blocks)
    by_element = {
        "element": np.concatenate([block.ids for block in model.blocks]),
        "property": np.concatenate([block.properties for block in model.blocks]),
        **_masks(model.groups.elements, total),
    }
    by_node = {"node": model.node_ids.copy(), **_masks(model.groups.nodes, len(nodes))}
    if path.suffix.lower() in (".msh", ".mesh"):
        label = "gmsh:physical" if path.suffix.lower() == ".msh" else "medit:ref"
        by_element = {label: by_element["property"].astype(np.int32)}
        if label == "gmsh:physical":
            by_element["gmsh:geometrical"] = by_element[label]
        by_node = {}
        warnings.warn(f"{path} holds properties, but no numbers and no sets", stacklevel=5)
    ends = np.cumsum([len(block.ids) for block in blocks])[:-1]
    return library().Mesh(
        nodes.copy(),
        [(block.kind, block.nodes) for block in blocks],
        point_data=by_node,
        cell_data={name: np.split(values, ends) for name, values in by_element.items()},
    )


def _masks(sets: Mapping[str, Rows], count: int) -> Arrays:
    masks = {}
    for name, members in sets.items():
        mask = np.zeros(count, dtype=np.int8)
        mask[members] = 1
        masks[SET + name] = mask
    return masks
