"""How good quads are, in figures that say whether to trust them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.distance import ClosestPoints, points_on, sampled, used_vertices
from henkei.geometry.element_quality import element_quality
from henkei.mesh import Floats, Mesh, PolygonMesh

SAMPLES = 50_000  # places at which each distance is measured, beside the vertices


@dataclass(frozen=True)
class QuadQuality:
    """Figures of a quad mesh and of how it was made.

    quads, vertices : how many there are.
    irregular : inner vertices with other than four quads, and boundary vertices with other than
        two; convex corners of the boundary may have one.
    worst_scaled_jacobian, low_scaled_jacobian, mean_scaled_jacobian : least, 5 % quantile and mean
        over the quads; 1 for a rectangle, 0 or less for one that is folded.
    mean_angle_deviation : of the corners from 90 degrees.
    inverted : quads with a scaled Jacobian of 0 or less.
    flipped : quads that face against the surface.
    distance_to_input, distance_from_input : largest distance of the quads from the input, and of
        the input from the quads (both one-sided Hausdorff distances, at samples), as fractions of
        the input's diagonal.
    mean_distance : mean of both, likewise.
    patches : of the layout.
    layout : ``"field"`` or ``"vsa"``; with several components, what most quads come from.
    injective : that all patches were mapped one to one, decided exactly.
    turned_faces : faces of the input that were turned over so that all wind alike.
    asymmetry : largest distance of the input from its image in the plane of symmetry, as a fraction
        of the diagonal; 0 where no symmetry was asked for.
    seconds : processor time of each step.
    """

    quads: int
    vertices: int
    irregular: int
    worst_scaled_jacobian: float
    low_scaled_jacobian: float
    mean_scaled_jacobian: float
    mean_angle_deviation: float
    inverted: int
    flipped: int
    distance_to_input: float
    distance_from_input: float
    mean_distance: float
    patches: int
    layout: str
    injective: bool
    turned_faces: int = 0
    asymmetry: float = 0.0
    seconds: Mapping[str, float] = field(default_factory=dict)


def quad_quality(
    quads: PolygonMesh,
    surface: Mesh,
    *,
    patches: int,
    layout: str,
    injective: bool,
    turned_faces: int = 0,
    asymmetry: float = 0.0,
    seconds: Mapping[str, float],
) -> QuadQuality:
    """Measure quads against the surface they were made from."""
    faces = np.asarray(quads.faces)
    shape = element_quality(quads).scaled_jacobian
    to_input, from_input, flipped = _distances(quads, surface)
    return QuadQuality(
        quads=len(faces),
        vertices=len(quads.vertices),
        irregular=int(irregular_vertices(quads).sum()),
        worst_scaled_jacobian=float(shape.min()),
        low_scaled_jacobian=float(np.quantile(shape, 0.05)),
        mean_scaled_jacobian=float(shape.mean()),
        mean_angle_deviation=float(angle_deviations(quads.vertices[faces]).mean()),
        inverted=int((shape <= 0).sum()),
        flipped=flipped,
        distance_to_input=float(to_input.max()),
        distance_from_input=float(from_input.max()),
        mean_distance=float((to_input.mean() + from_input.mean()) / 2),
        patches=patches,
        layout=layout,
        injective=injective,
        turned_faces=turned_faces,
        asymmetry=asymmetry,
        seconds=dict(seconds),
    )


def irregular_vertices(quads: PolygonMesh) -> NDArray[np.bool_]:
    """Whether each vertex (n,) is irregular, see :class:`QuadQuality`."""
    topology = quads.topology
    around = np.bincount(quads.indices, minlength=len(quads.vertices))
    border = np.zeros(len(quads.vertices), dtype=bool)
    border[quads.indices[topology.twin < 0]] = True
    regular = np.where(border, (around == 1) | (around == 2), (around == 4) | (around == 0))
    irregular: NDArray[np.bool_] = ~regular
    return irregular


def angle_deviations(corners: Floats) -> Floats:
    """How many degrees each corner (q, 4) of quads (q, 4, 3) is away from 90."""
    to_next = np.roll(corners, -1, axis=1) - corners
    to_previous = np.roll(corners, 1, axis=1) - corners
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    cross = np.cross(to_next, to_previous)
    sine = np.linalg.norm(cross, axis=2)
    angle = np.arctan2(sine, (to_next * to_previous).sum(axis=2))
    reflex = (cross * normal[:, None]).sum(axis=2) < 0
    deviation: Floats = np.abs(np.degrees(np.where(reflex, 2 * np.pi - angle, angle)) - 90)
    return deviation


def _distances(quads: PolygonMesh, surface: Mesh) -> tuple[Floats, Floats, int]:
    """To the surface and from it, as fractions of its diagonal; how many quads are flipped."""
    triangles = quads.triangulated()
    corners = quads.vertices[np.asarray(quads.faces)]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    on_surface = ClosestPoints(surface)
    below, _ = on_surface.query(corners.mean(axis=1))
    flipped = int(((normals * surface.face_normals[below.face]).sum(axis=1) < 0).sum())
    out = np.vstack([points_on(triangles, sampled(triangles, SAMPLES)), used_vertices(triangles)])
    back = np.vstack([points_on(surface, sampled(surface, SAMPLES)), used_vertices(surface)])
    diagonal = surface.diagonal
    to_surface = on_surface.query(out)[1] / diagonal
    from_surface = ClosestPoints(triangles).query(back)[1] / diagonal
    return to_surface, from_surface, flipped
