"""A surface registered onto another, and what the page shows of that: shapes, colours, figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from henkei.mesh import Floats, Mesh, Surface
from henkei.progress import part
from henkei.recipes.register import RegisterRecipe
from henkei.register import Registration
from henkei.studio.drawables import border_edges, frame_of, normalised, surface_header
from henkei.studio.morphs import MOST_TURNED, require_turnable, turning
from henkei.studio.register_view import placed
from henkei.studio.registered import apart, colours, figures, warnings
from henkei.workflows.register_by_recipe import register_by_recipe

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.worker import Report

LIVE = "model"  # what the page calls the source on its way


def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Register the surface ``source`` onto ``target`` as a ``recipe`` says.

    ``mediator`` is the blob of the surface whose file the recipe names, or None. While it goes on,
    the source is shown where it is then, in the frame of the target.

    Returns blobs: the ``result``; its ``shapes``, what is drawn of it; and, where the recipe's
    morph turns, the ``turning``; also ``colours``, ``figures``, ``warnings``, the vertices that are
    ``landmarks`` and the vertex of the target that is ``missed`` most; and of the request
    ``meshes`` and ``of``.

    Raises
    ------
    HenkeiError : as :func:`henkei.register`.
    """
    source, target = (blobs.surface(request[side]) for side in ("source", "target"))
    mediator = request["mediator"] and blobs.surface(request["mediator"])
    recipe = RegisterRecipe.of(request["recipe"])
    turns = recipe.morph.path == "rotation" and len(source.vertices) <= MOST_TURNED
    end = 0.7 if turns else 0.92
    frame = frame_of(target)

    def watch(points: Floats) -> None:
        if report.due:
            report.snapshot({"surface": LIVE}, positions=normalised(points, *frame))

    working = part(report.progress, 0.0, end)
    result = register_by_recipe(
        source, target, recipe, mediator=mediator, progress=working, watch=watch
    )
    report.progress("keeping it", end)
    onto = Mesh.from_any(target)
    unreached = apart(result, onto)
    way = turning(placed(result), frame, blobs, part(report.progress, end, 1.0)) if turns else None
    return {
        "result": blobs.put_result(result),
        "shapes": _shapes(result, source, frame, blobs),
        "turning": way,
        "colours": colours(result, onto, unreached, blobs),
        "figures": figures(result),
        "warnings": warnings(result),
        "landmarks": result.landmarks,
        "missed": int(np.nanargmax(unreached)),
        "meshes": request["meshes"],
        "of": request["of"],
    }


def turn(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Prepare the turning path of a ``result`` that is drawn as ``shapes``. Returns it and the
    blob, as ``turning``.

    Raises
    ------
    InvalidInput : it is too large to be held by a page.
    """
    result: Registration = blobs.result(request["result"])
    require_turnable(len(result.correspondence.vertices_a))
    header = blobs.get_message(request["shapes"]).header
    frame = np.array(header["centre"]), float(header["scale"])
    way = turning(placed(result), frame, blobs, report.progress)
    return {"result": request["result"], "turning": way}


def _shapes(
    result: Registration, source: Surface, frame: tuple[Floats, float], blobs: Blobs
) -> str:
    """What is drawn: a surface as pages take it, in the form of the target, with the source's own
    edges; ``start``, its positions in the form of the source; ``bridged``, its vertices that are in
    holes of the target."""
    mesh = result.mesh
    used = np.ones(len(mesh.vertices), dtype=bool)
    used[mesh.topology.unused_vertices] = False
    return blobs.put_message(
        surface_header(*frame, len(mesh.vertices), mesh.face_count),
        positions=normalised(mesh.vertices, *frame),
        start=normalised(placed(result).vertices_a, *frame),
        triangles=mesh.faces.astype(np.uint32),
        edges=source.topology.edges.astype(np.uint32),
        creases=border_edges(mesh.topology),
        bridged=np.flatnonzero(used & (result.on_target.face < 0)).astype(np.uint32),
    )
