"""Quadrangulation: the steps of Okabe and Sugihara (2009), in order."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import Infeasible
from henkei.geometry.distance import ClosestPoints
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh
from henkei.progress import Progress, part, silent
from henkei.quad.cleanup import Cleaned, cleaned
from henkei.quad.components import Quads, components, joined
from henkei.quad.features import Sharp, feature_half_edges
from henkei.quad.homeomorphy import require_homeomorphic
from henkei.quad.isolines import RawQuads
from henkei.quad.laying import field_layouts, prepared, shape_layouts
from henkei.quad.measuring import best_lengths, mapped
from henkei.quad.quality import QuadQuality, quad_quality
from henkei.quad.relaxation import relaxed, scaled_jacobians
from henkei.quad.result import QuadResult, quad_mesh
from henkei.quad.seam import Seam
from henkei.quad.simplification import simplified
from henkei.quad.sizing import Density
from henkei.quad.surfaces import Wound
from henkei.quad.symmetry import Half, Symmetry
from henkei.quad.timing import Clock
from henkei.quad.wishes import Way, Wish, checked_seed, ways

GOOD_COUNT, GOOD_SHAPE = 0.1, 0.9  # off the wished number; mean scaled Jacobian: no need to go on


def quadrangulate(
    mesh: Any,
    *,
    quads: int | None = None,
    edge_length: float | None = None,
    patches: int | None = None,
    layout: Way = "auto",
    sharp: Sharp = None,
    density: Density = None,
    symmetry: Symmetry = None,
    seed: int = 0,
    progress: Progress = silent,
) -> QuadResult:
    """A mesh of quadrilaterals only on the surface of a triangle mesh.

    The result has the topology of the input, whatever that is: genus, boundary loops, components
    and orientation. Every patch of the layout is mapped one to one onto a polygon, which is decided
    exactly, and the quads are cut out by the integer isolines of that map; then their vertices are
    moved along the surface for shape. Okabe, Sugihara: Improved quadrilateral mesh generation using
    temperature contours (2009).

    Parameters
    ----------
    mesh : triangles (polygons are split): manifold and orientable, open or closed, in any number of
        components, each of which gets its share.
    quads : wished number, met within a few percent where the surface allows; 2,000 by default.
    edge_length : wished length of their edges instead, in the unit of the mesh.
    layout : where the patches come from: ``"field"``, lines along a cross field, few irregular
        vertices; ``"vsa"``, variational shape approximation, the paper's own; ``"auto"``, the
        former, and the latter where it ends badly.
    patches : wished number of patches, for ``"vsa"``.
    sharp : which edges are kept as lines of quad edges: from how many degrees between their faces,
        or pairs of vertices (k, 2). By default the creases of designed parts are found. Boundaries
        are kept in any case, with their corners.
    density : relative number of quads per area at each vertex (n,), or ``"curvature"``.
    symmetry : ``"x"``, ``"y"``, ``"z"`` or (point, normal): the result is symmetric about that
        plane, to rounding.
    seed : for what is left to chance, in ``"vsa"`` and where bad quads are mended.
    progress : is told how far the work is; may raise to end it.

    Raises
    ------
    NotFinite, NotManifold, NotOriented, DegenerateFaces, InvalidMesh : the mesh is not fit.
    InvalidInput : an argument is not.
    Infeasible : the surface takes far more quads than were asked for, or is not symmetric.
    """
    seed, order = checked_seed(seed), ways(layout, patches)
    progress = _never_back(progress)
    wound = Wound.of(mesh)
    surface = wound.mesh
    wish = Wish.of(surface, quads, edge_length, density)
    clock = Clock()
    with clock("features"):
        feature = feature_half_edges(surface, sharp, wish.sizes)
    half = None if symmetry is None else Half.of(surface, symmetry)
    sizes = wish.sizes if half is None else half.pull(wish.sizes)
    lines = feature if half is None else half.carried(feature)
    parts = components(surface if half is None else half.mesh)
    made = []
    for number, one in enumerate(parts):
        task = _Task(
            mesh=one.mesh,
            feature=lines[(3 * one.faces[:, None] + np.arange(3)).ravel()],
            wish=replace(wish, sizes=sizes).within(one),
            patches=patches,
            seam=None if half is None else half.seam_of(one),
            seed=seed,
            clock=clock,
            progress=part(progress, number / len(parts), (number + 1) / len(parts)),
        )
        made.append(_best(task, order))
    whole = joined(parts, made) if half is None else half.doubled(parts, made, feature)
    wish.require_met(len(whole.faces))
    result = quad_mesh(whole.vertices, whole.faces, whole.patch, whole.uv)
    require_homeomorphic(result, surface)
    quality = _measured(result, whole, wound, half, clock)
    on_input = wound.on_given(whole.on_surface)
    return QuadResult(result, on_input, whole.features, whole.layout, quality)


def _measured(
    result: PolygonMesh, whole: Quads, wound: Wound, half: Half | None, clock: Clock
) -> QuadQuality:
    with clock("quality"):
        quality = quad_quality(
            result,
            wound.mesh,
            patches=int(whole.patch.max()) + 1,
            layout=whole.way,
            injective=whole.injective,
            turned_faces=int(wound.turned.sum()),
            asymmetry=0.0 if half is None else half.asymmetry,
            seconds={},
        )
    return replace(quality, seconds=dict(clock.seconds))


def _never_back(progress: Progress) -> Progress:
    """Stays where it is while a step is done again in another way."""
    reached = 0.0

    def report(message: str, fraction: float) -> None:
        nonlocal reached
        reached = max(reached, fraction)
        progress(message, reached)

    return report


@dataclass(frozen=True)
class _Task:
    """One component, and what is wished for it."""

    mesh: Mesh
    feature: NDArray[np.bool_]
    wish: Wish
    patches: int | None
    seam: Seam | None
    seed: int
    clock: Clock
    progress: Progress


def _best(task: _Task, order: list[tuple[str, float]]) -> Quads:
    """Quads by the first way that ends well, else by that which ends best; a finer mesh underneath
    is for what could not be laid out at all."""
    best: tuple[tuple[float, ...], Quads] | None = None
    failure: Infeasible | None = None
    for way, fineness in order:
        if best is not None and fineness != order[0][1]:
            break
        try:
            quads, bad = _quads(task, way, fineness)
        except Infeasible as error:
            failure = error
            continue
        off = abs(len(quads.faces) / task.wish.quads - 1)
        shape = float(scaled_jacobians(quads.vertices, quads.faces).mean())
        if not bad and off <= GOOD_COUNT and shape >= GOOD_SHAPE:
            return quads
        merit = (bad, max(off - GOOD_COUNT, 0.0) - shape)
        if best is None or merit < best[0]:
            best = merit, quads
    if best is None:
        assert failure is not None, "there is always a way"
        raise failure
    return best[1]


def _quads(task: _Task, way: str, fineness: float) -> tuple[Quads, int]:
    """Quads of one component, and how many of them are bad: inverted or turned over."""
    mesh, clock, progress = task.mesh, task.clock, task.progress
    with clock("remeshing"):
        ground = prepared(mesh, task.feature, task.wish, fineness, part(progress, 0.0, 0.1))
    within = part(progress, 0.1, 0.5)
    if way == "field":
        layouts = field_layouts(ground, clock, within)
    else:
        layouts = shape_layouts(ground, task.wish, task.patches, task.seed, clock, within)
    number = max(1, round(task.wish.quads))
    may_crowd = way == "field" and task.seam is None
    within = part(progress, 0.5, 0.6)
    lengths, asked = best_lengths(layouts, number, may_crowd, clock, within)
    maps, raw = mapped(lengths, asked, clock, part(progress, 0.6, 0.7))
    with clock("clean-up"):
        corner = np.isin(_as_rows(raw.vertices), _as_rows(ground.corners))
        clean = _tidied(raw, corner, task, number)
        if task.seam is not None:
            raw, clean = task.seam.mended(raw, clean, maps.mesh)
    with clock("relaxation"):
        rest = relaxed(
            clean.vertices,
            clean.quads,
            mesh,
            features=clean.features,
            feature_lines=np.stack([mesh.indices, mesh.topology.target], axis=1)[task.feature],
            fixed=clean.fixed,
            sizing=task.wish.sizes,
            seed=task.seed,
            progress=part(progress, 0.7, 1.0),
        )
    shape = scaled_jacobians(rest.vertices, clean.quads)
    uv, patch = maps.uv.reshape(-1, 2), maps.meta.face_patch
    quads = Quads(
        vertices=rest.vertices,
        faces=clean.quads,
        patch=raw.patch[clean.kept_quads],
        uv=raw.uv[clean.kept_quads],
        on_surface=rest.on_surface,
        features=clean.features.astype(np.int32),
        layout=Mesh(
            maps.mesh.vertices,
            maps.mesh.faces,
            attributes=Attributes(corner={"uv": uv}, face={"patch": patch}),
        ),
        way=way,
        injective=maps.injective,
    )
    return quads, int((shape <= 0).sum()) + len(rest.turned_over)


def _tidied(raw: RawQuads, corner: NDArray[np.bool_], task: _Task, number: int) -> Cleaned:
    """The quads with fewer irregular vertices, and with fewer quads where there are too many."""
    if len(raw.faces) <= (1 + GOOD_COUNT) * number or task.seam is not None:
        return cleaned(raw.vertices, raw.faces, features=raw.feature, fixed=corner)
    places, _ = ClosestPoints(task.mesh).query(raw.vertices)
    fewer = simplified(
        raw.vertices,
        raw.faces,
        sizes=places.pull(task.mesh, task.wish.sizes),
        target=number,
        features=raw.feature,
        fixed=corner,
    )
    clean = cleaned(fewer.vertices, fewer.quads, features=fewer.features, fixed=fewer.fixed)
    return replace(
        clean, kept=fewer.kept[clean.kept], kept_quads=fewer.kept_quads[clean.kept_quads]
    )


def _as_rows(points: Floats) -> NDArray[np.void]:
    """Points (k, 3) as one comparable value each."""
    return np.ascontiguousarray(points + 0.0).view([("", np.float64)] * 3).ravel()
