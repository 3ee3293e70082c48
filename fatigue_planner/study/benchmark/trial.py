"""One run of the task: a policy against the generative model, driven by the trial's common random numbers."""

import time
from dataclasses import dataclass, field

import numpy as np

from fatigue_planner.core.random_streams import RandomNumbers
from fatigue_planner.planners.policy import Policy
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.problem import Vector, draw
from fatigue_planner.pomdp.scenario import Knowledge, Scenario


@dataclass(frozen=True)
class TrialResult:
    """What a run came to, and the number of the action of every cycle.

    Times are wall-clock seconds per decision, which are never the same twice.
    """

    discounted_return: float
    final_cost: float
    peak_cost: float
    mean_planning_time_s: float = field(compare=False)
    longest_planning_time_s: float = field(compare=False)
    actions: tuple[int, ...]


def cycle_of(
    model: FatiguePomdp, state: Vector, action: int, random_numbers: RandomNumbers, cycle: int
) -> tuple[Vector, int, float, int]:
    """What a cycle comes to with these random numbers: the next state, the preference, the reward, the observation."""
    preference = draw(model.probabilities(state, action), random_numbers.preference[cycle])
    moved, reward = model.transition(state, action, preference)
    seen = draw(model.observation_probabilities(moved, action, preference), random_numbers.observation[cycle])
    return moved, preference, reward, seen


def run_trial(
    scenario: Scenario,
    policy: Policy,
    knows: Knowledge,
    n_cycles: int,
    random_numbers: RandomNumbers,
    rng: np.random.Generator,
) -> TrialResult:
    """Run the task for a number of cycles; `rng` is the planner's own stream.

    The return is the sum over the cycles t = 0 ... n_cycles - 1 of gamma^t r_t, r_t = -C(f_t+1).
    """
    model = scenario.worker(random_numbers.worker)
    state = scenario.start(random_numbers.start)
    belief = scenario.initial_belief(knows, model, rng)
    total, discount = 0.0, 1.0
    costs, times, actions = np.empty(n_cycles), np.empty(n_cycles), []
    for cycle in range(n_cycles):
        begin = time.perf_counter()
        action = policy.act(belief, rng).action
        times[cycle] = time.perf_counter() - begin
        actions.append(int(action))
        state, _, reward, observation = cycle_of(model, state, action, random_numbers, cycle)
        costs[cycle] = -reward
        total -= discount * costs[cycle]
        discount *= model.discount
        policy.observe(action, observation)
        belief = belief.update(action, observation, rng)
    return TrialResult(
        total, float(costs[-1]), float(costs.max()), float(times.mean()), float(times.max()), tuple(actions)
    )
