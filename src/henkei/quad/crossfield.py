"""A cross field: four directions in every triangle, a quarter turn apart, smooth over the surface.

They follow creases and boundaries exactly and the directions of principal curvature where these
differ. A cross with angle ``t`` is the complex number ``exp(4 i t)``, which the four directions
share (Knöppel, Crane, Pinkall, Schröder 2013: Globally optimal direction fields). Singular vertices
closer to each other than the size of a quad are of no use to quads; diffusion over that distance,
followed by scaling back to unit length, unites them (Viertel, Osting 2019: An approach to quad
meshing based on harmonic cross-valued maps).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from henkei.geometry.weights import corner_angles, cotangent_weights, half_edge_lengths
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, silent
from henkei.solve.factor import factor_spd

Complex = NDArray[np.complex128]
QUARTER = np.pi / 2
SHARP = np.radians(60.0)


class Frames:
    """An orthonormal frame in every triangle, and how frames of neighbours lie to each other.

    axes : (m, 2, 3) first and second axis; with the normal a right-handed frame.
    along : (3 m, 2) the half-edge as a vector in its face's frame.
    turn : (3 m,) angle that a direction's angle gains from this half-edge's face to the twin's;
        0 on the boundary.
    """

    def __init__(self, mesh: Mesh) -> None:
        topology = mesh.topology
        edges = mesh.vertices[topology.target] - mesh.vertices[mesh.indices]
        first = edges.reshape(-1, 3, 3)[:, 0]
        first = first / np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(mesh.face_normals, first)
        self.axes: Floats = np.stack([first, second], axis=1)
        self.along: Floats = np.einsum("hkc,hc->hk", self.axes[topology.face], edges)
        angle = np.arctan2(self.along[:, 1], self.along[:, 0])
        turn = angle[topology.twin] + np.pi - angle
        self.turn: Floats = np.where(topology.twin >= 0, turn, 0.0)
        self.angle: Floats = angle


@dataclass(frozen=True, eq=False)
class CrossField:
    """Four directions in every triangle of ``mesh``.

    frames : the frames in which angles are given.
    angle : (m,) radians of the first direction in the frame of its face; the others follow
        counter-clockwise by quarter turns.
    feature : (3 m,) bool, half-edges which the field follows.
    """

    mesh: Mesh
    frames: Frames
    angle: Floats
    feature: NDArray[np.bool_]

    @cached_property
    def matching(self) -> NDArray[np.int64]:
        """(3 m,) direction ``k`` of a half-edge's face goes on as ``k + matching`` in the twin's.

        The directions nearest to each other are matched. Where two features meet at an angle so
        sharp that they would follow the same direction, the matching between them is one off: a
        corner of a quad needs a quarter turn.
        """
        twin = self.mesh.topology.twin
        nearest = np.rint(self._transported / QUARTER)
        matching = np.where(twin >= 0, nearest, 0).astype(np.int64)
        residual = self._transported - matching * QUARTER
        for spokes, angle in _feature_angles(self.mesh, self.feature):
            quarters = round((angle + residual[spokes].sum()) / QUARTER)
            if quarters < 1 and spokes:
                spoke = spokes[len(spokes) // 2]
                matching[spoke] -= 1 - quarters
                matching[twin[spoke]] += 1 - quarters
        self._part_double(matching)
        return matching

    def _part_double(self, matching: NDArray[np.int64]) -> None:
        """Vertices that two quads would meet at, or seven, give a part of it to a neighbour."""
        topology, twin = self.mesh.topology, self.mesh.topology.twin
        count = len(self.mesh.vertices)
        quarters = np.rint(np.bincount(self.mesh.indices, self._sectors(matching), count))
        held = np.bincount(self.mesh.indices, minlength=count) == 0
        held[self.mesh.indices[self.feature]] = held[topology.target[self.feature]] = True
        for h in np.flatnonzero(~held[self.mesh.indices] & ~held[topology.target]).tolist():
            vertex, other = self.mesh.indices[h], topology.target[h]
            low, high = quarters[vertex] < 3, quarters[vertex] > 6
            if quarters[other] != 4 or not (low or high):
                continue
            # Over h one goes clockwise around its start.
            step = 1 if low else -1
            matching[h] += step
            matching[twin[h]] -= step
            quarters[vertex] += step
            quarters[other] -= step

    @cached_property
    def sector(self) -> Floats:
        """(3 m,) angle at each half-edge's start, in quarter turns against the field.

        Summed round an inner vertex this is a whole number, 4 where the field is regular; summed
        between two half-edges that the field follows likewise.
        """
        return self._sectors(self.matching)

    def _sectors(self, matching: NDArray[np.int64]) -> Floats:
        twin = self.mesh.topology.twin
        corner = corner_angles(self.mesh).ravel()
        residual = self._transported - matching * QUARTER
        turned = np.where(twin >= 0, residual, 0.0)  # by the field, back, over each half-edge
        at_end = turned.reshape(-1, 3)[:, [2, 0, 1]].ravel()
        total: Floats = (corner + (at_end - turned) / 2) / QUARTER
        return total

    @property
    def _transported(self) -> Floats:
        """Angle of direction 0, carried over each half-edge, less the twin's direction 0."""
        topology = self.mesh.topology
        return (
            self.angle[topology.face] + self.frames.turn - self.angle[topology.face[topology.twin]]
        )


