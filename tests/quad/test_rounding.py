import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import Bounds, LinearConstraint, linprog, milp
from scipy.sparse import csc_array

from henkei.quad.rounding import Network, Steps, rounded

MOST = 9


def random_network(seed: int, rows: int, columns: int) -> np.ndarray:
    """A matrix whose columns have absolute sums of two, now and then of one or none."""
    chance = np.random.default_rng(seed)
    matrix = np.zeros((rows, columns))
    for column in range(columns):
        for _ in range(chance.choice([0, 1, 2, 2, 2, 2, 2, 2])):
            matrix[chance.integers(rows), column] += chance.choice([-1, 1])
    return matrix


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 10**6), rows=st.integers(1, 8), more=st.integers(1, 12))
def test_halves_become_integers_that_solve_the_same_equations(
    seed: int, rows: int, more: int
) -> None:
    """Against the least cost that branch and bound finds; all is told from one solution on."""
    matrix = random_network(seed, rows, rows + more)
    chance = np.random.default_rng(seed)
    rate = chance.uniform(0.1, 1, matrix.shape[1])
    origin = chance.integers(0, 6, matrix.shape[1])
    sums = matrix @ origin
    vertex = linprog(rate, A_eq=matrix, b_eq=sums, bounds=(0, MOST), method="highs-ds")
    best = milp(
        rate,
        integrality=np.ones(len(rate)),
        bounds=Bounds(0, MOST),
        constraints=LinearConstraint(matrix, sums, sums),
        options={"mip_rel_gap": 0},
    )

    def steps(change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x = origin + change
        return np.where(x < MOST, rate, np.inf), np.where(x > 0, -rate, np.inf)

    network = Network.of(csc_array(matrix))
    found = rounded(network, vertex.x - origin, vertex.eqlin.marginals, steps)
    assume(found is not None)
    np.testing.assert_array_equal(matrix @ found, 0)
    assert (origin + found).min() >= 0
    assert (origin + found).max() <= MOST
    assert rate @ (origin + found) >= best.fun - 1e-9


# 2 a = p + q and 2 b = p + q
PAIR = Network.of(csc_array(np.array([[2, 0, -1, -1], [0, 2, -1, -1]])))


def linear(*rate: float) -> Steps:
    return lambda _: (np.array(rate), np.array(rate))


def test_two_odd_walks_are_mended_along_the_cheaper_way_between_them() -> None:
    halves = np.array([0.5, 0.5, 1, 0])
    a, b, p, q = rounded(PAIR, halves, np.zeros(2), linear(0, 0, 1, 9))
    assert a == b
    assert (p, q) in ((2, 0), (0, 0))
    a, b, p, q = rounded(PAIR, halves, np.zeros(2), linear(0, 0, 9, 1))
    assert a == b
    assert (p, q) in ((1, 1), (1, -1))


def test_what_cannot_be_mended_or_is_no_half_gives_none() -> None:
    none, forbidden = np.zeros(2), linear(0, 0, np.inf, np.inf)
    assert rounded(PAIR, np.array([0.5, 0.5, 1, 0]), none, forbidden) is None
    assert rounded(PAIR, np.array([0.25, 0.25, 0.5, 0]), none, linear(0, 0, 1, 1)) is None
    whole = rounded(PAIR, np.array([1.0, 1, 1, 1]), none, forbidden)
    assert whole.tolist() == [1, 1, 1, 1]


def test_an_odd_walk_ends_where_an_unknown_is_in_one_equation_only() -> None:
    network = Network.of(csc_array(np.array([[2, -1]])))
    a, c = rounded(network, np.array([0.5, 1]), np.zeros(1), linear(0, 1))
    assert 2 * a == c
