"""The figures that tell whether to trust a registration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.distance import ClosestPoints, SurfaceDistance, used_vertices
from henkei.geometry.morph_quality import intersecting_faces
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints

Flags = NDArray[np.bool_]

_LARGEST_RATIO = 1e3  # beyond which a face counts as this much distorted


@dataclass(frozen=True)
class RegisterQuality:
    """The figures that tell whether to trust a registration.

    Distances are fractions of the diagonal of the target's bounding box. The *result* has the
    source's faces and lies on the target; its *bridged* vertices have no place there.

    vertices, faces : of the result, as of the source.
    to_target_mean, to_target_p95, to_target_max : distance of the result's vertices that have a
        place from the target's surface: mean, exceeded by 5 %, largest; rounding only.
    to_source_mean, to_source_p95, to_source_max : distance of the target's vertices from the
        result's surface: how coarsely the target is covered.
    flipped : faces that lie on the target the wrong way round, see :func:`flipped_faces`; faces at
        bridged vertices do not count.
    flipped_fraction : of all faces.
    self_intersecting : faces of the result that intersect another, bridged ones included, decided
        exactly (:func:`henkei.geometry.morph_quality.intersecting_faces`).
    self_intersecting_fraction : of all faces.
    self_intersecting_target : the same of the target, as a fraction of its faces.
    area_distortion : standard deviation, weighted by area on the source, of the logarithm of a
        face's area on the target over that on the source, once the total areas are made equal; 0 if
        all areas keep their ratios. A face's ratio counts as a thousandth at least and a thousand
        at most. Faces at bridged vertices do not count.
    angle_distortion : mean, weighted by area on the source, of the ratio of the singular values of
        the map from source face to target face, larger over smaller; 1 if angles are kept. A face's
        ratio counts as a thousand at most. Faces at bridged vertices do not count.
    landmark_error : largest distance of a landmark from its counterpart, before it is put exactly
        there; rounding only.
    inverted : faces that are not strictly upright on the sphere; 0.
    bridged : vertices without a place on the target, where it has holes.
    """

    vertices: int
    faces: int
    to_target_mean: float
    to_target_p95: float
    to_target_max: float
    to_source_mean: float
    to_source_p95: float
    to_source_max: float
    flipped: int
    flipped_fraction: float
    self_intersecting: int
    self_intersecting_fraction: float
    self_intersecting_target: float
    area_distortion: float
    angle_distortion: float
    landmark_error: float
    inverted: int
    bridged: int


def measured(
    source: Mesh,
    target: Mesh,
    vertices: Floats,
    missing: Flags,
    landmark_error: float,
    inverted: int,
) -> RegisterQuality:
    """The figures of a registration.

    Parameters
    ----------
    vertices : (n, 3) where the source's vertices went.
    missing : (n,) which of them are bridged, that is, have no place on the target.
    landmark_error : as a fraction of the target's diagonal.
    inverted : faces that are not upright on the sphere.
    """
    result = Mesh(vertices, source.faces)
    placed: Flags = np.all(~missing[source.faces], axis=1)
    used = np.zeros(len(vertices), dtype=bool)
    used[result.indices] = True
    on_target = ClosestPoints(target)
    to_target = SurfaceDistance.of(on_target.query(vertices[used & ~missing])[1])
    to_source = SurfaceDistance.of(ClosestPoints(result).query(used_vertices(target))[1])
    flipped = int(np.count_nonzero(placed[flipped_faces(result, target, on_target)]))
    intersecting = len(intersecting_faces(result))
    area, angle = distortions(source, result, placed)
    return RegisterQuality(
        vertices=len(vertices),
        faces=len(source.faces),
        to_target_mean=to_target.mean / target.diagonal,
        to_target_p95=to_target.p95 / target.diagonal,
        to_target_max=to_target.maximum / target.diagonal,
        to_source_mean=to_source.mean / target.diagonal,
        to_source_p95=to_source.p95 / target.diagonal,
        to_source_max=to_source.maximum / target.diagonal,
        flipped=flipped,
        flipped_fraction=flipped / len(source.faces),
        self_intersecting=intersecting,
        self_intersecting_fraction=intersecting / len(source.faces),
        self_intersecting_target=len(intersecting_faces(target)) / len(target.faces),
        area_distortion=area,
        angle_distortion=angle,
        landmark_error=float(landmark_error),
        inverted=int(inverted),
        bridged=int(np.count_nonzero(used & missing)),
    )


def flipped_faces(result: Mesh, target: Mesh, on_target: ClosestPoints | None = None) -> Ints:
    """Faces of the result that lie on the target the wrong way round, creases apart.

    Such a face looks against the target's normal at the point nearest to its centroid. At a crease
    that point may be on the other side: of a fin, or of a rim thinner than a chord across it is
    deep. So a face is not counted where the target itself turns over within the face and the face
    goes along: where at a corner the target's normal is more than a right angle away from that at
    the centroid, and the face looks along it. A face folded over where there is no such crease, on
    thin parts too, has only normals against it, and counts; only where a part is thinner than the
    face's chord is deep may one escape, its centroid being nearer to the other side.

    Parameters
    ----------
    on_target : the target made ready, if it was before.

    Returns
    -------
    (k,) int32, ascending. Faces without area look nowhere and are not among them.
    """
    nearest = on_target or ClosestPoints(target)
    corners = result.vertices[result.faces]
    at_centroid = _normals(target, nearest, corners.mean(axis=1))
    against = np.flatnonzero(_dot(result.face_normals, at_centroid) < 0)
    looks, here = result.face_normals[against], at_centroid[against]
    excused = np.zeros(len(against), dtype=bool)
    for corner in range(3):
        there = _normals(target, nearest, corners[against, corner])
        excused |= (_dot(there, here) < 0) & (_dot(there, looks) > 0)
    return against[~excused].astype(np.int32)


def distortions(source: Mesh, result: Mesh, counted: Flags) -> tuple[float, float]:
    """How areas and angles changed, as in :class:`RegisterQuality`.

    Parameters
    ----------
    counted : (m,) the faces that count.
    """
    weight = source.face_areas[counted]
    area = result.face_areas[counted]
    if not (weight.sum() > 0 and area.sum() > 0):
        return 0.0, 1.0
    weight = weight / weight.sum()
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.clip(area / area.sum() / weight, 1 / _LARGEST_RATIO, _LARGEST_RATIO)
    has_area = weight > 0
    weight, change = weight[has_area], np.log(ratio[has_area])
    mean = weight @ change
    stretch = stretch_ratios(source.vertices[source.faces], result.vertices[source.faces])
    return (
        float(np.sqrt(weight @ (change - mean) ** 2)),
        float(weight @ stretch[counted][has_area]),
    )


def stretch_ratios(source: Floats, result: Floats) -> Floats:
    """Ratio of the singular values of the maps from triangles (m, 3, 3) to triangles.

    In the plane of complex numbers such a map is ``z -> alpha z + beta conj(z)``, with the singular
    values ``|alpha| + |beta|`` and ``|alpha| - |beta|``.
    """
    p, q = _flat(source)
    u, v = _flat(result)
    alpha, beta = abs(u * q.conj() - v * p.conj()), abs(v * p - u * q)
    larger, smaller = alpha + beta, alpha - beta
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(smaller * _LARGEST_RATIO > larger, larger / smaller, _LARGEST_RATIO)


def _flat(triangles: Floats) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """The two sides from each triangle's first corner, laid into a plane, counter-clockwise."""
    side, other = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    length = np.linalg.norm(side, axis=1)
    per_length = 1 / np.where(length > 0, length, 1)
    along = _dot(side, other) * per_length
    across = np.linalg.norm(np.cross(side, other), axis=1) * per_length
    return length.astype(np.complex128), along + 1j * across


def _normals(target: Mesh, nearest: ClosestPoints, points: Floats) -> Floats:
    return target.face_normals[nearest.query(points)[0].face]


def _dot(a: Floats, b: Floats) -> Floats:
    product: Floats = np.einsum("ik,ik->i", a, b)
    return product
