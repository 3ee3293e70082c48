"""A belief about novices as one state per worker: the mean and the standard deviation of every entry.

A novice's choices do not depend on the fatigue, a cycle maps it affinely and its cost is quadratic. So all that a
belief says about the costs to come are the first two moments, and these move like entries of fatigue do: a mean by
f' = g f + o, a standard deviation by s' = g s, and both cost w f^2 and w s^2 (`FatiguePomdp.in_moments`).
"""

import numpy as np

from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.exact import ExactBelief
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp

# Fewer states are as fast by themselves.
MIN_STATES = 8


def is_reducible(belief: Belief) -> bool:
    """Whether a belief in the fatigue problem has fewer states in moments."""
    model = belief.model
    assert isinstance(model, FatiguePomdp)
    many = len(belief.weights) >= max(MIN_STATES, np.unique(belief.states[:, -1]).size + 1)
    return many and model.arrays.even and model.cost.is_quadratic


def belief_in_moments(belief: Belief) -> Belief:
    """The same belief with one state per worker, where all are novices, their cost is quadratic, and states are many.

    Planners that only ask for expected rewards, whatever is observed, find the same values in it.
    """
    model = belief.model
    if not isinstance(model, FatiguePomdp) or not is_reducible(belief):
        return belief
    used, worker = np.unique(belief.states[:, -1].astype(np.intp), return_inverse=True)
    share = np.zeros((used.size, len(belief.weights)))
    share[worker, np.arange(len(belief.weights))] = belief.weights
    weights = share.sum(axis=1)
    possible = weights > 0
    share, used, weights = share[possible] / weights[possible, None], used[possible], weights[possible]
    fatigue = belief.states[:, :-1]
    mean = share @ fatigue
    variance = np.array([of @ np.square(fatigue - around) for of, around in zip(share, mean, strict=True)])
    return ExactBelief(model.in_moments, np.column_stack([mean, np.sqrt(variance), used]), weights)
