"""Types of the compiled kernels; each is described at the top of its C++ file."""

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int32]

def half_edge_twins(origin: Ints, target: Ints, vertices: int) -> Ints: ...
