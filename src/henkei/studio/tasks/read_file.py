"""A mesh file of a stranger, read in a restricted worker."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.errors import HenkeiError, InvalidFile, InvalidInput, InvalidMesh
from henkei.geometry.requirements import measurable
from henkei.io import read
from henkei.io.gltf_buffers import Document
from henkei.mesh import Mesh, Surface
from henkei.topology import BOUNDARY, Topology

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.worker import Report

MOST_FACES = 20_000_000
FAULTS = (
    ("nonmanifold_edges", "edge of more than two faces", "edges of more than two faces"),
    ("nonmanifold_vertices", "vertex of more than one fan", "vertices of more than one fan"),
    ("degenerate_faces", "face that repeats a vertex", "faces that repeat a vertex"),
)
"""Tables of a topology with what is not manifold, and their words."""


def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Read the file at ``path``.

    ``alone`` tells that nothing beside the file may be read. Returns the blob of the ``surface``,
    how many ``vertices`` and ``faces`` it has, and what it is ``about`` in one line.

    Raises
    ------
    HenkeiError : as :func:`henkei.io.read`, and for what cannot be shown.
    """
    path = Path(request["path"])
    report.progress("reading", 0.0)
    if request["alone"]:
        _require_whole(path)
    surface = read(path)
    if surface.face_count > MOST_FACES:
        raise InvalidInput(
            f"{path}: {surface.face_count:,} faces are more than the {MOST_FACES:,} that can be "
            "shown; make it coarser first"
        )
    problem = measurable(surface)
    if problem is not None:
        raise InvalidMesh(f"{path}: {problem.reason}; {problem.remedy}")
    report.progress("looking at it", 0.6)
    described = about(surface)
    _warn_of_turned(surface, path.name)
    report.progress("keeping it", 0.8)
    return {
        "surface": blobs.put_surface(surface),
        "vertices": len(surface.vertices),
        "faces": surface.face_count,
        "about": described,
    }


def about(surface: Surface) -> str:
    """What a surface is, in a line: ``closed, genus 0, 1 piece``."""
    topology = surface.topology
    pieces = _count(topology.component_count, "piece", "pieces")
    corners = "" if isinstance(surface, Mesh) else _corners(surface)
    counts = [(len(getattr(topology, table)), one, many) for table, one, many in FAULTS]
    found = [_count(number, one, many) for number, one, many in counts if number]
    if found:
        return f"{corners}not manifold: {', '.join(found)}; {pieces}"
    if not topology.is_orientable:
        return f"{corners}one-sided, {pieces}"
    loops = _loops(topology)
    border = _count(loops, "boundary loop", "boundary loops") if loops else "closed"
    genus = (2 * topology.component_count - loops - _euler_characteristic(topology)) // 2
    turned = len(topology.misoriented_edges)
    along = _count(turned, "edge", "edges")
    note = f"; faces wind against each other along {along}" if turned else ""
    return f"{corners}{border}, genus {genus}, {pieces}{note}"


def _warn_of_turned(surface: Surface, name: str) -> None:
    topology = surface.topology
    turned = len(topology.misoriented_edges) if topology.is_orientable else 0
    if turned:
        along = _count(turned, "edge", "edges")
        warnings.warn(
            f"{name}: faces wind against each other along {along}, which is seen as patches of "
            "another colour; henkei.oriented(mesh) turns them alike",
            UserWarning,
            stacklevel=2,
        )


def _corners(surface: Surface) -> str:
    sizes = surface.offsets[1:] - surface.offsets[:-1]
    return "quads, " if (sizes == 4).all() else "polygons, "


def _euler_characteristic(topology: Topology) -> int:
    """V - E + F of a manifold surface, without a table of its edges."""
    used = topology.vertex_count - len(topology.unused_vertices)
    border = np.count_nonzero(topology.twin == BOUNDARY)
    edges = (len(topology.twin) + border) // 2
    return int(used - edges + len(topology.offsets) - 1)


def _loops(topology: Topology) -> int:
    """Number of boundary loops of a manifold surface: its border in pieces."""
    border = topology.twin == BOUNDARY
    start, end = topology.indices[border], topology.target[border]
    if not len(start):
        return 0
    count = topology.vertex_count
    graph = coo_array((np.ones(len(start), np.int8), (start, end)), shape=(count, count))
    inside = count - len(np.unique([start, end]))
    return int(connected_components(graph, directed=False)[0]) - inside


def _count(number: int, one: str, many: str) -> str:
    return f"{number:,} {one if number == 1 else many}"


def _require_whole(path: Path) -> None:
    """Refuse a glTF file that keeps its numbers in other files; damage is left to its reader."""
    if path.suffix.lower() not in (".gltf", ".glb"):
        return
    try:
        buffers = Document.of(path, path.read_bytes()).json.get("buffers", [])
        places = [buffer.get("uri", "data:") for buffer in buffers]
        others = [str(place) for place in places if not str(place).startswith("data:")]
    except (HenkeiError, OSError, AttributeError, TypeError):
        return
    if others:
        raise InvalidFile(
            f"{path}: its numbers are in another file, {others[0][:80]!r}, which did not come with "
            "it; save it as .glb, which has everything in one file"
        )
