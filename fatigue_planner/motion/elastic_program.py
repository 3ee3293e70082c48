"""The quadratic program with some of its limits made elastic, for ticks that have no solution otherwise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.motion.quadratic_program import QuadraticProgram, solve_either

Vector = NDArray[np.float64]
Indices = NDArray[np.intp]

# What a unit of scaled slack costs: enough that a limit gives way only as far as it must.
PENALTY = 1e3


@dataclass(frozen=True)
class Eased:
    """The solution (n,) of an elastic program, and the slack (k,) of its elastic bounds, then rows."""

    solution: Vector
    slack: Vector


def solve_elastic(program: QuadraticProgram, bounds: Indices, rows: Indices, scale: Vector) -> Eased | None:
    """The minimiser if the bounds and rows named may be left at a price; None if even that has none.

    min 1/2 x'Hx + g'x + PENALTY/2 |s|^2 with x_i - scale s between its bounds for the variables
    `bounds` and (A x)_j - scale s for the constraint `rows`; `scale` (k,) holds their units, bounds
    first. Slacks come back in those units, so that they are comparable only after division by it.
    """
    m, n = program.A.shape
    k = len(bounds) + len(rows)
    elastic = QuadraticProgram(n + k, m + len(bounds), program.solver)
    elastic.H[:n, :n], elastic.H[range(n, n + k), range(n, n + k)] = program.H, PENALTY
    elastic.g[:n] = program.g
    elastic.A[:m, :n] = program.A
    elastic.lower[:], elastic.upper[:] = -np.inf, np.inf
    elastic.lower[:n], elastic.upper[:n] = program.lower, program.upper
    elastic.row_lower[:m], elastic.row_upper[:m] = program.row_lower, program.row_upper
    for slack, variable in enumerate(bounds):
        row = m + slack
        elastic.A[row, variable], elastic.A[row, n + slack] = 1, -scale[slack]
        elastic.row_lower[row], elastic.row_upper[row] = program.lower[variable], program.upper[variable]
        elastic.lower[variable], elastic.upper[variable] = -np.inf, np.inf
    for place, constraint in enumerate(rows, start=len(bounds)):
        elastic.A[constraint, n + place] = -scale[place]
    solution = solve_either(elastic)
    return None if solution is None else Eased(solution[:n], scale * solution[n:])
