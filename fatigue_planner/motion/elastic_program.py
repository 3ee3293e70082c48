"""The quadratic program with some of its limits made elastic, for ticks that have no solution otherwise."""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.motion.quadratic_program import QuadraticProgram, Vector, solve_either

Indices = NDArray[np.intp]

# Weight of the unknowns beside the slack, only to make the smallest slack's solution unique.
REGULARISATION = 1e-6
# What an eased limit gives way beyond the smallest slack, so that rounding leaves room for a solution.
MARGIN = 1e-6


def smallest_slack(program: QuadraticProgram, bounds: Indices, rows: Indices, scale: Vector) -> Vector | None:
    """By how much the bounds and rows named have to give way, (k,), bounds first; None if that is no help.

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
    for place, constraint in enumerate(rows, start=len(bounds)):
        elastic.A[constraint, n + place] = -scale[place]
    solution = solve_either(elastic)
    return None if solution is None else scale * solution[n:]


def solve_eased(program: QuadraticProgram, bounds: Indices, slack: Vector) -> Vector | None:
    """The minimiser (n,) with the bounds of these variables eased by their slack (k,); None if there is none."""
    room = MARGIN * (1 + np.abs(slack))
    program.lower[bounds] += np.minimum(slack, 0) - room
    program.upper[bounds] += np.maximum(slack, 0) + room
    return solve_either(program)
