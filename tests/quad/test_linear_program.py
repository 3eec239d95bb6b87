import numpy as np
import pytest
from scipy.sparse import csc_array

from henkei.errors import Infeasible
from henkei.quad.linear_program import LinearProgram


def program(rows: list[list[float]], least: list[float], cost: list[float]) -> LinearProgram:
    """At least so much of each row."""
    lower = np.array(least, dtype=float)
    return LinearProgram(
        cost=np.array(cost, dtype=float),
        upper=np.full(len(cost), 3.0),
        matrix=csc_array(np.array(rows, dtype=float)),
        row_lower=lower,
        row_upper=np.full_like(lower, np.inf),
    )


def test_solution_and_prices_fulfil_duality() -> None:
    wanted = program([[1, 2], [3, 1]], [4, 6], [1, 1])
    found = wanted.solve()
    np.testing.assert_allclose(found.x, [1.6, 1.2])
    assert found.prices @ [4, 6] == pytest.approx(found.x.sum())


def test_integers_are_exact_and_only_where_asked_for() -> None:
    wanted = program([[1, 2], [3, 1]], [4, 6], [1, 1])
    whole = wanted.solve(integer=True).x
    assert whole.sum() == 3
    assert (whole == whole.astype(int)).all()
    mixed = wanted.solve(integer=np.array([True, False])).x
    assert mixed[0] == 2
    assert mixed[1] == pytest.approx(1)


def test_what_has_no_solution_is_told() -> None:
    with pytest.raises(Infeasible, match=r"1 by 2\) of the quad layout ended: Infeasible"):
        program([[1, 1]], [7], [1, 1]).solve()
