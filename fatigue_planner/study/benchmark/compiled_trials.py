"""Many runs at once, in compiled loops, of policies that need no search: the same results as one run after the other.

It works where a belief is a finite set that is known before the first cycle, and the policy either knows its actions
ahead, whatever will be observed, or decides by a compiled rule from what it believes (`Policy.ahead`, `Policy.rule`).
"""

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import PluginError, shortened
from fatigue_planner.core.jit import specialised
from fatigue_planner.core.plugins import origin_of
from fatigue_planner.core.random_streams import world_stream
from fatigue_planner.planners.policy import Policy, PolicySettings
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.exact import bayes, normalise, relative_weights
from fatigue_planner.pomdp.beliefs.registry import ExactSettings
from fatigue_planner.pomdp.cycles import cycle_of, live_cycle
from fatigue_planner.pomdp.problem import Vector
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.study.benchmark.trial import TrialResult

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


def can_be_compiled(scenario: Scenario, settings: PolicySettings) -> bool:
    """Whether `compiled_trials` can run a policy's trials."""
    if type(scenario.belief) is not ExactSettings or (scenario.prior is not None and settings.knows == "truth"):
        return False
    policy = settings.build()
    if _has(policy, "ahead"):
        return True
    known = scenario.prior is None and scenario.model.observation_reveals_outcome
    rule = policy.rule() if known and _has(policy, "rule") else None
    return rule is not None and len(scenario.weights) <= rule.most_states


def _has(policy: Policy, hook: str) -> bool:
    """Whether a class of the policy's has `ahead` or `rule`, and no class derived from it acts otherwise."""
    order = type(policy).__mro__
    place = {name: next(i for i, kind in enumerate(order) if name in vars(kind)) for name in (hook, "act", "observe")}
    return order[place[hook]] is not Policy and place[hook] <= min(place["act"], place["observe"])


def compiled_trials(
    scenario: Scenario,
    settings: PolicySettings,
    key: tuple[int, str, int],
    trials: Sequence[int],
    planner: Callable[[int], np.random.Generator],
) -> dict[int, TrialResult]:
    """The results of some trials; key: seed, condition and number of cycles; planner(trial): the planner's own stream.

    The planning time of every decision is the mean over all cycles of these trials, the cycles themselves included.
    """
    n_cycles = key[2]
    starts, model = _starts(scenario, key, trials)
    draws = np.array([world_stream("preference", *key, trial).random(n_cycles) for trial in trials])
    belief = scenario.initial_belief(settings.knows, scenario.model, np.random.default_rng(0))
    belief.model.check_probabilities(belief.states)
    policy, actions, rewards = settings.build(), np.empty(draws.shape, np.int64), np.empty(draws.shape)
    if _has(policy, "ahead"):
        for row, trial in enumerate(trials if policy.draws_at_random else trials[:1]):
            actions[row:] = _ahead(settings.build(), belief, n_cycles, planner(trial))
        loop: Callable[..., Vector] = specialised(follow_all, live_cycle=cycle_of(model))
        loop = partial(loop, model.arrays)
        rest: tuple[Any, ...] = ()
    else:
        rule = policy.rule()
        assert rule is not None
        parts = {"live_cycle": cycle_of(model), "choose": rule.choose(model)}
        parts["bayes"] = specialised(bayes, **model.belief_parts)
        loop = partial(specialised(decide_all, **parts), model.arrays, rule.memory(belief), np.random.default_rng(0))
        rest = (belief.states, belief.weights)
    others = (actions, draws, rewards, len(model.outcomes), model.discount, *rest)
    loop(starts[:0], *others)  # loads or compiles the code
    begin = time.perf_counter()
    returns = loop(starts, *others)
    seconds = (time.perf_counter() - begin) / draws.size
    costs = -rewards
    final, peak = costs[:, -1].tolist(), costs.max(axis=1).tolist()
    results = {}
    for row, trial in enumerate(trials):
        taken = tuple(actions[row].tolist())
        results[trial] = TrialResult(float(returns[row]), final[row], peak[row], seconds, seconds, taken)
    return results


def _ahead(policy: Policy, belief: Belief, n_cycles: int, rng: np.random.Generator) -> Numbers:
    """The policy's actions. Raises PluginError if they are not so many actions of the problem."""
    found, count = np.asarray(policy.ahead(belief, n_cycles, rng)), len(belief.model.actions)
    if found.shape != (n_cycles,) or found.dtype.kind not in "iu" or found.min() < 0 or found.max() >= count:
        what = f"{n_cycles} actions from 0 to {count - 1}"
        raise PluginError(f"{origin_of(type(policy))}: ahead returned {shortened(found)}, not {what}.")
    return found


def _starts(scenario: Scenario, key: tuple[int, str, int], trials: Sequence[int]) -> tuple[Array, Any]:
    """Where the worker starts in every trial (n, L), and a model of all these workers."""
    rows = np.zeros(len(trials), np.intp)
    if len(scenario.weights) > 1:
        rows[:] = [scenario.start_number(float(world_stream("start", *key, trial).random())) for trial in trials]
    starts = scenario.states[rows]
    if scenario.prior is None:
        return starts, scenario.model
    starts[:, -1] = np.arange(len(trials))
    uniforms = np.array([world_stream("worker", *key, trial).random(3) for trial in trials])
    return starts, scenario.model.for_workers(scenario.prior.at(uniforms))


def choose(arrays: Any, memory: Any, states: Array, weights: Vector, rng: np.random.Generator) -> int:
    """Placeholder in the template for a policy's rule."""
    raise NotImplementedError


def follow_all(
    arrays: Any, states: Array, actions: Numbers, draws: Array, rewards: Array, outcomes: int, discount: float
) -> Vector:
    """Template: the discounted returns of runs from states (n, L), with given actions and draws (n, cycles)."""
    scratch, returns = np.empty(outcomes), np.zeros(len(states))
    for i in range(len(states)):
        factor = 1.0
        for cycle in range(draws.shape[1]):
            _, _, reward = live_cycle(arrays, states[i], actions[i, cycle], scratch, draws[i, cycle], 0.0)
            rewards[i, cycle] = reward
            returns[i] += factor * reward
            factor *= discount
    return returns


def decide_all(
    arrays: Any,
    memory: Any,
    rng: np.random.Generator,
    states: Array,
    actions: Numbers,
    draws: Array,
    rewards: Array,
    outcomes: int,
    discount: float,
    first_states: Array,
    first_weights: Vector,
) -> Vector:
    """Template: the same with actions chosen from a belief, where observations reveal outcomes, and filled in."""
    scratch, returns = np.empty(outcomes), np.zeros(len(states))
    for i in range(len(states)):
        believed, weights, factor = first_states, first_weights, 1.0
        for cycle in range(draws.shape[1]):
            action = choose(arrays, memory, believed, weights, rng)
            _, seen, reward = live_cycle(arrays, states[i], action, scratch, draws[i, cycle], 0.0)
            actions[i, cycle], rewards[i, cycle] = action, reward
            returns[i] += factor * reward
            factor *= discount
            if weights.size == 1:  # the only state that is possible is the true one
                believed = states[i : i + 1]
            else:
                believed, weights = bayes(arrays, believed, weights, action, seen, outcomes, True, True)
                relative_weights(weights)
                normalise(weights)
    return returns
