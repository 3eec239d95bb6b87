"""Regions of a surface chosen by where they lie: what a user may fix, move or keep.

Each function returns the indices of vertices that faces use, ascending, ``(k,)`` int64. What lies
exactly on a border belongs to the region. NumPy's set operations (``np.union1d``,
``np.setdiff1d``, ``np.intersect1d``) combine regions.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidInput, some
from henkei.geometry.arguments import is_number, numbers
from henkei.geometry.creases import CORNER, Chain, Folds, Indices, chains
from henkei.geometry.visibility import Camera, hidden
from henkei.interchange import surface_from
from henkei.mesh import Floats, Mesh, Surface

__all__ = [
    "Camera",
    "Chain",
    "boundary_loop",
    "grown",
    "in_box",
    "in_lasso",
    "in_sphere",
    "labelled",
    "near_line",
    "sharp_chain",
    "sharp_chains",
]


def in_box(surface: Any, lower: ArrayLike, upper: ArrayLike) -> Indices:
    """Vertices in a box along the axes.

    Parameters
    ----------
    lower, upper : (3,) its corners of smallest and largest coordinates; infinity for no bound.

    Raises
    ------
    InvalidInput : a bound is not three numbers, the lower one is above the upper, or no vertex is
        in the box.
    """
    mesh = surface_from(surface)
    low, high = (_triple(bound, "a corner of a box", infinite=True) for bound in (lower, upper))
    if (low > high).any():
        raise InvalidInput(f"the box's lower corner {low.tolist()} is above {high.tolist()}")
    inside = np.all((mesh.vertices >= low) & (mesh.vertices <= high), axis=1)
    return _used(mesh, inside, f"in the box from {low.tolist()} to {high.tolist()}")


def in_sphere(surface: Any, center: ArrayLike, radius: float) -> Indices:
    """Vertices within ``radius`` of a point.

    Raises
    ------
    InvalidInput : the centre is not three numbers, the radius negative, or no vertex is inside.
    """
    mesh = surface_from(surface)
    middle, reach = _triple(center, "the centre of a sphere"), _distance(radius, "a radius")
    inside = np.linalg.norm(mesh.vertices - middle, axis=1) <= reach
    return _used(mesh, inside, f"within {reach:g} of {middle.tolist()}")


def near_line(surface: Any, start: ArrayLike, end: ArrayLike, distance: float) -> Indices:
    """Vertices within ``distance`` of the straight line between two points, ends included.

    Raises
    ------
    InvalidInput : an end is not three numbers, the distance negative, or no vertex is near.
    """
    mesh = surface_from(surface)
    a, b = (_triple(point, "an end of a line") for point in (start, end))
    reach = _distance(distance, "a distance")
    inside = _from_segments(mesh.vertices, a[None], b[None])[:, 0] <= reach
    return _used(mesh, inside, f"within {reach:g} of the line {a.tolist()} - {b.tolist()}")


def boundary_loop(surface: Any, which: int | ArrayLike) -> Indices:
    """Vertices of one boundary loop.

    Parameters
    ----------
    which : the number of the loop, from 0, in the order of ``surface.topology.boundary_loops``
        (most vertices first, loops of equally many in the order of their first faces, so that
        moving vertices changes no number); or a point (3,), for the loop nearest to it.

    Raises
    ------
    InvalidInput : there is no boundary, or no loop of that number.
    """
    mesh = surface_from(surface)
    loops = [Chain(loop.astype(np.int64), True) for loop in mesh.topology.boundary_loops]
    if not loops:
        raise InvalidInput("the surface is closed, it has no boundary loop; choose another region")
    return np.unique(_chosen(mesh, loops, which, "boundary loop").vertices)


def sharp_chains(
    surface: Any, angle_degrees: float = 30.0, *, corner: float = CORNER
) -> list[Chain]:
    """Chains of edges at which the surface folds, such as a panel's character lines.

    Parameters
    ----------
    angle_degrees : between the two faces from which on an edge is sharp.
    corner : degrees by which a chain may turn at a vertex before it ends there.

    Returns
    -------
    Chains with their vertices in order, open or closed, as :func:`henkei.geometry.creases.chains`
    puts them: broken where other than two sharp edges meet, ordered by their lowest edges. A chain
    is a region, too: ``deformer.feature(chain)``.

    Raises
    ------
    InvalidInput : an angle is out of range, or no edge is sharp.
    """
    mesh = surface_from(surface)
    for name, degrees in (("angle_degrees", angle_degrees), ("corner", corner)):
        if not (is_number(degrees) and 0 < degrees <= 180):
            raise InvalidInput(
                f"{name} must be more than 0 and at most 180 degrees, not {degrees!r}"
            )
    folds, topology = Folds(mesh), mesh.topology
    sharp = folds.sharp(angle_degrees)
    if not len(sharp):
        most = folds.angles[np.isfinite(folds.angles)].max(initial=0.0)
        raise InvalidInput(
            f"no edge folds by {angle_degrees:g} degrees or more, the sharpest by {most:.3g}; "
            "take a smaller angle"
        )
    edges = np.stack([topology.indices[sharp], topology.target[sharp]], axis=1)
    return chains(edges, mesh.vertices, corner)


def sharp_chain(
    surface: Any, which: int | ArrayLike, angle_degrees: float = 30.0, *, corner: float = CORNER
) -> Indices:
    """Vertices of one chain of sharp edges, ascending.

    Parameters
    ----------
    which : its number, from 0, among :func:`sharp_chains`; or a point (3,), for the chain nearest
        to it.

    Raises
    ------
    InvalidInput : as :func:`sharp_chains`; or there is no chain of that number.
    """
    mesh = surface_from(surface)
    found = sharp_chains(mesh, angle_degrees, corner=corner)
    return np.unique(_chosen(mesh, found, which, "sharp chain").vertices)


def labelled(
    surface: Any, name: str, value: Any, *, on: Literal["vertex", "face"] | None = None
) -> Indices:
    """Vertices that have a label, or whose faces have it.

    Parameters
    ----------
    name : of an attribute of the faces or of the vertices, with one value each.
    value : the label.
    on : which of the two to look at, where both have an attribute of this name.

    Raises
    ------
    InvalidInput : there is no such attribute, both have it, or nothing has this label.
    """
    mesh = surface_from(surface)
    tables = {"vertex": mesh.attributes.vertex, "face": mesh.attributes.face}
    if not isinstance(name, str) or (on is not None and not isinstance(on, str)):
        raise InvalidInput(f"name is a text and on 'vertex' or 'face', not {name!r} and {on!r}")
    homes = [home for home in tables if name in tables[home] and on in (None, home)]
    if len(homes) != 1:
        where = f"{on} attribute" if on else "attribute of faces or vertices"
        known = some(sorted({*tables["vertex"], *tables["face"]})) or "none"
        raise InvalidInput(
            f"both vertices and faces have an attribute {name!r}; say on='vertex' or on='face'"
            if homes
            else f"the mesh has no {where} named {name!r}; it has: {known}"
        )
    values = tables[homes[0]][name]
    if values.ndim != 1:
        raise InvalidInput(
            f"attribute {name!r} has rows of shape {values.shape[1:]}; a label is one value"
        )
    if not np.isscalar(value):
        raise InvalidInput(f"a label is one value, not {value!r}")
    has: NDArray[np.bool_] = np.broadcast_to(np.asarray(values == value), values.shape)
    if not has.any():
        raise InvalidInput(
            f"no {homes[0]} has {name!r} = {value!r}; there are: {some(np.unique(values), 12)}"
        )
    if homes[0] == "vertex":
        return _used(mesh, has, f"labelled {name!r} = {value!r}")
    return np.unique(mesh.indices[has[mesh.topology.face]]).astype(np.int64)


def in_lasso(
    surface: Any, polygon: ArrayLike, camera: Camera, *, visible_only: bool = True
) -> Indices:
    """Vertices that a camera sees inside a polygon drawn on its screen.

    Parameters
    ----------
    polygon : (k, 2) corners in order, the last joined to the first: (0, 0) is the middle of the
        screen, (1, 1) its upper right corner, (-1, -1) its lower left one. It may cross itself;
        what it goes around is inside.
    camera : see :class:`Camera`.
    visible_only : leave out what the surface hides, found by the line from each vertex to the eye
        (:func:`henkei.geometry.visibility.hidden`). Otherwise all that is in front of the eye.

    Raises
    ------
    InvalidInput : the polygon has fewer than three corners, or there is no such vertex.
    """
    mesh = surface_from(surface)
    if not isinstance(camera, Camera):
        raise InvalidInput(f"camera must be henkei.select.Camera, not {camera!r}")
    corners = numbers(polygon)
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise InvalidInput(f"a lasso has three or more corners (x, y), not {corners.shape}")
    if not np.isfinite(corners).all():
        raise InvalidInput("the lasso's corners must be finite numbers")
    places, depth = camera.screen(mesh.vertices)
    inside = np.zeros(len(mesh.vertices), dtype=bool)
    ahead = np.flatnonzero(depth > 0)
    inside[ahead] = _encloses(corners, places[ahead])
    found = _used(mesh, inside, "in front of the camera and inside the lasso")
    if not visible_only:
        return found
    seen = found[~hidden(Mesh.from_any(mesh), found, camera)]
    if not len(seen):
        raise InvalidInput(
            f"all {len(found)} vertices inside the lasso are hidden behind the surface; look from "
            "the other side, or take hidden ones too with visible_only=False"
        )
    return seen


def grown(surface: Any, region: Any, rings: int = 1) -> Indices:
    """A region and all vertices that so many edges or fewer lead to from it.

    Parameters
    ----------
    region : (k,) vertex indices, a mask (n,), or what has ``vertices``: a found feature, a chain.
    rings : how many edges; 0 gives the region itself.

    Raises
    ------
    InvalidInput : the region is empty or names vertices that do not exist, or rings is negative.
    """
    mesh = surface_from(surface)
    if isinstance(rings, bool) or not isinstance(rings, int | np.integer) or rings < 0:
        raise InvalidInput(f"rings must be a whole number, at least 0, not {rings!r}")
    inside = _mask(mesh, region)
    a, b = mesh.topology.edges.T
    for _ in range(rings):
        reached = inside[a] != inside[b]
        if not reached.any():
            break
        inside[a[reached]] = inside[b[reached]] = True
    return np.flatnonzero(inside)


def _chosen(mesh: Surface, rows: list[Chain], which: Any, kind: str) -> Chain:
    """The chain of that number, or the one nearest to a point."""
    if not isinstance(which, list | tuple | np.ndarray):
        if isinstance(which, bool | np.bool_) or not isinstance(which, int | np.integer):
            raise InvalidInput(f"a {kind} is named by its number or a point, not by {which!r}")
        if not 0 <= which < len(rows):
            raise InvalidInput(f"there is no {kind} {which}: there are {len(rows)}, from 0 on")
        return rows[which]
    point = _triple(which, f"a point near a {kind}")
    nearest = [
        _from_segments(point[None], *(mesh.vertices[end] for end in row.edges.T)).min()
        for row in rows
    ]
    return rows[int(np.argmin(nearest))]


def _from_segments(points: Floats, start: Floats, end: Floats) -> Floats:
    """Distance (k, s) of each point from each segment."""
    along = end - start
    squared = (along**2).sum(axis=1)
    offsets = points[:, None] - start
    share = (offsets * along).sum(axis=2) / np.where(squared > 0, squared, 1.0)
    nearest = np.clip(share, 0, 1)[:, :, None] * along
    distance: Floats = np.linalg.norm(offsets - nearest, axis=2)
    return distance


def _encloses(corners: Floats, places: Floats) -> NDArray[np.bool_]:
    """Whether the closed polygon goes around each place (k, 2) any number of times but none."""
    turns = np.zeros(len(places), dtype=np.int64)
    on_side = np.zeros(len(places), dtype=bool)
    x, y = places.T
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        left = (bx - ax) * (y - ay) - (x - ax) * (by - ay)
        turns += ((ay <= y) & (by > y) & (left > 0)).astype(np.int64)
        turns -= ((ay > y) & (by <= y) & (left < 0)).astype(np.int64)
        within = (np.minimum(ax, bx) <= x) & (x <= np.maximum(ax, bx))
        within &= (np.minimum(ay, by) <= y) & (y <= np.maximum(ay, by))
        on_side |= (left == 0) & within
    enclosed: NDArray[np.bool_] = (turns != 0) | on_side
    return enclosed


def _used(mesh: Surface, inside: NDArray[np.bool_], where: str) -> Indices:
    """The vertices of a mask that faces use; an error if there is none."""
    mask = inside.copy()
    mask[mesh.topology.unused_vertices] = False
    found = np.flatnonzero(mask)
    if not len(found):
        used = mesh.vertices[mesh.indices]
        reach = "it has no faces"
        if len(used):
            low, high = (", ".join(f"{x:.4g}" for x in v) for v in (used.min(0), used.max(0)))
            reach = f"it reaches from ({low}) to ({high})"
        raise InvalidInput(f"the surface has no vertex {where}; {reach}")
    return found


def _mask(mesh: Surface, region: Any) -> NDArray[np.bool_]:
    count = len(mesh.vertices)
    try:
        given = np.asarray(getattr(region, "vertices", region))
    except ValueError:
        raise InvalidInput("a region is vertex indices, not rows of different lengths") from None
    if given.dtype == bool and given.shape == (count,):
        mask = given.copy()
    elif given.dtype.kind in "iu" and given.ndim == 1:
        bad = given[(given < 0) | (given >= count)]
        if len(bad):
            raise InvalidInput(f"the region names vertices {some(bad)}, but there are {count}")
        mask = np.zeros(count, dtype=bool)
        mask[given] = True
    else:
        raise InvalidInput(
            f"a region is vertex indices (k,), a mask ({count},) or a found feature, "
            f"not {given.dtype} {given.shape}"
        )
    if not mask.any():
        raise InvalidInput("the region is empty; give at least one vertex")
    return mask


def _triple(values: Any, what: str, *, infinite: bool = False) -> Floats:
    point = numbers(values)
    if point.shape != (3,) or np.isnan(point).any() or not (infinite or np.isfinite(point).all()):
        kind = "numbers" if infinite else "finite numbers"
        raise InvalidInput(f"{what} is three {kind}, not {values!r}")
    return point


def _distance(value: Any, what: str) -> float:
    if not is_number(value):
        raise InvalidInput(f"{what} is a number, not {value!r}")
    if not 0 <= value < np.inf:
        raise InvalidInput(f"{what} is at least 0 and finite, not {value!r}")
    return float(value)
