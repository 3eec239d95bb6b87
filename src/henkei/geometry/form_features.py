"""Form features, found for the user: holes, rims, bosses, character lines, planar pads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput, InvalidMesh
from henkei.geometry.circles import (
    ROUND,
    Circle,
    across,
    fitted_circle,
    nearest_circle,
)
from henkei.geometry.creases import CORNER, Chain, Folds, chains
from henkei.geometry.cylindrical_walls import Wall, cylindrical_walls
from henkei.geometry.form_feature import (
    NO_FACES,
    Boss,
    Bottom,
    FormFeature,
    FormFeatures,
    Hole,
    Line,
    Pad,
    Rim,
    Ring,
)
from henkei.geometry.outlines import outlines
from henkei.geometry.planar_regions import FLATNESS, planar_regions, without_facets
from henkei.geometry.requirements import loop_lengths, measurable, require_finite
from henkei.interchange import surface_from
from henkei.mesh import Floats, Surface
from henkei.topology import BOUNDARY

__all__ = [
    "Boss",
    "Circle",
    "FormFeature",
    "FormFeatures",
    "Hole",
    "Line",
    "Pad",
    "Rim",
    "find_features",
    "fitted_circle",
]

ANGLE = 30.0
SHORTEST = 0.03  # line, by the diagonal
SMALLEST = 0.005  # pad, by the area of the surface
_LEAST_TRIANGLES = 4  # of a pad
_STRAIGHT = 5e-4  # part of its size by which a straight line may leave its chord

_Kind = TypeVar("_Kind", bound=FormFeature)


def find_features(
    surface: Any,
    *,
    angle: float = ANGLE,
    corner: float = CORNER,
    roundness: float = ROUND,
    flatness: float = FLATNESS,
    shortest: float = SHORTEST,
    smallest: float = SMALLEST,
) -> FormFeatures:
    """The form features of a surface.

    Holes and rims of sheets are boundary loops; which one is the outline is told by how it turns
    (:func:`henkei.geometry.outlines.outlines`). Holes and bosses of solids are walls that stand
    along an axis all around it, between sharp edges. Lines are chains of sharp edges, but for those
    around such walls. Pads are planar, and not the facets of something round. All are found by
    geometry alone, and nothing is random.

    Parameters
    ----------
    surface : a mesh, or whatever :meth:`henkei.Mesh.from_any` takes. Polygons stay whole.
    angle : degrees between two faces from which on their edge is sharp; more than 0, up to 180.
    corner : degrees by which a line may turn at a vertex before it ends.
    roundness : part of its radius by which a round hole may leave its circle.
    flatness : part of its size by which a pad may leave its plane.
    shortest : length of the shortest line, as a fraction of the diagonal.
    smallest : area of the smallest pad, as a fraction of the surface's.

    Raises
    ------
    InvalidInput : a setting is out of range.
    InvalidMesh : there are no faces, or the coordinates are extreme; NotFinite for NaN or infinity.
    """
    _check_settings(angle, corner, roundness, flatness, shortest, smallest)
    mesh = surface_from(surface)
    _require_surface(mesh)
    folds = Folds(mesh)
    walls = [
        wall
        for wall in cylindrical_walls(folds, roundness)
        if wall.inward or wall.circle is not None
    ]
    rims, holes = _loops(mesh, roundness)
    holes += [_hole(folds, wall, walls) for wall in walls if wall.inward]
    bosses = [_boss(folds, wall) for wall in walls if not wall.inward]
    return FormFeatures(
        _numbered(rims, _extent),
        _numbered(holes, _extent),
        _numbered(bosses, _extent),
        _numbered(_lines(folds, walls, angle, corner, shortest), lambda line: line.length),
        _numbered(_pads(folds, walls, angle, flatness, smallest), lambda pad: pad.area),
    )


def _check_settings(angle: float, corner: float, *fractions: float) -> None:
    for name, degrees in (("angle", angle), ("corner", corner)):
        if not 0 < degrees <= 180:
            raise InvalidInput(f"{name} must be more than 0 and at most 180 degrees, not {degrees}")
    for name, share in zip(
        ("roundness", "flatness", "shortest", "smallest"), fractions, strict=True
    ):
        if not 0 <= share < 1:
            raise InvalidInput(f"{name} is a fraction, at least 0 and less than 1, not {share}")


def _require_surface(mesh: Surface) -> None:
    if not mesh.face_count:
        raise InvalidMesh("the mesh has no faces, so it has no features; give a surface mesh")
    require_finite(mesh)
    problem = measurable(mesh)
    if problem:
        raise problem.error()


def _loops(mesh: Surface, roundness: float) -> tuple[list[Rim], list[Hole]]:
    loops = mesh.topology.boundary_loops
    rims, holes = [], []
    lengths = loop_lengths(mesh, loops)
    for loop, outline, closed, length in zip(
        loops, outlines(mesh), _closed(mesh), lengths, strict=True
    ):
        if not (closed and length > 0):
            continue
        vertices = np.roll(loop, -int(loop.argmin())).astype(np.int64)
        points = mesh.vertices[vertices]
        circle = nearest_circle(points)
        full = circle is not None and circle.is_full(points, roundness)
        axis = circle.axis if circle and full else _facing(points)
        common: dict[str, Any] = {
            "number": 0,
            "vertices": vertices,
            "faces": NO_FACES,
            "centre": circle.centre if circle and full else points.mean(axis=0),
            "length": length,
            "size": _rectangle(points, axis),
            "axis": axis,
            "circle": circle if full else None,
        }
        if outline:
            rims.append(Rim(**common))
        else:
            holes.append(Hole(**common, depth=0.0, bottom="through"))
    return rims, holes


def _closed(mesh: Surface) -> NDArray[np.bool_]:
    """Of each boundary loop, whether it comes back to where it starts and goes around something.

    Some end at an edge with more than two faces.
    """
    topology, count = mesh.topology, len(mesh.vertices)
    border = np.flatnonzero(topology.twin == BOUNDARY)
    borders = np.stack([topology.indices[border], topology.target[border]], axis=1)
    last = np.array([loop[[-1, 0]] for loop in topology.boundary_loops]).reshape(-1, 2)
    known, closing = (np.sort(edges).astype(np.int64) @ [count, 1] for edges in (borders, last))
    long = np.array([len(loop) > 2 for loop in topology.boundary_loops], dtype=bool)
    return np.asarray(long & np.isin(closing, known))


def _facing(points: Floats) -> Floats:
    """The direction (3,) in which a closed polygon (k, 3) is seen largest."""
    offsets = points - points.mean(axis=0)
    area = np.cross(offsets, np.roll(offsets, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(area))
    if size <= 1e-9 * float((offsets**2).sum()):
        area, size = np.linalg.svd(offsets)[2][-1], 1.0
    axis: Floats = area / size
    return axis if axis[np.abs(axis).argmax()] > 0 else -axis


def _ring(folds: Folds, wall: Wall) -> dict[str, Any]:
    points = folds.surface.vertices[wall.vertices]
    return {
        "number": 0,
        "vertices": wall.vertices,
        "faces": wall.faces,
        "centre": wall.circle.centre if wall.circle else points.mean(axis=0),
        "length": float(folds.areas[wall.faces].sum()) / wall.height,
        "size": _rectangle(points, wall.axis),
        "axis": wall.axis,
        "circle": wall.circle,
    }


def _hole(folds: Folds, wall: Wall, walls: Sequence[Wall]) -> Hole:
    bottom: Bottom = "through"
    if wall.closed_ends:
        stepped = any(_steps(folds.surface.vertices, wall, other) for other in walls)
        bottom = "stepped" if stepped else "blind"
    return Hole(**_ring(folds, wall), depth=wall.height, bottom=bottom)


def _boss(folds: Folds, wall: Wall) -> Boss:
    return Boss(**_ring(folds, wall), height=wall.height)


def _steps(vertices: Floats, wall: Wall, other: Wall) -> bool:
    """Whether a hole goes on, narrower, as another one about the same axis."""
    if not (wall.circle and other.circle and other.inward):
        return False
    if other.circle.radius >= wall.circle.radius or abs(wall.axis @ other.axis) < 0.999:
        return False
    between = other.circle.centre - wall.circle.centre
    aside = between - (between @ wall.axis) * wall.axis
    if np.linalg.norm(aside) > ROUND * other.circle.radius:
        return False
    a, b = (vertices[w.vertices] @ wall.axis for w in (wall, other))
    apart = max(a.min() - b.max(), b.min() - a.max())
    return bool(apart <= wall.circle.radius)


def _lines(
    folds: Folds, walls: Sequence[Wall], angle: float, corner: float, shortest: float
) -> list[Line]:
    surface, topology = folds.surface, folds.surface.topology
    on_wall = np.full(len(surface.vertices), -1)
    for number, wall in enumerate(walls):
        on_wall[wall.vertices] = number
    sharp = folds.sharp(angle)
    edges = np.stack([topology.indices[sharp], topology.target[sharp]], axis=1)
    keys = np.sort(edges, axis=1).astype(np.int64) @ [len(surface.vertices), 1]
    order = np.argsort(keys)
    lines = []
    for chain in chains(edges, surface.vertices, corner):
        own = on_wall[chain.vertices]
        length = chain.length(surface.vertices)
        if length < shortest * surface.diagonal or (own[0] >= 0 and (own == own[0]).all()):
            continue
        at = np.sort(chain.edges, axis=1) @ [len(surface.vertices), 1]
        folded = folds.angles[sharp[order[np.searchsorted(keys[order], at)]]]
        lines.append(_line(surface.vertices, chain, length, folded))
    return lines


def _line(vertices: Floats, chain: Chain, length: float, folded: Floats) -> Line:
    points = vertices[chain.vertices]
    start, end = vertices[chain.edges.T]
    weights = np.linalg.norm(end - start, axis=1)
    return Line(
        number=0,
        vertices=chain.vertices,
        faces=NO_FACES,
        centre=points.mean(axis=0),
        length=length,
        angle=float(np.average(folded, weights=weights)),
        closed=chain.closed,
        straight=not chain.closed and _is_straight(points),
    )


def _is_straight(points: Floats) -> bool:
    offsets = points - points.mean(axis=0)
    along = np.linalg.svd(offsets, full_matrices=False)[2][0]
    beside = offsets - np.outer(offsets @ along, along)
    size = np.abs(offsets @ along).max()
    return bool(np.linalg.norm(beside, axis=1).max() <= _STRAIGHT * size)


def _pads(
    folds: Folds, walls: Sequence[Wall], angle: float, flatness: float, smallest: float
) -> list[Pad]:
    surface = folds.surface
    least = smallest * float(folds.areas.sum())
    planes = planar_regions(folds, flatness, least, _LEAST_TRIANGLES)
    kept = without_facets(folds, planes, angle)
    for wall in walls:
        kept[np.unique(planes.label[wall.faces][planes.label[wall.faces] >= 0])] = False
    pads = []
    for region in np.flatnonzero(kept):
        faces = np.flatnonzero(planes.label == region)
        vertices = np.unique(surface.indices[folds.corners(faces)[0]]).astype(np.int64)
        pads.append(
            Pad(
                number=0,
                vertices=vertices,
                centre=planes.centres[region],
                faces=faces,
                area=float(planes.areas[region]),
                size=_rectangle(surface.vertices[vertices], planes.normals[region]),
                normal=planes.normals[region],
                deviation=float(planes.deviations[region]),
            )
        )
    return pads


def _rectangle(points: Floats, axis: Floats) -> tuple[float, float]:
    """Length and width of the smallest rectangle around points, seen along an axis."""
    from scipy.spatial import ConvexHull, QhullError

    flat = (points - points.mean(axis=0)) @ across(axis).T
    try:
        hull = flat[ConvexHull(flat).vertices]
    except (QhullError, ValueError):  # all on a line, or fewer than three
        return 2 * float(np.linalg.norm(flat, axis=1).max()), 0.0
    sides = np.roll(hull, -1, axis=0) - hull
    along = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    turned = np.stack([along, np.stack([-along[:, 1], along[:, 0]], axis=1)])
    extents = np.ptp(hull @ turned.transpose(0, 2, 1), axis=1)
    best = extents[:, extents.prod(axis=0).argmin()]
    return float(best.max()), float(best.min())


def _extent(ring: Ring) -> float:
    return 2 * ring.circle.radius if ring.circle else ring.size[0]


def _numbered(features: Sequence[_Kind], size: Callable[[_Kind], float]) -> tuple[_Kind, ...]:
    """Largest first; those alike to six digits, in the order of their lowest vertices."""
    ordered = sorted(
        features, key=lambda feature: (-float(f"{size(feature):.6g}"), feature.vertices.min())
    )
    return tuple(replace(feature, number=n) for n, feature in enumerate(ordered, start=1))
