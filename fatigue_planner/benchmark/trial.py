"""One run of the task: a policy against the generative model as the world."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.benchmark.streams import stream
from fatigue_planner.planners.policy import Policy
from fatigue_planner.pomdp.belief import Belief
from fatigue_planner.pomdp.model import FatiguePomdp

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class World:
    """The chance of one run: uniform draws in [0, 1) for the start and for every cycle."""

    start: float
    preference: Vector
    observation: Vector


@dataclass(frozen=True)
class TrialResult:
    """What a run came to. Times are wall-clock seconds per decision."""

    discounted_return: float
    final_cost: float
    peak_cost: float
    mean_planning_time_s: float
    longest_planning_time_s: float


def draw_world(seed: int, condition: str, n_cycles: int, trial: int) -> World:
    """The world of a trial, the same for every policy."""
    key = (condition, n_cycles, trial)
    return World(
        float(stream(seed, "start", *key).random()),
        stream(seed, "preference", *key).random(n_cycles),
        stream(seed, "observation", *key).random(n_cycles),
    )


def _pick(probabilities: Vector, uniform: float) -> int:
    """The index whose share of [0, 1) holds `uniform`; never one of probability 0."""
    index = int(np.searchsorted(np.cumsum(probabilities), uniform, side="right"))
    return min(index, int(np.flatnonzero(probabilities)[-1]))


def run_trial(
    model: FatiguePomdp, initial: Belief, policy: Policy, n_cycles: int, world: World, rng: np.random.Generator
) -> TrialResult:
    """Run the task for a number of cycles; `rng` is the planner's own stream.

    The return is the sum over the cycles t = 0 ... n_cycles - 1 of gamma^t r_t, r_t = -C(f_t+1).
    """
    fatigue = initial.states[_pick(initial.weights, world.start)]
    belief = initial
    total, discount = 0.0, 1.0
    costs, times = np.empty(n_cycles), np.empty(n_cycles)
    for cycle in range(n_cycles):
        begin = time.perf_counter()
        action = policy.act(belief, rng).action
        times[cycle] = time.perf_counter() - begin
        preference = _pick(model.choice(fatigue, action), world.preference[cycle])
        observation = _pick(model.observation[preference], world.observation[cycle])
        fatigue = model.next_fatigue(fatigue, action)[preference]
        costs[cycle] = model.cost(fatigue)
        total -= discount * costs[cycle]
        discount *= model.discount
        belief = belief.update(model, action, observation)
    return TrialResult(total, float(costs[-1]), float(costs.max()), float(times.mean()), float(times.max()))
