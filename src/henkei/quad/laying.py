"""The two ways to a layout: along a cross field, and by shape approximation (the paper's)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.remeshing import remeshed
from henkei.geometry.weights import half_edge_lengths
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, part
from henkei.quad.crossfield import cross_field
from henkei.quad.disks import vsa_layout
from henkei.quad.layout import Layout
from henkei.quad.motorcycles import motorcycle_layout
from henkei.quad.seamless import seamless_gradients
from henkei.quad.timing import Clock
from henkei.quad.wishes import Wish

MEETING = (0.5, 0.25, 0.0)  # see motorcycle_layout, tried in turn
MANY, COARSER = 8000, 1.6  # quads from which triangles are longer, and up to how many times
QUADS_PER_PATCH = 12.0  # of the layout by shape approximation


@dataclass(frozen=True)
class Ground:
    """A component remeshed, for a layout to run on.

    feature : (3 m,) bool, half-edges along creases and boundaries.
    corners : (c, 3) positions of the corners of features.
    sizes : wished edge length of quads at vertices (n,).
    """

    mesh: Mesh
    feature: NDArray[np.bool_]
    corners: Floats
    sizes: Floats


def prepared(
    mesh: Mesh, feature: NDArray[np.bool_], wish: Wish, fineness: float, progress: Progress
) -> Ground:
    """The surface in triangles ``fineness`` times as long as the wished quads, if these are few;
    many quads have less to do with single triangles."""
    length = fineness * float(np.clip(np.sqrt(wish.quads / MANY), 1.0, COARSER)) * wish.sizes
    fine = remeshed(mesh, length, feature=feature, progress=progress)
    sizes = fine.on_input.pull(mesh, wish.sizes)
    return Ground(fine.mesh, fine.feature, fine.mesh.vertices[fine.corner], sizes)


def field_layouts(ground: Ground, clock: Clock, progress: Progress) -> Iterator[Layout]:
    """Layouts along one cross field: few wide patches first, at last those that surely fit."""
    size = ground.sizes[ground.mesh.faces].mean(axis=1)
    mean = float(np.sqrt((size**2).mean()))
    with clock("cross field"):
        field = cross_field(ground.mesh, ground.feature, mean, progress=part(progress, 0, 0.3))
    with clock("seamless map"):
        gradients = seamless_gradients(field, size, progress=part(progress, 0.3, 0.9))
    for meeting in MEETING:
        with clock("motorcycle graph"):
            layout = motorcycle_layout(
                gradients, meeting=meeting, progress=part(progress, 0.9, 1.0)
            )
        yield layout


def shape_layouts(
    ground: Ground,
    wish: Wish,
    patches: int | None,
    seed: int,
    clock: Clock,
    progress: Progress,
) -> Iterator[Layout]:
    """The layout by variational shape approximation."""
    mesh, sizes = ground.mesh, ground.sizes
    length = half_edge_lengths(mesh) * 2 / (sizes[mesh.indices] + sizes[mesh.topology.target])
    count = max(6, round(wish.quads / QUADS_PER_PATCH)) if patches is None else patches
    with clock("shape approximation"):
        layout = vsa_layout(
            mesh, ground.feature, length, patches=count, seed=seed, progress=progress
        )
    yield layout