def cross_field(
    mesh: Mesh,
    feature: NDArray[np.bool_],
    size: float,
    *,
    alignment: float = 0.3,
    spread: float = 0.8,
    steps: int = 24,
    progress: Progress = silent,
) -> CrossField:
    """A smooth cross field that follows features, and principal curvatures where they differ.

    Parameters
    ----------
    mesh : connected, its triangles well shaped.
    feature : (3 m,) bool, half-edges which one direction follows exactly.
    size : edge length of the quads to come; detail of the field below it is smoothed away.
    alignment : how strongly principal directions are followed; 0: smoothness alone.
    spread : over how many squared sizes the curvature of the surface is spread before the field
        follows it; more makes fewer singular vertices.
    steps : of diffusion.
    """
    frames = Frames(mesh)
    smoothness = _connection_laplacian(
        mesh, frames.turn + _smoothing(mesh, feature, spread * size**2)
    )
    area = mesh.face_areas
    wanted = alignment * area * _curvature_cross(mesh, frames, feature, smoothness, size)
    held, cross = _held(mesh, frames, feature)
    operator = smoothness + sparse.diags_array(np.abs(wanted) + 1e-6 * area / area.sum())
    cross[~held] = _solved(operator, wanted, cross, held)
    cross = _unit(cross)
    step = (1.5 * size) ** 2
    diffusion = _Diffusion(sparse.diags_array(area) + step * operator, held)
    for k in range(steps):
        progress("cross field", k / steps)
        cross[~held] = diffusion(area * cross + step * wanted, cross)
        cross = _unit(cross)
    return CrossField(mesh, frames, np.angle(cross) / 4, feature)


class _Diffusion:
    def __init__(self, matrix: sparse.csr_array, held: NDArray[np.bool_]) -> None:
        matrix = matrix.tocsr()
        self.held = held
        self.coupling = matrix[~held][:, held]
        self.factor = factor_spd(_real(matrix[~held][:, ~held]))

    def __call__(self, right: Complex, cross: Complex) -> Complex:
        b = right[~self.held] - self.coupling @ cross[self.held]
        x = self.factor.solve(np.concatenate([b.real, b.imag]))
        half = len(x) // 2
        return x[:half] + 1j * x[half:]


def _solved(
    matrix: sparse.csr_array, right: Complex, cross: Complex, held: NDArray[np.bool_]
) -> Complex:
    if not held.any() and not np.abs(right).any():
        right = right + np.exp(1j)
    return _Diffusion(matrix, held)(right, cross)


def _real(matrix: sparse.csr_array) -> sparse.csc_array:
    """The real matrix of a Hermitian one: unknowns are the real parts, then the imaginary ones."""
    return sparse.block_array(
        [[matrix.real, -matrix.imag], [matrix.imag, matrix.real]], format="csc"
    )


def _unit(cross: Complex) -> Complex:
    size = np.abs(cross)
    return np.where(size > 0, cross / np.where(size > 0, size, 1), 1.0)


def _connection_laplacian(mesh: Mesh, turn: Floats) -> sparse.csr_array:
    """Differences of neighbouring crosses, squared: Hermitian, one row per face."""
    topology = mesh.topology
    inner = np.flatnonzero(topology.twin >= 0)
    a, b = topology.face[inner], topology.face[topology.twin[inner]]
    length = half_edge_lengths(mesh)[inner]
    weight = 3 * length**2 / (mesh.face_areas[a] + mesh.face_areas[b])
    weight = np.minimum(weight, 100.0)
    carried = weight * np.exp(4j * turn[inner])
    count = len(mesh.faces)
    diagonal = np.bincount(a, weight, count)
    off = sparse.coo_array((carried, (b, a)), shape=(count, count))
    return (sparse.diags_array(diagonal) - off).tocsr()


