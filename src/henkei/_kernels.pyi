"""Types of the compiled kernels; each is described at the top of its C++ file."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int32]

class ClosestPoints:
    def __init__(self, vertices: NDArray[np.float64], faces: Ints) -> None: ...
    def query(
        self, points: NDArray[np.float64]
    ) -> tuple[Ints, NDArray[np.float64], NDArray[np.float64]]: ...

class Cholesky:
    def __init__(
        self, start: Ints, row: Ints, values: NDArray[np.float64], order: Ints
    ) -> None: ...
    def solve(self, right: NDArray[np.float64], out: NDArray[np.float64]) -> None: ...
    @property
    def entries(self) -> int: ...

class Remeshing:
    def __init__(
        self,
        vertices: NDArray[np.float64],
        faces: Ints,
        twins: Ints,
        feature: NDArray[np.uint8],
        length: NDArray[np.float64],
    ) -> None: ...
    def split_long(self, most: int) -> bool: ...
    def collapse_short(self) -> None: ...
    def flip(self) -> None: ...
    def relax(self) -> None: ...
    def separate(self) -> None: ...
    def result(
        self,
    ) -> tuple[Ints, NDArray[np.uint8], Ints, NDArray[np.float64], NDArray[np.uint8]]: ...

class QuadRelaxation:
    def __init__(
        self,
        vertices: NDArray[np.float64],
        faces: Ints,
        twins: Ints,
        line_start: NDArray[np.int64],
        line_points: NDArray[np.float64],
        line_arc: NDArray[np.float64],
        line_half_edges: Ints,
        line_closed: NDArray[np.uint8],
        quads: Ints,
        face: Ints,
        weights: NDArray[np.float64],
        points: NDArray[np.float64],
        held: NDArray[np.uint8],
        line: Ints,
        arc: NDArray[np.float64],
        beside: Ints,
        limits: NDArray[np.float64],
        size: NDArray[np.float64],
        centre: Ints,
    ) -> None: ...
    def fit(self, iterations: int, evenness: float) -> None: ...
    def improve(self, sweeps: int, power: float, stretch: float, evenness: float) -> None: ...
    def untangle(self, sweeps: int, floor: float, seed: int) -> None: ...
    def pin(self, vertices: Ints, face: Ints, weights: NDArray[np.float64]) -> None: ...
    def mend(self, tries: int, seed: int) -> None: ...
    def save(self, slot: int) -> None: ...
    def restore(self, slot: int) -> None: ...
    def quality(self) -> NDArray[np.float64]: ...
    def result(self) -> tuple[NDArray[np.float64], Ints, NDArray[np.float64]]: ...

def minimum_degree(start: Ints, row: Ints) -> Ints: ...
def nested_dissection(start: Ints, row: Ints) -> Ints: ...
def half_edge_twins(origin: Ints, target: Ints, vertices: int) -> Ints: ...
def self_intersections(vertices: NDArray[np.float64], faces: Ints, limit: int) -> Ints: ...
def overlay(
    points_a: NDArray[np.int64],
    faces_a: Ints,
    twins_a: Ints,
    points_b: NDArray[np.int64],
    faces_b: Ints,
    twins_b: Ints,
    boundary: Ints,
    shift: int,
) -> dict[str, Any]: ...
def not_positive(points: NDArray[np.int64], triangles: Ints) -> Ints: ...
def embed_sphere(
    vertices: NDArray[np.float64],
    faces: Ints,
    twins: Ints,
    desired: NDArray[np.float64],
    area_weight: float,
    sweeps: int,
) -> NDArray[np.float64]: ...
def inverted_on_sphere(positions: NDArray[np.float64], faces: Ints) -> Ints: ...
def flood(
    neighbours: Ints,
    normals: NDArray[np.float64],
    centres: NDArray[np.float64],
    seeds: Ints,
    patch_normals: NDArray[np.float64],
    patch_centres: NDArray[np.float64],
    compactness: float,
) -> Ints: ...
def locate_on_sphere(
    sphere: NDArray[np.float64], faces: Ints, twins: Ints, points: NDArray[np.float64]
) -> tuple[Ints, NDArray[np.float64]]: ...
def adapt(
    vertices: NDArray[np.float64],
    ring_start: NDArray[np.int64],
    ring: Ints,
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    winners: Ints,
    steps: int,
    rate_start: float,
    rate_end: float,
    radius_start: float,
    radius_end: float,
    literal: bool,
    seed: int,
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> tuple[NDArray[np.float64], int]: ...
def refine(
    sphere: NDArray[np.float64],
    rest: NDArray[np.float64],
    guide: NDArray[np.float64],
    trust: NDArray[np.float64],
    faces: Ints,
    frozen: NDArray[np.uint8],
    region: Ints,
    outside: NDArray[np.float64],
    target_sphere: NDArray[np.float64],
    target: NDArray[np.float64],
    target_normals: NDArray[np.float64],
    target_faces: Ints,
    target_twins: Ints,
    control_sphere: NDArray[np.float64],
    controls: NDArray[np.float64],
    weights: NDArray[np.float64],
    coarsest: int,
    sweeps: int,
    done: Callable[[float], object],
    seen: Callable[[NDArray[np.float64]], object] | None,
) -> NDArray[np.float64]: ...
def turned_normals(
    weights: NDArray[np.float64],
    rotation_vectors: NDArray[np.float64],
    log_scales: NDArray[np.float64],
    normals: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None: ...
def product(
    start: Ints,
    indices: Ints,
    values: NDArray[np.float64],
    right: NDArray[np.float64],
    add: NDArray[np.float64] | None,
    out: NDArray[np.float64],
) -> None: ...
def fitted_rotations(
    start: Ints,
    indices: Ints,
    weights: NDArray[np.float64],
    rest: NDArray[np.float64],
    displacement: NDArray[np.float64],
    group: Ints,
    before: NDArray[np.float64] | None,
    follow: float,
    rotations: NDArray[np.float64],
) -> None: ...
def turned_edges(
    start: Ints,
    indices: Ints,
    weights: NDArray[np.float64],
    rest: NDArray[np.float64],
    normals: NDArray[np.float64],
    rotations: NDArray[np.float64],
    scale: NDArray[np.float64] | None,
    stretch: NDArray[np.float64],
    bent: NDArray[np.float64],
) -> None: ...
def blended(
    basis: NDArray[np.float64] | NDArray[np.float32],
    coefficients: NDArray[np.float64],
    start: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None: ...
def shifted(
    start: NDArray[np.float64],
    weight: NDArray[np.float64],
    vector: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None: ...
def refined_triangles(
    vertex_count: int, indices: Ints, edges: Ints, corner_edges: Ints
) -> tuple[Ints, Ints, Ints]: ...
def refined_quads(
    vertex_count: int,
    indices: Ints,
    offsets: NDArray[np.int64],
    edges: Ints,
    corner_edges: Ints,
) -> tuple[Ints, Ints, Ints]: ...
def refined_vertices(
    values: NDArray[np.float64], edges: Ints, indices: Ints, offsets: NDArray[np.int64]
) -> NDArray[np.float64]: ...
def smoothing_neighbours(
    vertex_count: int, edges: Ints, corner_edges: Ints
) -> tuple[Ints, Ints]: ...
def smoothed(
    start: Ints,
    neighbours: Ints,
    values: NDArray[np.float64],
    factors: NDArray[np.float64],
    free: NDArray[np.uint8] | None,
    out: NDArray[np.float64],
) -> None: ...
def hat_products(
    vertex_count: int, indices: Ints, corners: int, area: float
) -> tuple[Ints, Ints, NDArray[np.float64]]: ...
def restricted(
    vertex_count: int,
    indices: Ints,
    edges: Ints,
    corner_edges: Ints,
    sides: int,
    area: float,
    values: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None: ...
def add_corrected(
    vertex_count: int,
    indices: Ints,
    edges: Ints,
    corner_edges: Ints,
    sides: int,
    area: float,
    hats: NDArray[np.float64],
    free: NDArray[np.uint8] | None,
    out: NDArray[np.float64],
) -> None: ...
def dual_columns(
    start: Ints,
    indices: Ints,
    values: NDArray[np.float64],
    products_start: Ints,
    products_indices: Ints,
    products: NDArray[np.float64],
) -> tuple[Ints, Ints, NDArray[np.float64]]: ...
def trace_motorcycles(
    vertices: NDArray[np.float64],
    faces: Ints,
    twin: Ints,
    change: NDArray[np.float64],
    matching: NDArray[np.int8],
    track: NDArray[np.int8],
    feature: NDArray[np.uint8],
    kept_off: NDArray[np.uint8],
    starts: Ints,
    meeting: float,
) -> dict[str, Any]: ...
def collapse_chords(
    points: NDArray[np.float64],
    sizes: NDArray[np.float64],
    quads: Ints,
    twin: Ints,
    feature: Ints,
    rank: Ints,
    wished: Ints,
    target: int,
) -> tuple[NDArray[np.float64], Ints, Ints, NDArray[np.uint8], int]: ...
