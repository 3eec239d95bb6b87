"""Inner products with coarser hats, by stencils on faces, against plain integrals and matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cages import CAGES, WAYS, faces_of
from henkei import _kernels
from henkei.design.levels import Level, Levels
from henkei.design.local_refinement import refined_in_part
from henkei.design.refinement import connectivity, refined
from oracles import subdivision

ways = pytest.mark.parametrize(("name", "quads"), WAYS)
ROUNDING = 1e-15
WIDTHS = (1, 2, 3, 5)


def finest(name: str, quads: bool, count: int = 2) -> Level:
    return Levels.of(connectivity(CAGES[name]()), count, quads)[count]


def integrals(level: Level) -> np.ndarray:
    """P' I, integrals of fine hats times coarse ones: fine hats by quadrature on fine faces."""
    coarse, fine = level.coarse, level.connectivity
    assert coarse is not None
    edges = [(a, b) for a, b in coarse.edges.tolist()]
    means = subdivision.averages(coarse.vertex_count, faces_of(coarse), edges, level.quads)
    area = 4.0**-level.number
    return means.T @ subdivision.hat_products(fine.vertex_count, faces_of(fine), area)


def close(found: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING * abs(expected).max())


@ways
@pytest.mark.parametrize("count", [1, 2])
def test_stencils_integrate_products_of_hats(name: str, quads: bool, count: int) -> None:
    """And so do the matrices, which do where faces are not all alike."""
    level = finest(name, quads, count)
    expected = integrals(level)
    rng = np.random.default_rng(count)
    for width in WIDTHS:
        values = rng.normal(size=(level.size, width))
        hats = rng.normal(size=(len(expected), width))
        close(level.restricted(values), expected @ values)
        close(level.restriction @ values, expected @ values)
        out = values.copy()
        level.add_corrected(hats, out)
        close(out, values + expected.T @ hats)
        close(values + level.correction @ hats, values + expected.T @ hats)


@ways
def test_vertices_that_may_not_move_stay_to_the_bit(name: str, quads: bool) -> None:
    whole = finest(name, quads)
    rng = np.random.default_rng(0)
    free = rng.integers(0, 2, whole.size).astype(np.uint8)
    level = Level(2, whole.connectivity, quads, whole.prolongation, free, whole.coarse)
    for width in WIDTHS:
        values = rng.normal(size=(level.size, width))
        hats = rng.normal(size=(whole.coarse.vertex_count, width))
        out, everywhere = values.copy(), values.copy()
        level.add_corrected(hats, out)
        whole.add_corrected(hats, everywhere)
        np.testing.assert_array_equal(out, np.where(free[:, None], everywhere, values))
        close(out, values + level.correction @ hats)


@ways
def test_where_only_some_faces_are_refined_others_have_no_part_in_it(
    name: str, quads: bool
) -> None:
    coarse = finest(name, quads, 1)
    partial = refined_in_part(coarse, np.arange(0, coarse.connectivity.face_count, 2))
    level = replace(partial, coarse=coarse.connectivity)
    values = np.random.default_rng(0).normal(size=(level.size, 3))
    np.testing.assert_array_equal(level.restricted(values), partial.restricted(values))


@ways
def test_every_column_is_alone_what_it_is_among_three(name: str, quads: bool) -> None:
    """Three are computed at once, as rows of four numbers."""
    level = finest(name, quads)
    values = np.random.default_rng(0).normal(size=(level.size, 3))
    hats, out = level.restricted(values), values.copy()
    level.add_corrected(hats, out)
    for column in range(3):
        alone = np.ascontiguousarray(values[:, [column]])
        found = level.restricted(alone)
        level.add_corrected(found, alone)
        np.testing.assert_array_equal(found[:, 0], hats[:, column])
        np.testing.assert_array_equal(alone[:, 0], out[:, column])


def test_sizes_are_checked() -> None:
    c = connectivity(CAGES["tetrahedron"]())
    fine = np.zeros((refined(c, False).vertex_count, 3))
    hats = np.zeros((c.vertex_count, 3))
    coarse = (c.vertex_count, c.indices, c.edges, c.corner_edges)
    with pytest.raises(ValueError, match="sides"):
        _kernels.restricted(*coarse, 5, 1.0, fine, hats)
    with pytest.raises(ValueError, match="finer level"):
        _kernels.restricted(*coarse, 4, 1.0, fine, hats)
    with pytest.raises(ValueError, match="coarser level"):
        _kernels.restricted(*coarse, 3, 1.0, fine, fine)
    with pytest.raises(ValueError, match="columns"):
        _kernels.add_corrected(*coarse, 3, 1.0, np.zeros((4, 2)), None, fine)
    with pytest.raises(ValueError, match="vertices"):
        _kernels.add_corrected(*coarse, 3, 1.0, hats, np.zeros(3, np.uint8), fine)
