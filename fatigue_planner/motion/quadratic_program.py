"""A convex quadratic program of fixed size, solved at every tick without copying.

Where its solver fails, another one is tried (`solve_with_fallback`). Where it has no solution, its limits can be
relaxed as little as possible (`smallest_slack`, `solve_eased`).
"""

import io
from contextlib import AbstractContextManager, nullcontext, redirect_stdout
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Indices = NDArray[np.intp]

# What the optimality conditions may be missed by; on the paper's motions both solvers stay below 1e-10.
OPTIMALITY = 1e-6
# Solvers stop at constraints kept to about 1e-6; an answer between these two is worth polishing.
POLISH, ROUGH = 1e-9, 1e-2
# How often the set of constraints that hold an answer is mended, and by how much one may be broken.
REFINEMENTS, BROKEN = 5, 1e-11

FALLBACK_SOLVER = {"daqp": "qpoases", "qpoases": "daqp"}

# Weight of the unknowns beside the slack, only to make the smallest slack's solution unique.
REGULARISATION = 1e-6
# By how much more than the smallest slack a limit is eased, so that rounding leaves a solution.
MARGIN = 1e-6


class QuadraticProgram:
    """min 1/2 x'Hx + g'x  subject to  row_lower <= A x <= row_upper, lower <= x <= upper.

    CasADi holds the structure and the solver. The attributes are views of the solver's own buffers
    (passing arrays to a CasADi function instead makes a tick 2-3 times slower): fill them, then call
    `solve`. `H` (n, n) must be symmetric and is column-major like `A` (m, n).

    eliminate: polish by elimination where that will do, ten times as fast as by least squares; the answers differ by
    rounding, and the paper's human keeps his to the bit.
    """

    def __init__(self, variables: int, rows: int, solver: str, eliminate: bool = False) -> None:
        self.solver, self.eliminate = solver, eliminate
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

        The solver's status is ignored: the optimality conditions are checked.
        """
        if not _finite(self._arrays["h"], self._arrays["a"], self.g, self._lower, self._upper):
            return None
        with self._quiet():
            self._evaluate()
        missed = self.optimality()
        if POLISH < missed <= ROUGH:
            missed = self._polish(missed)
        return self._solution if missed <= OPTIMALITY else None

    def optimality(self) -> float:
        """How far the last answer is from optimal: the sum of three residuals, NaN if it is not finite.

        Violation of a constraint (in its own unit); stationarity |Hx + g + A'lambda + mu|, relative to
        the gradient's scale max(1, |g|); complementarity |multiplier x distance from its bound|.
        """
        return float(_optimality(self.H, self.A, self.g, self._lower, self._upper, self._solution, self._multipliers))

    def _polish(self, missed: float) -> float:
        """Solve once more, exactly, for the constraints that hold the answer; returns what is missed then.

        A Newton step on the optimality conditions, as OSQP takes it; kept only where it is an improvement.
        """
        if self.eliminate and (after := self._eliminated(missed)) <= POLISH:
            return after
        lower, upper, multipliers = self._lower, self._upper, self._multipliers
        active = np.flatnonzero((multipliers != 0) | (lower == upper))
        bound = np.where(multipliers[active] < 0, lower[active], upper[active])
        answer = np.asarray(np.linalg.lstsq(*self._conditions(active, bound), rcond=None)[0], dtype=np.float64)
        return self._kept_if_better(missed, answer, active)

    def _eliminated(self, missed: float) -> float:
        """As `_polish`, by elimination; constraints that are broken then join those that hold, those that pull go."""
        lower, upper = self._lower, self._upper
        equal, side = lower == upper, np.sign(self._multipliers)
        n = len(self.g)
        for _ in range(REFINEMENTS):
            active = np.flatnonzero((side != 0) | equal)
            bound = np.where(side[active] < 0, lower[active], upper[active])
            try:
                answer = np.asarray(np.linalg.solve(*self._conditions(active, bound)), dtype=np.float64)
            except np.linalg.LinAlgError:
                return missed
            values = np.concatenate([self.A @ answer[:n], answer[:n]])
            pulls = np.zeros(len(side), dtype=bool)
            pulls[active] = ~equal[active] & (answer[n:] * side[active] < 0)
            broken = np.where(values < lower - BROKEN, -1.0, np.where(values > upper + BROKEN, 1.0, 0.0))
            broken[active] = 0
            if not pulls.any() and not broken.any():
                return self._kept_if_better(missed, answer, active)
            side = np.where(pulls, 0.0, side) + broken
        return missed

    def _conditions(self, active: Indices, bound: Vector) -> tuple[Matrix, Vector]:
        """The linear optimality conditions with these constraints, rows and variables, at these values."""
        matrix = np.vstack([self.A, np.eye(len(self.g))])[active]
        none = np.zeros((len(active), len(active)))
        return np.block([[self.H, matrix.T], [matrix, none]]), np.concatenate([-self.g, bound])

    def _kept_if_better(self, missed: float, answer: Vector, active: Indices) -> float:
        """Take an answer (variables, multipliers of the active constraints) if it misses less; what is missed then."""
        multipliers, n = self._multipliers, len(self.g)
        before = self._solution.copy(), multipliers.copy()
        multipliers[:] = 0
        self._solution[:], multipliers[active] = answer[:n], answer[n:]
        after = self.optimality()
        if after < missed:
            return after
        self._solution[:], multipliers[:] = before
        return missed

    def _quiet(self) -> AbstractContextManager[object]:
        """Swallow the banner of qpOASES, which no option removes."""
        return redirect_stdout(io.StringIO()) if self.solver == "qpoases" else nullcontext()

    def copy_from(self, other: "QuadraticProgram") -> None:
        """Take over the data of another program of the same size."""
        for name, values in other._arrays.items():
            self._arrays[name][:] = values


@compiled
def _finite(hessian: Vector, rows: Vector, gradient: Vector, lower: Vector, upper: Vector) -> bool:
    """Whether hessian, rows and gradient are finite and no bound is NaN."""
    good = True
    for data in (hessian, rows, gradient):
        for value in data:
            good &= abs(value) < np.inf
    for bounds in (lower, upper):
        for value in bounds:
            good &= not np.isnan(value)
    return good


@compiled
def _optimality(H: Matrix, A: Matrix, g: Vector, lower: Vector, upper: Vector, x: Vector, multipliers: Vector) -> float:
    """See QuadraticProgram.optimality; bounds and multipliers of the rows, then of the variables."""
    m = len(A)
    values = np.concatenate((A @ x, x))
    gradient = H @ x + g + A.T @ multipliers[:m] + multipliers[m:]
    violation, complementarity = 0.0, 0.0
    for i in range(len(values)):
        below, above = upper[i] - values[i], values[i] - lower[i]
        if not (below >= -violation and above >= -violation):
            violation = -min(below, above)
        if multipliers[i] != 0:
            missed = abs(multipliers[i] * (below if multipliers[i] > 0 else above))
            if not missed <= complementarity:
                complementarity = missed
    stationarity = np.abs(gradient).max() / max(1.0, np.abs(g).max())
    total: float = violation + stationarity + complementarity
    return total


def solve_with_fallback(program: QuadraticProgram) -> Vector | None:
    """The minimiser (n,) by the program's solver or, where that fails, by the fallback solver.

    The fallback is created anew each time: qpOASES starts from its last answer, and a tick's answer must
    not depend on the ticks before it.
    """
    solution = program.solve()
    if solution is not None:
        return solution
    rows, variables = program.A.shape
    fallback = QuadraticProgram(variables, rows, FALLBACK_SOLVER[program.solver])
    fallback.copy_from(program)
    return fallback.solve()


def smallest_slack(program: QuadraticProgram, bounds: Indices, rows: Indices, scale: Vector) -> Vector | None:
    """By how much the given bounds and rows have to be relaxed, (k,), bounds first; None if that does not help.

    min |s|^2 + REGULARISATION |x|^2 with x_i - scale s between its bounds for the variables `bounds` and
    (A x)_j - scale s between its own for the constraints `rows`; all else as in the program. `scale` (k,)
    makes slacks of different units comparable; they come back in their own units.
    """
    m, n = program.A.shape
    k = len(bounds) + len(rows)
    elastic = QuadraticProgram(n + k, m + len(bounds), program.solver)
    diagonal = np.einsum("ii->i", elastic.H)
    diagonal[:n], diagonal[n:] = REGULARISATION, 1.0
    elastic.A[:m, :n] = program.A
    elastic.lower[:], elastic.upper[:] = -np.inf, np.inf
    elastic.lower[:n], elastic.upper[:n] = program.lower, program.upper
    elastic.row_lower[:m], elastic.row_upper[:m] = program.row_lower, program.row_upper
    for slack, variable in enumerate(bounds):
        row = m + slack
        elastic.A[row, variable], elastic.A[row, n + slack] = 1, -scale[slack]
        elastic.row_lower[row], elastic.row_upper[row] = program.lower[variable], program.upper[variable]
        elastic.lower[variable], elastic.upper[variable] = -np.inf, np.inf
    for slack, constraint in enumerate(rows, start=len(bounds)):
        elastic.A[constraint, n + slack] = -scale[slack]
    solution = solve_with_fallback(elastic)
    return None if solution is None else scale * solution[n:]


def solve_eased(program: QuadraticProgram, bounds: Indices, slack: Vector) -> Vector | None:
    """The minimiser (n,) with the bounds of these variables eased by their slack (k,); None if there is none."""
    margin = MARGIN * (1 + np.abs(slack))
    program.lower[bounds] += np.minimum(slack, 0) - margin
    program.upper[bounds] += np.maximum(slack, 0) + margin
    return solve_with_fallback(program)
