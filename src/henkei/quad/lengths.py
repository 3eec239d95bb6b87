"""How many quad edges every arc gets: integers near the wished lengths that fit all patches.

The integer program of Okabe and Sugihara (2009, 3.2), with the wished scale held and a smoother
cost. Where the patches cannot be fitted, some get more corners (as in 4.1).

Every length stands in at most two equations: a flow in a bidirected network (Heistermann, Warnett,
Bommes 2023). Lengths of least cost that need not be integers are multiples of one half, most of
them integers all the same, and integers of nearly least cost are found close by.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.sparse import csc_array, hstack

from henkei.errors import Infeasible, InvalidInput
from henkei.mesh import Floats
from henkei.progress import Progress, silent
from henkei.quad.length_equations import Equations, lower_bounds, raised_bounds
from henkei.quad.linear_program import LinearProgram
from henkei.quad.metamesh import Indices, MetaMesh, ragged
from henkei.quad.rounding import Network, rounded

TOLERANCE = 0.02  # of the number of quads
ROUNDS = 10  # of changes of scale, in integers
SAME_WISHES = 2  # of these rounds, before wishes are changed a little
SPREAD = 0.05  # part by which they are changed
COARSE = np.concatenate([-(2 ** np.arange(10, 1, -1)), np.arange(-3, 5), 2 ** np.arange(3, 11)])
FINE = np.arange(-3, 5)  # around lengths that need not be integers
SPOKE_WEIGHT = 0.25


@dataclass(frozen=True, eq=False)
class Lengths:
    """Numbers of quad edges.

    meta : the meta-mesh with the corners that finally hold.
    arcs : (a,) of each arc. It is 0 only where two T-junctions, from opposite sides of one line,
        become one crossing.
    spoke_start : (p + 1,) offsets into ``spokes``: as many as corners for patches that are not
        rectangles, none for rectangles.
    spokes : number along the spoke from the centre of such a patch to each of its sides.
    quads : number of quads that follow from these.
    relaxed : patches that could not be fitted as they were; now every node on their rims is a
        corner.
    """

    meta: MetaMesh
    arcs: Indices
    spoke_start: Indices
    spokes: Indices
    quads: int
    relaxed: Indices


def integer_lengths(
    meta: MetaMesh,
    *,
    quads: int | None = None,
    fewest: Indices | None = None,
    progress: Progress = silent,
) -> Lengths:
    """Lengths of all arcs and spokes, as near as can be to the wished ones.

    quads : wished number of quads; the wished lengths are scaled until it is met within two
        percent, or as well as lengths allow. They are not scaled where it is None. If even the
        shortest lengths make more, the answer is near these: see :func:`fewest_quads`.
    fewest : (a,) lower bounds of the arcs' lengths.

    Raises
    ------
    InvalidInput : corners are not chosen, or ``quads`` is below one.
    """
    if quads is not None and quads < 1:
        raise InvalidInput(f"the number of quads must be at least 1, not {quads}")
    meta, relaxed = _solvable(meta)
    lower = lower_bounds(meta)
    if fewest is not None:
        lower = np.maximum(lower, np.where(fewest > 1, fewest, 0))
    if quads is None:
        return _lengths(meta, relaxed, lower, lambda problem: problem.integers(1.0))
    return _lengths(meta, relaxed, lower, lambda problem: problem.scaled_to(quads, progress))


def fewest_quads(meta: MetaMesh) -> int:
    """Number of quads of the shortest lengths (their sum is least) that fit all patches.

    Raises
    ------
    InvalidInput : corners are not chosen.
    """
    meta, relaxed = _solvable(meta)
    return _lengths(meta, relaxed, lower_bounds(meta), lambda problem: problem.integers(0.0)).quads


def _lengths(
    meta: MetaMesh, relaxed: Indices, lower: Indices, solve: Callable[[_Problem], Indices]
) -> Lengths:
    """The lengths that ``solve`` finds, with lower bounds of arcs raised as far as must be."""
    while True:
        problem = _Problem.of(meta, lower)
        x = solve(problem)
        raised = raised_bounds(meta, x[: len(lower)], lower)
        if np.array_equal(raised, lower):
            break
        lower = raised
    equations = problem.equations
    arcs, spokes = np.split(x, [len(lower)])
    return Lengths(meta, arcs, equations.spoke_start, spokes, round(equations.quads(x)), relaxed)


@dataclass(frozen=True, eq=False)
class _Problem:
    """To find the lengths of least cost among those that fulfil equations.

    wished, weight : (n,) wished lengths and the weights of deviations from them.
    """

    equations: Equations
    network: Network
    wished: Floats
    weight: Floats

    @classmethod
    def of(cls, meta: MetaMesh, lower: Indices) -> _Problem:
        """The lengths of a meta-mesh whose arcs have lower bounds."""
        equations = Equations.of(meta, lower)
        spokes = equations.wished_spokes(meta.arc_length)
        return cls(
            equations,
            Network.of(equations.matrix[: equations.equal]),
            np.concatenate([meta.arc_length, spokes]),
            np.repeat([1.0, SPOKE_WEIGHT], [len(lower), len(spokes)]),
        )

    def scaled_to(self, quads: int, progress: Progress) -> Indices:
        """Integer lengths, the wished ones scaled so that they make so many quads.

        Where many lengths jump at one scale, past the wished number, each is wished a little
        longer or shorter, so that they do so one after the other.
        """
        problem, scale = self, self._scale(quads)
        tried: list[tuple[float, float]] = []  # scales, and the numbers of quads they make
        found: list[tuple[float, int, Indices]] = []  # by how much these miss what is wished
        for step in range(ROUNDS):
            progress("lengths of arcs", step / ROUNDS)
            x = problem.integers(scale)
            tried.append((scale, self.equations.quads(x)))
            found.append((abs(tried[-1][1] - quads), step, x))
            if min(found)[0] <= TOLERANCE * quads:
                break
            if step == SAME_WISHES:
                chance = np.random.default_rng(0).uniform(-SPREAD, SPREAD, len(x))
                problem = replace(self, wished=self.wished * (1 + chance))
            scale = _next_scale(tried, quads)
        return min(found)[2]

    def _scale(self, quads: int) -> float:
        """The scale at which lengths that need not be integers make so many quads."""
        scale = 1.0
        for _ in range(6):
            ratio = quads / self.equations.quads(self._continuous(scale))
            scale *= np.sqrt(ratio)
            if abs(ratio - 1) < TOLERANCE / 2:
                break
        return scale

    def integers(self, scale: float) -> Indices:
        """Integer lengths of nearly least cost at one scale of the wished lengths."""
        near = np.floor(self._continuous(scale) + 1e-6)[:, None]
        base, of, program = self._program(scale, near + FINE)
        found = program.solve()
        x = rounded(
            self.network,
            base + np.bincount(of, found.x, len(base)),
            found.prices[: self.equations.equal],
            partial(self._steps, scale),
        )
        return self._doubled(scale) if x is None else x

    def _doubled(self, scale: float) -> Indices:
        """Twice the lengths for half the scale, of which none is zero: multiples of one half."""
        positive = replace(self, equations=self.equations.without_zeros())
        twice = np.rint(2 * positive._continuous(scale / 2)).astype(np.int64)
        if not self.equations.hold(twice):
            raise Infeasible("no whole numbers of quad edges were found that fit all patches")
        return twice

    def _continuous(self, scale: float) -> Floats:
        """Lengths of least cost that need not be integers."""
        lowest = self.equations.lower[:, None]
        centre = np.floor(scale * self.wished)[:, None]
        base, of, program = self._program(scale, np.hstack([lowest, centre + COARSE]))
        upper = program.upper.copy()
        upper[np.flatnonzero(np.diff(of, append=-1))] = np.inf
        found = replace(program, upper=upper).solve()
        return base + np.bincount(of, found.x, len(base))

    def _program(self, scale: float, points: Floats) -> tuple[Floats, Indices, LinearProgram]:
        """Lengths as sums of steps from one of their ``points`` (n, k) to the next, each of which
        costs more than the last: the least lengths, the length each step is of, and the program."""
        equations = self.equations
        points = np.maximum(equations.lower[:, None], points).astype(np.float64)
        cost = self.weight[:, None] * _deviation(points, scale * self.wished[:, None])
        width = np.diff(points, axis=1)
        of, step = np.nonzero(width)
        base = points[:, 0]
        rows = equations.matrix @ base
        program = LinearProgram(
            cost=np.diff(cost, axis=1)[of, step] / width[of, step],
            upper=width[of, step],
            matrix=equations.matrix[:, of],
            row_lower=equations.row_lower - rows,
            row_upper=equations.row_upper - rows,
        )
        return base, of, program

    def _steps(self, scale: float, x: Indices) -> tuple[Floats, Floats]:
        """Cost of raising and of lowering each of integer lengths by one; infinite if a length or
        a side would become too short."""
        around = np.maximum(x[:, None] + np.arange(-1, 2), 0).astype(np.float64)
        cost = self.weight[:, None] * _deviation(around, scale * self.wished[:, None])
        shortest = self.equations.too_short(x)
        lowered = np.where(shortest, np.inf, cost[:, 0] - cost[:, 1])
        return cost[:, 2] - cost[:, 1], lowered


def _next_scale(tried: list[tuple[float, float]], quads: int) -> float:
    """A scale between those that made too few and too many quads; else a better one than the
    last."""
    few = [scale for scale, count in tried if count < quads]
    many = [scale for scale, count in tried if count > quads]
    if few and many and max(few) < min(many):
        return float(np.sqrt(max(few) * min(many)))
    scale, count = tried[-1]
    return float(scale * np.sqrt(quads / count))


def _deviation(length: Floats, wished: Floats) -> Floats:
    """Sum over the quad edges of an arc of the squared relative deviations of their lengths.

    For no quad edge, the squared length; more where the function would not be convex.
    """

    def positive(length: Floats) -> Floats:
        deviation: Floats = (length - wished) ** 2 / length
        return deviation

    none = np.maximum(wished**2, 2 * positive(np.ones(1)) - positive(np.full(1, 2.0)))
    return np.where(length < 1, none, positive(np.maximum(length, 1)))


def _solvable(meta: MetaMesh) -> tuple[MetaMesh, Indices]:
    """A meta-mesh whose equations have a solution; and the patches that were changed for that.

    All nodes on the rims of the patches to blame become corners. If that happened to all patches,
    arcs of length 2 and spokes of length 1 would be a solution.
    """
    relaxed = np.empty(0, dtype=np.int64)
    while len(blamed := _to_blame(meta)):
        turn = meta.chosen_turn.copy()
        turn[np.isin(ragged(np.diff(meta.rim_start))[0], blamed) & (turn < 1)] = 1
        meta = replace(meta, rim_turn=turn)
        relaxed = np.concatenate([relaxed, blamed])
    return meta, np.sort(relaxed)


def _to_blame(meta: MetaMesh) -> Indices:
    """Patches in whose equations something is missing, the sum of it being least; of those only
    that have nodes without a corner."""
    equations = Equations.of(meta, lower_bounds(meta))
    straight = np.diff(meta.rim_start) - equations.sides.corner_count
    row = np.flatnonzero((straight[equations.row_patch] > 0) & (equations.row_upper == 0))
    at = np.arange(len(row))
    missing = csc_array((np.ones(len(row)), (row, at)), shape=(len(equations.row_patch), len(row)))
    rows = equations.matrix @ equations.lower
    price = straight[equations.row_patch[row]].astype(np.float64)
    cost = np.concatenate([np.zeros(len(equations.lower)), price, price])
    program = LinearProgram(
        cost=cost,
        upper=np.full(len(cost), np.inf),
        matrix=hstack([equations.matrix, missing, -missing], format="csc"),
        row_lower=equations.row_lower - rows,
        row_upper=equations.row_upper - rows,
    )
    found = program.solve()
    lack = found.x[len(equations.lower) :].reshape(2, -1).max(axis=0)
    return np.unique(equations.row_patch[row[lack > 1e-6]])
