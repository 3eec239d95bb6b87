"""Types of the compiled kernels; each is described at the top of its C++ file."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int32]

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
