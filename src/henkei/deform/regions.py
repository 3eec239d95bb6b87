"""Checks of what a user names: regions, points, names, and how they lie to each other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from henkei.deform.constraints import Feature, Fixed, Region
from henkei.deform.hard import Body
from henkei.errors import InvalidInput, some
from henkei.geometry.arguments import is_number
from henkei.mesh import Floats, Surface
from henkei.topology import Ints


def checked_region(region: Any, count: int, name: str) -> Region:
    """Sorted vertex indices of a region given as indices, mask or an object with ``vertices``."""
    try:
        given = np.asarray(getattr(region, "vertices", region))
    except ValueError:
        raise InvalidInput(
            f"region {name!r} must hold vertex indices, not rows of different lengths"
        ) from None
    if given.dtype == bool:
        if given.shape != (count,):
            raise InvalidInput(
                f"region {name!r}: a mask must have one value for each of the {count} vertices, "
                f"this has shape {given.shape}"
            )
        given = np.flatnonzero(given)
    if given.size == 0:
        raise InvalidInput(f"region {name!r} is empty; give at least one vertex")
    if given.dtype.kind not in "iu":
        raise InvalidInput(f"region {name!r} must hold vertex indices, not {given.dtype} values")
    vertices = np.unique(given.astype(np.int64))
    bad = vertices[(vertices < 0) | (vertices >= count)]
    if len(bad):
        raise InvalidInput(
            f"region {name!r} names vertices {some(bad)}, but there are {count} (counted from 0)"
        )
    return vertices


def checked_point(point: Any, surface: Surface, name: str) -> tuple[Region, Floats]:
    """Vertices and coefficients of a point given as vertex, ``((i, j), t)`` or ``(face, weights)``.

    On an edge the point is ``t p_i + (1 - t) p_j``; in a face the sum of its corners by the
    weights (eq. 3).
    """
    if isinstance(point, int | np.integer) and not isinstance(point, bool):
        return checked_region([int(point)], len(surface.vertices), name), np.ones(1)
    no_point = InvalidInput(
        f"{name!r}: a point is a vertex index, ((i, j), t) on an edge, or (face, weights) with a "
        f"weight for each corner, not {point!r}"
    )
    try:
        where, weights = (np.asarray(part) for part in point)
        if np.iscomplexobj(weights):
            raise TypeError
        coefficients = weights.astype(np.float64)
    except (TypeError, ValueError):
        raise no_point from None
    if where.dtype.kind not in "iu" or where.ndim + coefficients.ndim != 1:
        raise no_point
    if where.ndim:
        vertices = _edge(where, surface, name)
        coefficients = np.array([coefficients, 1 - coefficients])
    else:
        vertices = _corners(int(where), surface, name)
    if len(vertices) != len(coefficients) or not np.isfinite(coefficients).all():
        raise no_point
    if abs(coefficients.sum() - 1) > 1e-9 or (coefficients < -1e-9).any():
        raise InvalidInput(
            f"{name!r}: weights {coefficients.tolist()} must be at least 0 and add up to 1"
        )
    kept = coefficients > 0
    return vertices[kept].astype(np.int64), coefficients[kept] / coefficients[kept].sum()


def checked_weight(weight: float | None, name: str) -> float | None:
    """A weight of the least squares, or None for what is held exactly."""
    if weight is None:
        return None
    if not is_number(weight):
        raise InvalidInput(f"the weight of {name!r} must be a number or None, not {weight!r}")
    if not 0 < weight < np.inf:
        raise InvalidInput(
            f"the weight of {name!r} must be positive and finite, not {weight!r}; "
            "None holds it exactly"
        )
    return float(weight)


def _edge(vertices: Region, surface: Surface, name: str) -> Region:
    edge = np.sort(vertices)
    if len(edge) != 2 or not (surface.topology.edges == edge).all(axis=1).any():
        raise InvalidInput(f"{name!r}: {vertices.tolist()} is not an edge of the mesh")
    return vertices


def _corners(face: int, surface: Surface, name: str) -> Region:
    if not 0 <= face < surface.face_count:
        raise InvalidInput(
            f"{name!r}: there is no face {face!r} among {surface.face_count} (counted from 0)"
        )
    start, end = surface.offsets[face : face + 2]
    return surface.indices[start:end].astype(np.int64)


def checked_name(name: str | None, kind: str, taken: Iterable[str]) -> str:
    """The name, or the next free "kind number"."""
    taken = set(taken)
    if name is None:
        number = 1
        while f"{kind} {number}" in taken:
            number += 1
        return f"{kind} {number}"
    if not isinstance(name, str) or not name:
        raise InvalidInput(f"a name must be a text, not {name!r}")
    if name in taken:
        raise InvalidInput(f"there is a constraint named {name!r} already; names must differ")
    return name


def require_apart(body: Body, others: Sequence[Body]) -> None:
    """Raise if a hard region shares vertices with another one; fixed regions may."""
    for other in others:
        shared = np.intersect1d(body.vertices, other.vertices)
        if not len(shared) or (isinstance(body, Fixed) and isinstance(other, Fixed)):
            continue
        advice = "give each vertex to one of them, or make one soft with weight="
        if {type(body), type(other)} == {Fixed, Feature}:
            advice = "a feature moves as a whole: take these vertices out of one of them"
        raise InvalidInput(
            f"{body.name!r} and {other.name!r} overlap in {len(shared)} vertices {some(shared)}; "
            + advice
        )


def loose_vertices(surface: Surface, part: Ints, held: Iterable[Region]) -> NDArray[np.bool_]:
    """A mask ``(n,)`` of the vertices whose connected ``part`` (n,) has nothing that holds it."""
    used = np.zeros(len(surface.vertices), dtype=bool)
    used[surface.indices] = True
    holding = np.concatenate([np.empty(0, np.int64), *held])
    return used & ~np.isin(part, part[holding])


def connected_parts(count: int, edges: Ints) -> Ints:
    """A number for each of ``count`` vertices: the same if edges join them."""
    graph = csr_array((np.ones(len(edges), np.int8), tuple(edges.T)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], np.int32)


def require_held(surface: Surface, part: Ints, held: Iterable[Region]) -> None:
    """Raise if a connected piece of the surface has nothing that holds it."""
    loose = loose_vertices(surface, part, held)
    if not loose.any():
        return
    pieces = np.unique(part[loose], return_index=True, return_counts=True)
    firsts = np.flatnonzero(loose)[pieces[1]]
    listed = ", ".join(
        f"the one of {size} vertices around vertex {vertex}"
        for vertex, size in list(zip(firsts, pieces[2], strict=True))[:12]
    )
    number = len(firsts)
    raise InvalidInput(
        f"{number} connected {'piece is' if number == 1 else 'pieces are'} not held by anything: "
        f"{listed}; fix a region there, put a handle on it, or pin it"
    )
