"""How long a decision may take, from counts of its work, so that none is begun that nobody waits for.

The times for a piece of work were measured on one core of an AMD EPYC (Zen 5) and are doubled here, for slower machines
(`perf/effort.py` compares). They are the same everywhere, so that a file that is accepted is accepted everywhere.
"""

import math

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.planners.lookahead import DRAWS_NOTHING, LookaheadSettings, ReferenceSettings
from fatigue_planner.planners.pomcp.kernels import LeafValueName, keeps_rewards
from fatigue_planner.planners.pomcp.policy import PomcpSettings
from fatigue_planner.planners.pomcp.sparse.pomcpow import PomcpowSettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.moments import is_reducible
from fatigue_planner.pomdp.cyclic_plans import most_plans
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp

Lookahead = LookaheadSettings | ReferenceSettings
Search = PomcpSettings | PomcpowSettings

# Nanoseconds of a piece of work: a part that it always takes, and one for every entry of the fatigue.
MAP = 10, 0.13  # the map of a cycle, its cost and the bookkeeping of a step
PLAN = 1, 0.11  # the value of a plan in a state
NEW_PLAN = 100, 15  # the values of a plan of a new worker, after a rejuvenation
SHARE = 1.5  # the share of a plan's value in the sum of an observation that does not reveal the outcome
CHOICE, SPARSE_CHOICE = 15, 100  # an action chosen and a return backed up; in a sparse tree
KNOWN = 12, 0.07  # a step that is known and so only made up for (pomcp/recall.py), its choice included
SLOWER = 2.0  # how much slower another machine may be
# A belief of more states does not fit in memory.
MAX_STATES = 1e7


class Effort:
    """The work of decisions from a belief, in nanoseconds."""

    def __init__(self, belief: Belief, in_moments: bool = False) -> None:
        model = belief.model
        assert isinstance(model, FatiguePomdp)
        self.workers, self.width = len(model.workers.expertise), int(model.arrays.gain.shape[1])
        self.states = float(len(belief.weights))
        if in_moments and is_reducible(belief):
            self.states, self.width = float(self.workers), 2 * self.width
        self.actions, self.outcomes = len(model.actions), len(model.outcomes)
        self.possible = 1 if model.is_experts else self.outcomes
        self.shares = 1 if model.observation_reveals_outcome else len(model.observations)
        self.even = model.arrays.even
        self.costs = 0 if self.even else self.outcomes  # maps of a choice
        # How probable the likeliest observation may be: whoever minds costs may be sure of his choice.
        seen = model.arrays.observation
        self.likeliest = float((seen.mean(axis=1) if self.even else seen).max())
        self.recalls = keeps_rewards(model) and len(belief.weights) == 1

    def maps(self, count: float) -> float:
        """So many maps of cycles."""
        return float(count * (MAP[0] + MAP[1] * self.width))

    def leaves(self, leaf_value: LeafValueName, rollout_cycles: int, states: float) -> float:
        """The leaf values of so many states."""
        if leaf_value == "bound":
            plans, shared = most_plans(self.actions), SHARE * self.shares if self.shares > 1 else 0
            new = self.workers * plans * (NEW_PLAN[0] + NEW_PLAN[1] * self.width)
            return float(states * plans * (PLAN[0] + PLAN[1] * self.width + shared) + new)
        maps = {
            "none": 0,
            "random_rollout": rollout_cycles * (1 + self.costs),
            "greedy_rollout": rollout_cycles * (self.actions * self.outcomes + 1 + self.costs),
        }[leaf_value]
        return self.maps(states * maps)


def seconds_of(settings: Lookahead | Search, belief: Belief) -> float:
    """About how many seconds a decision takes at most; 0 if its budget is a time."""
    if isinstance(settings, LookaheadSettings | ReferenceSettings):
        return SLOWER * 1e-9 * _of_lookahead(settings, belief)
    return SLOWER * 1e-9 * _of_search(settings, belief)


