"""One run of the task: a policy against the generative model as the world."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.planners.lookahead import LookaheadPolicy
from fatigue_planner.planners.policy import Policy
from fatigue_planner.pomdp.problem import draw
from fatigue_planner.pomdp.situation import Knowledge, Situation
from fatigue_planner.streams import stream

Vector = NDArray[np.float64]


# A loss of this share of the value is none.
ROUNDING = 1e-12


@dataclass(frozen=True)
class World:
    """The chance of one run: uniform draws in [0, 1) for the worker (3,), the start and every cycle."""

    worker: Vector
    start: float
    preference: Vector
    observation: Vector


@dataclass(frozen=True)
class Regret:
    """What the decisions of a run lose against a reference, by the reference's own values.

    decision_loss: mean over the decisions of max_a Q(b, a) - Q(b, action taken), >= 0
    run_loss: the sum of gamma^t times these; in the task without end its mean is what the policy's expected
        return falls short of the best, if Q is exact and the run long (performance-difference lemma, Kakade &
        Langford 2002). The reference, like the policies, does not know when the run ends: at the end of a short
        run it gives up some return for a future that is not counted.
    agreement: share of the decisions that lose nothing
    """

    decision_loss: float
    run_loss: float
    agreement: float


@dataclass(frozen=True)
class TrialResult:
    """What a run came to. Times are wall-clock seconds per decision; regret, where it was asked for."""

    discounted_return: float
    final_cost: float
    peak_cost: float
    mean_planning_time_s: float
    longest_planning_time_s: float
    regret: Regret | None = None


def draw_world(seed: int, condition: str, n_cycles: int, trial: int) -> World:
    """The world of a trial, the same for every policy."""
    key = (condition, n_cycles, trial)
    return World(
        stream(seed, "worker", *key).random(3),
        float(stream(seed, "start", *key).random()),
        stream(seed, "preference", *key).random(n_cycles),
        stream(seed, "observation", *key).random(n_cycles),
    )


@dataclass(frozen=True)
class Reference:
    """A policy whose values judge other policies' decisions, and its own random stream."""

    policy: LookaheadPolicy
    rng: np.random.Generator


def run_trial(
    situation: Situation,
    policy: Policy,
    knows: Knowledge,
    n_cycles: int,
    world: World,
    rng: np.random.Generator,
    reference: Reference | None = None,
) -> TrialResult:
    """Run the task for a number of cycles; `rng` is the planner's own stream.

    The return is the sum over the cycles t = 0 ... n_cycles - 1 of gamma^t r_t, r_t = -C(f_t+1).
    """
    model = situation.worker(world.worker)
    state = situation.start(world.start)
    belief = situation.initial_belief(knows, model, rng)
    judged = belief  # by the reference, which knows the prior
    if reference is not None and knows != "prior":
        judged = situation.initial_belief("prior", model, reference.rng)
    total, discount = 0.0, 1.0
    costs, times, losses = np.empty(n_cycles), np.empty(n_cycles), np.zeros(n_cycles)
    for cycle in range(n_cycles):
        begin = time.perf_counter()
        action = policy.act(belief, rng).action
        times[cycle] = time.perf_counter() - begin
        if reference is not None:
            judged = belief if knows == "prior" else judged
            values = reference.policy.values(judged, reference.rng)
            loss = values.max() - values[action]
            losses[cycle] = loss if loss > ROUNDING * abs(values.max()) else 0.0
        preference = draw(model.probabilities(state, action), world.preference[cycle])
        state, reward = model.after(state, action, preference)
        observation = draw(model.observation_probabilities(state, action, preference), world.observation[cycle])
        costs[cycle] = -reward
        total -= discount * costs[cycle]
        discount *= model.discount
        policy.observe(action, observation)
        belief = belief.update(action, observation, rng)
        if reference is not None and knows != "prior":
            judged = judged.update(action, observation, reference.rng)
    regret = None
    if reference is not None:
        weights = model.discount ** np.arange(n_cycles)
        regret = Regret(float(losses.mean()), float(weights @ losses), float((losses == 0).mean()))
    return TrialResult(total, float(costs[-1]), float(costs.max()), float(times.mean()), float(times.max()), regret)
