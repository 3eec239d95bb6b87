"""The kernels of a design against plain loops and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csc_array, csr_array, random_array
from scipy.sparse.linalg import splu

from cages import CAGES, WAYS
from henkei import _kernels
from henkei.design.refinement import Connectivity, connectivity, refined
from henkei.mesh import Mesh
from oracles import subdivision

ways = pytest.mark.parametrize(("name", "quads"), WAYS)
seeds = st.integers(0, 2**32 - 1)
columns = st.sampled_from([1, 2, 3, 4, 7, 8, 9, 12, 19])


def faces_of(c: Connectivity) -> list[list[int]]:
    return [face.tolist() for face in np.split(c.indices, c.offsets[1:-1])]


def neighbours_of(c: Connectivity) -> tuple[np.ndarray, np.ndarray]:
    return _kernels.smoothing_neighbours(c.vertex_count, c.edges, c.corner_edges)


def rings_of(c: Connectivity) -> list[list[int]]:
    start, neighbours = neighbours_of(c)
    assert start.dtype == neighbours.dtype == np.int32
    return [ring.tolist() for ring in np.split(neighbours, start[1:-1])]


def hat_products(c: Connectivity, area: float) -> csr_array:
    start, indices, values = _kernels.hat_products(c.vertex_count, c.indices, int(c.sizes[0]), area)
    return csr_array((values, indices, start), shape=(c.vertex_count, c.vertex_count))


def dual_columns(rows: csr_array, products: csr_array) -> csc_array:
    start, indices, values = _kernels.dual_columns(
        rows.indptr, rows.indices, rows.data, products.indptr, products.indices, products.data
    )
    return csc_array((values, indices, start), shape=rows.shape[::-1])


@ways
def test_neighbours_are_ascending_and_on_the_boundary_along_it(name: str, quads: bool) -> None:
    c = connectivity(CAGES[name]())
    for _ in range(2):
        edges = [(a, b) for a, b in c.edges.tolist()]
        assert rings_of(c) == subdivision.neighbours(c.vertex_count, faces_of(c), edges)
        c = refined(c, quads)


def test_an_edge_between_boundary_vertices_is_no_boundary() -> None:
    """Two triangles: the diagonal joins two vertices of the boundary."""
    c = connectivity(Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]))
    assert rings_of(c) == [[1, 3], [0, 2], [1, 3], [0, 2]]


@given(seeds, columns, st.booleans())
def test_smoothing_moves_to_the_mean_of_neighbours(seed: int, width: int, masked: bool) -> None:
    rng = np.random.default_rng(seed)
    name, quads = WAYS[seed % len(WAYS)]
    c = refined(connectivity(CAGES[name]()), quads)
    start, neighbours = neighbours_of(c)
    values = rng.normal(size=(c.vertex_count, width))
    factors = rng.uniform(-1, 1, width)
    free = rng.integers(0, 2, c.vertex_count).astype(np.uint8)
    out = np.full_like(values, np.nan)
    _kernels.smoothed(start, neighbours, values, factors, free if masked else None, out)
    moving = free if masked else np.ones_like(free)
    expected = subdivision.smoothed(rings_of(c), values, factors, moving)
    np.testing.assert_allclose(out, expected, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(out[moving == 0], values[moving == 0])


@given(seeds, columns)
def test_a_column_is_smoothed_alike_in_any_company(seed: int, width: int) -> None:
    rng = np.random.default_rng(seed)
    c = refined(connectivity(CAGES["open sheet of triangles"]()), quads=bool(seed % 2))
    start, neighbours = neighbours_of(c)
    values, factors = rng.normal(size=(c.vertex_count, width)), rng.uniform(-1, 1, width)
    out = np.empty_like(values)
    _kernels.smoothed(start, neighbours, values, factors, None, out)
    for k in range(width):
        alone = np.empty((c.vertex_count, 1))
        own = np.ascontiguousarray(values[:, k : k + 1])
        _kernels.smoothed(start, neighbours, own, factors[k : k + 1], None, alone)
        np.testing.assert_array_equal(alone[:, 0], out[:, k])


@pytest.mark.parametrize("width", [1, 3, 5])
def test_vertices_without_neighbours_stay(width: int) -> None:
    values = np.random.default_rng(0).normal(size=(4, width))
    start, neighbours = np.array([0, 0, 1, 2, 2], np.int32), np.array([2, 1], np.int32)
    out = np.full_like(values, np.nan)
    _kernels.smoothed(start, neighbours, values, np.ones(width), None, out)
    np.testing.assert_allclose(out, values[[0, 2, 1, 3]], rtol=1e-15)


def test_smoothing_refuses_arrays_that_do_not_fit() -> None:
    values, none = np.zeros((2, 3)), np.zeros(3, np.int32)
    for arguments in [
        (none, none[:0], values, np.ones(2), None, np.empty((2, 3))),
        (none, none[:0], values, np.ones(3), None, np.empty((3, 3))),
        (none, none[:1], values, np.ones(3), None, np.empty((2, 3))),
        (none, none[:0], values, np.ones(3), np.ones(3, np.uint8), np.empty((2, 3))),
        (none, none[:0], values, np.ones(3), None, values),
    ]:
        with pytest.raises(ValueError, match=r"differ|one"):
            _kernels.smoothed(*arguments)


@ways
def test_products_of_hats_are_their_integrals(name: str, quads: bool) -> None:
    c = refined(connectivity(CAGES[name]()), quads)
    products = hat_products(c, 0.25)
    assert products.indices.dtype == products.indptr.dtype == np.int32
    assert products.has_canonical_format
    expected = subdivision.hat_products(c.vertex_count, faces_of(c), 0.25)
    np.testing.assert_allclose(products.toarray(), expected, rtol=0, atol=1e-16)
    np.testing.assert_array_equal(products.toarray(), products.toarray().T)
    assert products.nnz == np.count_nonzero(expected)


def test_products_add_up_where_faces_share_all_their_vertices() -> None:
    c = connectivity(Mesh(np.eye(3), [[0, 1, 2], [0, 2, 1]]))
    np.testing.assert_allclose(hat_products(c, 6.0).toarray(), 1 + np.eye(3), rtol=1e-15)


@given(seeds, columns, st.booleans())
def test_products_with_any_number_of_columns(seed: int, width: int, added: bool) -> None:
    rng = np.random.default_rng(seed)
    rows, inner = rng.integers([0, 1], 30)
    matrix = csr_array(random_array((rows, inner), density=0.2, rng=rng, format="csr"))
    start, indices = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32)
    right, add = rng.normal(size=(inner, width)), rng.normal(size=(rows, width))
    expected = matrix @ right + (add if added else 0)
    out = np.full((rows, width), np.nan)
    _kernels.product(start, indices, matrix.data, right, add if added else None, out)
    np.testing.assert_allclose(out, expected, rtol=0, atol=1e-13)
    if added:
        _kernels.product(start, indices, matrix.data, right, add, add)
        np.testing.assert_array_equal(add, out)


def test_products_refuse_other_numbers_of_columns() -> None:
    start, indices, values = np.array([0, 1], np.int32), np.array([0], np.int32), np.ones(1)
    for right, add in [(2, None), (3, 2)]:
        with pytest.raises(ValueError, match="columns"):
            _kernels.product(
                start,
                indices,
                values,
                np.ones((1, right)),
                add and np.ones((1, add)),
                np.ones((1, 3)),
            )


@given(seeds)
def test_dual_columns_solve_with_the_products(seed: int) -> None:
    rng = np.random.default_rng(seed)
    name, quads = WAYS[seed % len(WAYS)]
    c = refined(connectivity(CAGES[name]()), quads)
    c = refined(c, quads) if c.vertex_count < 60 else c
    products = hat_products(c, 0.25)
    rows = csr_array(random_array((7, c.vertex_count), density=0.05, rng=rng, format="csr"))
    rows.data -= 0.3
    found = dual_columns(rows, products)
    assert found.has_canonical_format
    expected = splu(products.tocsc()).solve(rows.T.toarray())
    size = np.abs(expected).max(axis=0, initial=1e-300)
    assert (np.abs(found.toarray() - expected) <= 1e-13 * size).all()


def test_dual_columns_stay_where_they_matter() -> None:
    """They die away from ring to ring, so a column does not grow with the surface."""
    entries = []
    for level in (5, 6):
        c = connectivity(CAGES["tetrahedron"]())
        for _ in range(level):
            c = refined(c, quads=True)
        products = hat_products(c, 1.0)
        rows = csr_array(([0.5, 0.5], ([0, 0], c.edges[-1])), shape=(1, c.vertex_count))
        found = dual_columns(rows, products)
        assert np.abs(products @ found.toarray() - rows.T.toarray()).max() < 1e-15
        assert np.abs(found.data).min() > 1e-17 * np.abs(found.data).max()
        entries.append(found.nnz)
    assert entries[1] < 0.2 * c.vertex_count
    assert abs(entries[1] - entries[0]) < 0.2 * entries[0]


def test_a_row_of_zeros_has_an_empty_dual_column() -> None:
    c = refined(connectivity(CAGES["cube"]()), quads=True)
    start, place = np.array([0, 0, 2, 3]), np.array([3, 4, 3])
    rows = csr_array((np.array([0.0, 0.0, 1.0]), place, start), shape=(3, c.vertex_count))
    found = dual_columns(rows, hat_products(c, 1.0))
    assert np.diff(found.indptr).tolist()[:2] == [0, 0]
    np.testing.assert_allclose((hat_products(c, 1.0) @ found[:, [2]]).toarray()[3], 1, rtol=1e-14)