def _of_lookahead(settings: Lookahead, belief: Belief) -> float:
    effort = Effort(belief, settings.leaf_value in DRAWS_NOTHING)
    branches = float(effort.actions * effort.possible * effort.shares)
    levels = [effort.states * branches**level for level in range(settings.depth)]
    moves = max(effort.costs + effort.possible * effort.shares, effort.outcomes)
    ends = levels[-1] * effort.actions * effort.possible
    leaves = ends if settings.leaf_value == "bound" else ends * effort.shares
    below = effort.leaves(settings.leaf_value, settings.rollout_cycles, leaves)
    return effort.maps(sum(levels) * effort.actions * moves) + below


def _of_search(settings: Search, belief: Belief) -> float:
    if settings.descents is None:
        return 0.0
    effort, sparse = Effort(belief), isinstance(settings, PomcpowSettings)
    exact = effort.outcomes if isinstance(settings, PomcpSettings) and settings.backup == "exact" else 0
    step = effort.maps(1 + effort.costs + exact) + (SPARSE_CHOICE if sparse else CHOICE) + effort.actions
    known = KNOWN[0] + KNOWN[1] * effort.width + effort.actions if effort.recalls and not sparse else step
    tried_first = 1 if sparse else effort.actions  # in a sparse tree some may be left out
    descent = step + (_mean_depth(settings.descents, tried_first, effort.likeliest) - 1) * known
    return settings.descents * descent + effort.leaves(settings.leaf_value, settings.rollout_cycles, settings.descents)


def _mean_depth(descents: int, tried_first: int, likeliest: float) -> float:
    """How deep descents go in the mean, at most.

    Every descent adds one node, and no node is left for a grandchild before all its actions have been tried: after n
    descents the tree is at most 1 + n / A deep, a single path with A children at every node, and descents half of that.
    It grows so where an action is always the best one and its outcome sure. Where no history of d cycles is likelier
    than p^d, p being the probability of the likeliest observation, descents are hardly deeper than log n / log(1 / p).
    """
    path = 1 + (descents + 1) / (2 * tried_first)
    return path if likeliest == 1 else min(path, math.log(descents + 2) / -math.log(max(likeliest, 0.5)))


def check_effort(name: str, settings: Lookahead | Search, belief: Belief, max_decision_s: float) -> None:
    """Raise ExperimentError for a decision that may take more time than allowed, or more memory than there is.

    It names the key, what would be accepted, and the limit.
    """

    def is_accepted(value: int) -> bool:
        tried = settings.model_copy(update={key: value})
        return seconds_of(tried, belief) <= max_decision_s and _largest_belief(tried, belief) <= MAX_STATES

    key = "depth" if isinstance(settings, LookaheadSettings | ReferenceSettings) else "descents"
    value = getattr(settings, key)
    if value is None or is_accepted(value):
        return
    least = 1 if key == "depth" else len(belief.model.actions)
    accepted = value - 1
    while accepted >= least and not is_accepted(accepted):
        accepted = accepted - 1 if key == "depth" else int(0.9 * accepted)
    instead = f"Take {accepted} or less" if accepted >= least else "Take another leaf value or policy"
    seconds, states = seconds_of(settings, belief), _largest_belief(settings, belief)
    if states > MAX_STATES:
        raise ExperimentError(
            f"{name}.{key} = {value}: beliefs would have {states:.0e} states; {MAX_STATES:.0e} are allowed. {instead}."
        )
    raise ExperimentError(
        f"{name}.{key} = {value}: a decision may take {seconds:.2g} s; benchmark.max_decision_s allows "
        f"{max_decision_s:g} s. {instead}, or allow more."
    )


def _largest_belief(settings: Lookahead | Search, belief: Belief) -> float:
    """How many states a belief on the way has at most."""
    states = float(len(belief.weights))
    if isinstance(settings, PomcpSettings | PomcpowSettings) or belief.model.observation_reveals_outcome:
        return states
    return states * float(len(belief.model.outcomes)) ** settings.depth
