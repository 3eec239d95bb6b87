"""Figures that tell whether to trust a deformation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from henkei.deform.constraints import Feature, Handle, Pin
from henkei.deform.hard import Body
from henkei.deform.rotation_field import RotationsOf
from henkei.deform.soft import triangles_of
from henkei.deform.volume import Volume
from henkei.geometry.rotations import best_rotations
from henkei.mesh import Floats, Surface
from henkei.topology import Ints


@dataclass(frozen=True)
class DeformQuality:
    """How good a deformation is. Errors are fractions of the diagonal of the mesh at rest.

    method : "linear" or "refined".
    hard_position_error : largest distance of a fixed vertex, a handle's vertex or a hard pin from
        where it shall be.
    feature_error : largest distance of a hard feature's vertex from its shape, turned and moved to
        fit best; for planes and lines, what their distance from the best plane or line grew by.
    soft_position_error : the same for soft regions, handles and pins, and for the shape of soft
        features.
    flipped : triangles that face against their normal, turned as the handles around them are.
    strain : change of edge lengths as a fraction, that 99 % of the edges don't exceed.
    area_change : of the whole surface, as a fraction.
    volume_change : of what a closed surface encloses, as a fraction; None where it is open.
    backend : the solver in use.
    residual : largest backward error of the solver so far.
    """

    method: str
    hard_position_error: float
    feature_error: float
    soft_position_error: float
    flipped: int
    strain: float
    area_change: float
    volume_change: float | None
    backend: str
    residual: float


@dataclass(frozen=True, eq=False)
class Solution:
    """Positions ``(n, 3)``, rotations of vertices, and what was asked for at the time.

    field : the rotations that were interpolated between handles, whatever was fitted since.
    """

    positions: Floats
    bodies: Sequence[Body]
    pins: Sequence[Pin]
    rotations: RotationsOf
    field: RotationsOf
    method: str
    backend: str
    residual: float


def measured(surface: Surface, solution: Solution) -> DeformQuality:
    """The figures of a solution."""
    rest, positions, diagonal = surface.vertices, solution.positions, surface.diagonal
    missed: dict[bool, list[float]] = {False: [0.0], True: [0.0]}
    shapes = [0.0]
    for body in solution.bodies:
        if isinstance(body, Feature):
            error = shape_error(body, positions[body.vertices])
            (shapes if body.weight is None else missed[True]).append(error)
            continue
        wanted = body.displacement if isinstance(body, Handle) else 0.0
        gaps = positions[body.vertices] - rest[body.vertices] - wanted
        missed[body.weight is not None].append(float(np.linalg.norm(gaps, axis=1).max()))
    for pin in solution.pins:
        gap = pin.coefficients @ positions[pin.vertices] - pin.target
        missed[pin.weight is not None].append(float(np.linalg.norm(gap)))
    rotations = solution.field(np.arange(len(rest)))
    triangles, share = triangles_of(surface)
    before, after = _crosses(rest, triangles), _crosses(positions, triangles)
    turned = np.einsum("tij,tj->ti", rotations[triangles].sum(axis=1), before)
    areas = [float(share @ np.linalg.norm(normals, axis=1)) for normals in (before, after)]
    edges = surface.topology.edges
    lengths = [np.linalg.norm(p[edges[:, 0]] - p[edges[:, 1]], axis=1) for p in (rest, positions)]
    strain = np.abs(lengths[1] - lengths[0]) / np.where(lengths[0] > 0, lengths[0], 1)
    return DeformQuality(
        method=solution.method,
        hard_position_error=max(missed[False]) / diagonal,
        feature_error=max(shapes) / diagonal,
        soft_position_error=max(missed[True]) / diagonal,
        flipped=int((np.einsum("ti,ti->t", turned, after) < 0).sum()),
        strain=float(np.quantile(strain, 0.99)),
        area_change=areas[1] / areas[0] - 1,
        volume_change=_volume_change(surface, positions),
        backend=solution.backend,
        residual=solution.residual,
    )


def shape_error(feature: Feature, positions: Floats) -> float:
    """Largest distance of a feature's vertices from the shape it keeps, in the unit of the mesh."""
    now = positions - positions.mean(axis=0)
    rest = feature.rest + feature.displacement(np.eye(3))
    rest = rest - rest.mean(axis=0)
    if feature.keep in ("plane", "line"):
        first = 2 if feature.keep == "plane" else 1
        return max(0.0, _leaving(now, first) - _leaving(rest, first))
    turn = best_rotations((now.T @ rest)[None])[0]
    return float(np.linalg.norm(now - rest @ turn.T, axis=1).max())


def _leaving(offsets: Floats, first: int) -> float:
    """Largest distance from the best plane (first 2) or line (first 1) through the origin."""
    axes = np.linalg.svd(offsets, full_matrices=False)[2][first:]
    return float(np.linalg.norm(offsets @ axes.T, axis=1).max(initial=0.0))


def _crosses(points: Floats, triangles: Ints) -> Floats:
    corner = points[triangles]
    crosses: Floats = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return crosses


def _volume_change(surface: Surface, positions: Floats) -> float | None:
    if not Volume.is_enclosed(surface):
        return None
    volume = Volume(surface)
    return volume.of(positions) / volume.at_rest - 1 if volume.at_rest else None
