"""Linear programs, in integers or not, by HiGHS: with limits that are counted, not timed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from henkei.errors import Infeasible
from henkei.mesh import Floats


@dataclass(frozen=True, eq=False)
class Solution:
    """Values ``(n,)`` of the unknowns; and dual values ``(r,)`` of the rows, by how much the cost
    rises with their bounds (of no use for integers)."""

    x: Floats
    prices: Floats


@dataclass(frozen=True, eq=False)
class LinearProgram:
    """Minimise ``cost @ x`` under bounds of ``matrix @ x`` and ``0 <= x <= upper``.

    cost, upper : (n,); upper may be infinite.
    matrix : (r, n).
    row_lower, row_upper : (r,); equal where a row is an equation.
    """

    cost: Floats
    upper: Floats
    matrix: csc_array
    row_lower: Floats
    row_upper: Floats

    def solve(
        self, *, integer: bool | NDArray[np.bool_] = False, gap: float = 0.01, nodes: int = 200
    ) -> Solution:
        """The solution of least cost.

        integer : whether all of ``x``, or which of it, must be integers; these are rounded exactly.
        gap : the cost of integers may be above the least by this part of it.
        nodes : limit of the branch and bound.

        Raises
        ------
        Infeasible : there is no solution, or none in integers is found within the limits.
        """
        import highspy

        solver = highspy.Highs()  # type: ignore[no-untyped-call]
        for option, value in {
            "output_flag": False,
            "threads": 1,
            "random_seed": 0,
            "mip_rel_gap": gap,
            "mip_max_nodes": nodes,
        }.items():
            solver.setOptionValue(option, value)
        problem = highspy.HighsLp()
        problem.num_row_, problem.num_col_ = self.matrix.shape
        problem.col_cost_ = self.cost
        problem.col_lower_ = np.zeros_like(self.cost)
        problem.col_upper_ = self.upper
        problem.row_lower_, problem.row_upper_ = self.row_lower, self.row_upper
        problem.a_matrix_.format_ = highspy.MatrixFormat.kColwise
        problem.a_matrix_.start_ = self.matrix.indptr
        problem.a_matrix_.index_ = self.matrix.indices
        problem.a_matrix_.value_ = self.matrix.data
        whole = np.broadcast_to(integer, self.cost.shape)
        if whole.any():
            kind = highspy.HighsVarType
            problem.integrality_ = [kind.kInteger if w else kind.kContinuous for w in whole]
        solver.passModel(problem)
        solver.run()
        solved = highspy.SolutionStatus.kSolutionStatusFeasible
        if solver.getInfo().primal_solution_status != solved:
            state = solver.modelStatusToString(solver.getModelStatus())
            size = " by ".join(str(extent) for extent in self.matrix.shape)
            raise Infeasible(f"a linear program ({size}) of the quad layout ended: {state}")
        found = solver.getSolution()
        x = np.array(found.col_value)
        return Solution(np.where(whole, np.rint(x), x), np.array(found.row_dual))
