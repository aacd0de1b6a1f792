"""A sparse linear programme solved to the last digits, with the dual value of each row."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from packgen.arrays import Float64Array

EXACT = 1.0e-10
"""Largest violation of a row and of a dual row: the least that HiGHS takes."""

MANY = 900
"""Columns from which the interior-point method is the faster one; it ends at a corner, too."""


class NoSolutionError(ArithmeticError):
    """A programme without a solution, or one that the solver did not find."""


@dataclass(frozen=True, eq=False, slots=True)
class Solution:
    """The solution of a programme.

    Attributes:
        value: Value of each column, shape (n,), float64.
        dual: What a unit more of each row's bound would add to the objective, at least 0, shape (m,).
        objective: What was reached.
    """

    value: Float64Array
    dual: Float64Array
    objective: float


@dataclass(frozen=True, eq=False, slots=True)
class Programme:
    """Maximise ``gain @ x`` where ``rows @ x <= most``, ``equal @ x = 0`` and ``low <= x <= high``.

    Attributes:
        gain: Shape (n,), float64.
        rows: Shape (m, n).
        most: Shape (m,), float64.
        equal: Shape (k, n); None: there is no such row.
        low: Shape (n,), float64; -inf where there is no bound.
        high: Shape (n,), float64.
    """

    gain: Float64Array
    rows: csr_array
    most: Float64Array
    equal: csr_array | None
    low: Float64Array
    high: Float64Array


def solve(programme: Programme) -> Solution:
    """Solve a programme with HiGHS, at a corner of what is possible.

    Raises:
        NoSolutionError: It has none, or it was not found.
    """
    from scipy import optimize

    linprog: Any = optimize.linprog  # its stubs know no sparse arrays
    first, second = ("highs-ipm", "highs-ds") if len(programme.gain) > MANY else ("highs-ds", "highs-ipm")
    equal = programme.equal
    for method in (first, second):
        found = linprog(
            -programme.gain,
            A_ub=programme.rows,
            b_ub=programme.most,
            A_eq=equal,
            b_eq=None if equal is None else np.zeros(equal.shape[0]),
            bounds=np.column_stack([programme.low, programme.high]),
            method=method,
            options={"primal_feasibility_tolerance": EXACT, "dual_feasibility_tolerance": EXACT},
        )
        if found.status == 0:
            return Solution(found.x, -found.ineqlin.marginals, -float(found.fun))
    raise NoSolutionError(f"a linear programme of {len(programme.gain)} columns: {found.message}")
