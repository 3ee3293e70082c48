"""A convex quadratic program of fixed size, solved again and again without copying."""

import io
import math
from contextlib import AbstractContextManager, nullcontext, redirect_stdout
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

# What the optimality conditions may be missed by; on the paper's motions both solvers stay below 1e-10.
OPTIMALITY = 1e-6

SECOND_OPINION = {"daqp": "qpoases", "qpoases": "daqp"}


class QuadraticProgram:
    """min 1/2 x'Hx + g'x  subject to  row_lower <= A x <= row_upper, lower <= x <= upper.

    CasADi holds the structure and the solver. The attributes are views of the solver's own buffers
    (passing arrays to a CasADi function instead makes a tick 2-3 times slower): fill them, then call
    `solve`. `H` (n, n) must be symmetric and is column-major like `A` (m, n).
    """

    def __init__(self, variables: int, rows: int, solver: str) -> None:
        self.solver = solver
        structure = {"h": ca.Sparsity.dense(variables, variables), "a": ca.Sparsity.dense(rows, variables)}
        options: dict[str, Any] = {"error_on_fail": False}
        if solver == "qpoases":
            options |= {"printLevel": "none", "sparse": False}
        with self._quiet():
            self._function = ca.conic("whole_body", solver, structure, options)
            self._buffer, self._evaluate = self._function.buffer()
        # bounds and multipliers of rows and variables lie side by side, so that one expression checks both
        self._lower, self._upper, self._multipliers = (np.zeros(rows + variables) for _ in range(3))
        arrays: dict[str, Vector] = {
            "lba": self._lower[:rows],
            "lbx": self._lower[rows:],
            "uba": self._upper[:rows],
            "ubx": self._upper[rows:],
            "out_lam_a": self._multipliers[:rows],
            "out_lam_x": self._multipliers[rows:],
        }
        for i in range(self._function.n_in()):
            name = self._function.name_in(i)
            arrays.setdefault(name, np.zeros(self._function.nnz_in(i)))
            if arrays[name].size:
                self._buffer.set_arg(i, memoryview(arrays[name]))  # type: ignore[call-arg, arg-type]
        for i in range(self._function.n_out()):
            name = "out_" + self._function.name_out(i)
            arrays.setdefault(name, np.zeros(self._function.nnz_out(i)))
            if arrays[name].size:
                self._buffer.set_res(i, memoryview(arrays[name]))  # type: ignore[call-arg, arg-type]
        self._arrays = arrays
        self.H: Matrix = arrays["h"].reshape(variables, variables).T
        self.A: Matrix = arrays["a"].reshape(variables, rows).T
        self.g, self.lower, self.upper = arrays["g"], arrays["lbx"], arrays["ubx"]
        self.row_lower, self.row_upper = arrays["lba"], arrays["uba"]
        self._solution = arrays["out_x"]

    def solve(self) -> Vector | None:
        """The minimiser (n,); None if the data are not finite or the answer is not proved optimal.

        A solver's word is not taken for it: the optimality conditions are checked (see `optimality`).
        """
        if not self._finite():
            return None
        with self._quiet():
            self._evaluate()
        if not self._buffer.stats()["success"] or not self.optimality() <= OPTIMALITY:
            return None
        return self._solution

    def optimality(self) -> float:
        """How far the last answer is from optimal: the sum of three residuals, NaN if it is not finite.

        Violation of a constraint (in its own unit); stationarity |Hx + g + A'lambda + mu|, relative to
        the gradient's scale max(1, |g|); complementarity |multiplier x distance from its bound|.
        """
        x, multipliers = self._solution, self._multipliers
        values = np.concatenate([self.A @ x, x])
        below, above = self._upper - values, values - self._lower
        violation = -min(below.min(), above.min())
        rows = self.A.shape[0]
        gradient = self.H @ x + self.g + multipliers[:rows] @ self.A + multipliers[rows:]
        stationarity = np.abs(gradient).max() / max(1.0, np.abs(self.g).max())
        held = multipliers.nonzero()[0]
        gaps = np.where(multipliers[held] > 0, below[held], above[held])
        complementarity = np.abs(multipliers[held] * gaps).max(initial=0.0)
        return float(violation + stationarity + complementarity)

    def _quiet(self) -> AbstractContextManager[object]:
        """Swallow the banner of qpOASES, which no option removes."""
        return redirect_stdout(io.StringIO()) if self.solver == "qpoases" else nullcontext()

    def copy_from(self, other: "QuadraticProgram") -> None:
        """Take over the data of another program of the same size."""
        for name, values in other._arrays.items():
            self._arrays[name][:] = values

    def _finite(self) -> bool:
        """Whether H, A and g are finite and no bound is NaN; one sum or extremum finds what all() would."""
        finite = float(self._arrays["h"].sum() + self._arrays["a"].sum() + self.g.sum())
        bounds = (self.row_lower, self.row_upper, self.lower, self.upper)
        return math.isfinite(finite) and not any(math.isnan(bound.max()) for bound in bounds)


def solve_either(program: QuadraticProgram) -> Vector | None:
    """The minimiser (n,) by the program's solver or, where that fails, by another one."""
    solution = program.solve()
    if solution is not None:
        return solution
    rows, variables = program.A.shape
    second = QuadraticProgram(variables, rows, SECOND_OPINION[program.solver])
    second.copy_from(program)
    return second.solve()