def _smoothing(mesh: Mesh, feature: NDArray[np.bool_], spread: float) -> Floats:
    """What to add to the turns (3 m,) of frames so that the surface seems to bend evenly.

    Curvature that the surface has within less than a quad would give singular vertices that no
    quad can follow. It is spread by diffusion, and the turns are changed by as little as gives the
    angles that are missing then (N. Ray, B. Vallet, L. Alonso, B. Levy: Geometry-aware direction
    field processing, 2009). Sharp angles between features are opened to right ones beforehand.
    """
    twin = mesh.topology.twin
    count = len(mesh.vertices)
    free = np.bincount(mesh.indices, minlength=count) > 0
    free[mesh.indices[feature]] = free[mesh.topology.target[feature]] = False
    opened = _opened_angles(mesh, feature)
    angles = np.bincount(mesh.indices, corner_angles(mesh).ravel() + np.minimum(opened, 0), count)
    defect = 2 * np.pi - angles
    weight = cotangent_weights(mesh)
    weight = np.maximum(np.where(twin >= 0, (weight + weight[twin]) / 2, 0), 1e-3)
    weight[~(free[mesh.indices] & free[mesh.topology.target])] = 0
    entries = (weight, (mesh.indices, mesh.topology.target))
    coupling = sparse.coo_array(entries, shape=(count, count)).tocsr()[free][:, free]
    laplacian: Any = sparse.diags_array(coupling.sum(axis=1)) - coupling
    mass = np.bincount(mesh.indices, np.repeat(mesh.face_areas / 3, 3), count)[free]
    if not len(mass):
        return opened
    diffusion = factor_spd(sparse.diags_array(mass) + spread * laplacian)
    even = mass * diffusion.solve(defect[free])
    potential = np.zeros(count)
    grounded = laplacian + sparse.diags_array(1e-9 * (laplacian.diagonal() + mass / spread))
    potential[free] = factor_spd(grounded).solve(even - defect[free])
    flux = weight * (potential[mesh.topology.target] - potential[mesh.indices])
    return opened + np.where(twin >= 0, flux, 0.0)


def _opened_angles(mesh: Mesh, feature: NDArray[np.bool_]) -> Floats:
    """Turns (3 m,) that make right angles of the sharp ones between features."""
    turns = np.zeros(len(mesh.indices))
    for spokes, angle in _feature_angles(mesh, feature):
        if angle < SHARP and spokes:
            turns[spokes] -= (QUARTER - angle) / len(spokes)
            turns[mesh.topology.twin[spokes]] += (QUARTER - angle) / len(spokes)
    return turns


def _feature_angles(mesh: Mesh, feature: NDArray[np.bool_]) -> Iterator[tuple[list[int], float]]:
    """Of each angle between features: the half-edges over which one passes through it
    counter-clockwise, and how wide it is."""
    twin = mesh.topology.twin
    corner = corner_angles(mesh).ravel()
    for start in np.flatnonzero(feature).tolist():
        at, wide, spokes = start, corner[start], []
        while not feature[last := at - 1 if at % 3 else at + 2]:
            spokes.append(last)
            at = int(twin[last])
            wide += corner[at]
        yield spokes, float(wide)


def _held(
    mesh: Mesh, frames: Frames, feature: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], Complex]:
    """Faces at features, and the cross there; of two features at a face the longer one decides."""
    cross = np.ones(len(mesh.faces), dtype=complex)
    held = np.zeros(len(mesh.faces), dtype=bool)
    at = np.flatnonzero(feature)
    at = at[np.argsort(np.linalg.norm(frames.along[at], axis=1), kind="stable")]
    face = mesh.topology.face[at]
    held[face] = True
    cross[face] = np.exp(4j * frames.angle[at])
    return held, cross


def _curvature_cross(
    mesh: Mesh,
    frames: Frames,
    feature: NDArray[np.bool_],
    smoothness: sparse.csr_array,
    size: float,
) -> Complex:
    """Principal directions as crosses, as long as the squared difference of the curvatures."""
    along = frames.along.reshape(-1, 3, 2)
    normals = mesh.vertex_normals[mesh.faces]
    change = np.einsum("fkc,fic->fik", frames.axes, np.roll(normals, -1, axis=1) - normals)
    x, y = along[..., 0], along[..., 1]
    zero = np.zeros_like(x)
    rows = np.concatenate([np.stack([x, y, zero], -1), np.stack([zero, x, y], -1)], axis=1)
    right = np.concatenate([change[..., 0], change[..., 1]], axis=1)
    normal_matrix = np.einsum("fri,frj->fij", rows, rows)
    scale = np.trace(normal_matrix, axis1=1, axis2=2)[:, None, None]
    shape = np.linalg.solve(
        normal_matrix + 1e-6 * scale * np.eye(3), np.einsum("fri,fr->fi", rows, right)[..., None]
    )[..., 0]
    deviator = (shape[:, 0] - shape[:, 2]) / 2 + 1j * shape[:, 1]
    touched = np.zeros(len(mesh.vertices), dtype=bool)
    touched[mesh.indices[feature]] = touched[mesh.topology.target[feature]] = True
    deviator[touched[mesh.faces].any(axis=1)] = 0
    return (2 * deviator) ** 2
