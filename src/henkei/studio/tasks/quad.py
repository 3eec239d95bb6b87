"""Quads of a surface, and what the page draws of them: lines, shapes, patches."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.element_quality import element_quality
from henkei.mesh import PolygonMesh
from henkei.progress import part
from henkei.quad import QuadResult
from henkei.quad.painting import patch_colors
from henkei.studio.drawables import drawable, ends_of
from henkei.studio.tasks.read_file import about
from henkei.workflows.quad_by_recipe import cage_by_recipe, quad_by_recipe
from henkei.workflows.quad_picture import FEWER, MORE, OTHER, irregular_marks

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.worker import Report

KINDS = (FEWER, MORE, OTHER)
"""Of irregular vertices."""


def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Make quads of a ``surface`` as a ``recipe`` says.

    Returns blobs: the ``result``; its mesh as a ``surface``, and what that is ``about``; what is
    drawn of it, ``quads`` with creases and boundaries as lines, and ``details``, see
    :func:`details`. Also its ``quality``; how many were ``wished``; how many vertices of each of
    the :data:`KINDS` are ``irregular``; and of the request ``mesh`` and ``of``.

    Raises
    ------
    HenkeiError : as :func:`henkei.quadrangulate`.
    """
    making = part(report.progress, 0.0, 0.95)
    surface = blobs.surface(request["surface"])
    result = quad_by_recipe(surface, request["recipe"], progress=making)
    report.progress("keeping them", 0.95)
    header, arrays = drawable(result.mesh)
    shown = details(result)
    arrays["creases"] = result.features.astype(np.uint32)
    return {
        "result": blobs.put_result(result),
        "surface": blobs.put_surface(result.mesh),
        "about": about(result.mesh),
        "quads": blobs.put_message(header, **arrays),
        "details": blobs.put_message({"kind": "details"}, **shown),
        "quality": asdict(replace(result.quality, seconds={})),
        "wished": request["recipe"].get("quads"),
        "irregular": np.bincount(shown["kind"], minlength=len(KINDS)).tolist(),
        "mesh": request["mesh"],
        "of": request["of"],
    }


def details(result: QuadResult) -> dict[str, NDArray[Any]]:
    """What quads can be coloured and marked by.

    Returns
    -------
    ``shape`` (q,) scaled Jacobian and ``patch`` (q, 3) colour of each quad; ``arcs`` (k, 2) edges
    where patches meet; ``irregular`` (i,) vertices, and the ``kind`` (i,) of each, an index among
    the :data:`KINDS`.
    """
    mesh = result.mesh
    found = irregular_marks(mesh)
    marks = [found[kind] for kind in KINDS]
    colours = np.round(255 * patch_colors(result.layout)).astype(np.uint8)
    return {
        "shape": element_quality(mesh).scaled_jacobian.astype(np.float32),
        "patch": colours[result.patches],
        "arcs": _arcs(mesh, result.patches),
        "irregular": np.concatenate(marks).astype(np.uint32),
        "kind": np.repeat(np.arange(len(marks)), [len(of) for of in marks]).astype(np.uint8),
    }


def _arcs(mesh: PolygonMesh, patches: NDArray[np.integer]) -> NDArray[np.uint32]:
    """Edges (k, 2) with other patches on both sides, and those of the boundary."""
    topology = mesh.topology
    twin, own = topology.twin, patches[topology.face]
    first = twin < np.arange(len(twin))
    meets = first & ((twin < 0) | (own != own[twin]))
    return ends_of(topology, np.flatnonzero(meets))


def cage(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Make a cage of few quads for a ``surface``, with what a ``recipe`` says of all but size.

    Returns the blob of the cage's ``surface``, and what that is ``about``; what is drawn of it,
    ``cage``; how many ``vertices`` and ``faces`` it has; and the ``mesh`` of the request.

    Raises
    ------
    HenkeiError : as :func:`henkei.quad.cage.quad_cage`.
    """
    surface = blobs.surface(request["surface"])
    made = cage_by_recipe(surface, request["recipe"], progress=report.progress)
    bare = PolygonMesh(made.vertices, made.faces)
    header, arrays = drawable(made)
    sharp = ends_of(made.topology, np.flatnonzero(made.attributes.corner["crease"]))
    arrays["creases"] = np.unique(np.sort(sharp, axis=1), axis=0)
    return {
        "surface": blobs.put_surface(bare),
        "about": about(bare),
        "cage": blobs.put_message(header, **arrays),
        "vertices": len(made.vertices),
        "faces": made.face_count,
        "mesh": request["mesh"],
    }
