"""What every reaction would have cost in each cycle: the fatigue that the reactions before it left.

Reactions are hidden where recognition errs. The course is then that of the mean fatigue: every cycle's change is the
mean over its reactions, as likely as all that was seen makes them. An error in one cycle fades with its fatigue.
"""

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.recordings.learning.cycles import Cycles
from fatigue_planner.recordings.learning.estimate import Estimator, Fit
from fatigue_planner.recordings.learning.likelihood import UNSEEN, Choices, Confusion, Numbers

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# Courses and fits take turns until no chance of a reaction changes by more, but not more often.
SETTLED, MAX_TURNS = 1e-3, 20


def costs_along(model: FatiguePomdp, start: Vector, cycles: Cycles, chances: Array) -> Array:
    """The cost (n, U) of every reaction in every cycle, from a state on, given the chances (n, U) of each."""
    count, size = chances.shape
    costs = np.empty((count, size))
    lived = {1.0: model}
    state = start
    for t in range(count):
        action = int(cycles.actions[t])
        costs[t] = [-model.transition(state, action, u)[1] for u in range(size)]
        pace = model.pace(
            None if cycles.start_s is None or t + 1 == count else cycles.start_s[t + 1] - cycles.start_s[t]
        )
        if pace.share not in lived:
            lived[pace.share] = model.for_workers(model.workers, pace.share)
        state = sum(chance * lived[pace.share].transition(state, action, u)[0] for u, chance in enumerate(chances[t]))
        if pace.rest_s > 0:
            state = model.rested(state[None], pace.rest_s)[0]
    return costs


def learn(
    model: FatiguePomdp, start: Vector, cycles: Cycles, confusion: Confusion, group: Numbers
) -> tuple[Estimator, Fit]:
    """The estimator of a worker's cycles along their course, and its fit of the largest model.

    group (n,): the cycle's matrix of the confusion. Raises SelectionError where costs never differ.
    """
    seen = confusion.chances[group, :, np.maximum(cycles.seen, 0)]
    chances = np.where((cycles.seen == UNSEEN)[:, None], 1.0, seen)
    if not chances.any(axis=1).all():
        cycle = int(np.flatnonzero(~chances.any(axis=1))[0])
        raise SelectionError(f"cycle {cycle + 1}: no preference is ever recognised as what was seen.")
    chances = chances / chances.sum(axis=1, keepdims=True)
    begins, point = np.arange(len(chances)) == 0, None
    for _ in range(MAX_TURNS):
        costs = costs_along(model, start, cycles, chances)
        estimator = Estimator(Choices(costs, cycles.seen, group, begins), confusion)
        fit = estimator.fit(start=point)
        change = float(np.abs(fit.chances - chances).max())
        chances, point = fit.chances, fit.point
        if change < SETTLED:
            break
    return estimator, fit
