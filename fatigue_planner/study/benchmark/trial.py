"""One run of the task: a policy against the generative model, driven by the trial's common random numbers."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from fatigue_planner.core.errors import PluginError, shortened
from fatigue_planner.core.plugins import origin_of
from fatigue_planner.core.random_streams import RandomNumbers
from fatigue_planner.planners.policy import Policy
from fatigue_planner.pomdp.beliefs.belief import Belief
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


@dataclass(frozen=True)
class Cycle:
    """A cycle of a run: numbers of action, preference and observation; r_t (Eq. 5); the state afterwards."""

    action: int
    preference: int
    observation: int
    reward: float
    state: Vector
    planning_time_s: float


class Episode:
    """A run of the task under way, for whoever chooses the actions.

    discounted_return: the sum so far over the cycles t = 0, 1, ... of gamma^t r_t, r_t = -C(f_t+1).
    """

    def __init__(self, scenario: Scenario, random_numbers: RandomNumbers) -> None:
        self.model = scenario.worker(random_numbers.worker)
        self.discounted_return = 0.0
        self._random_numbers = random_numbers
        self._state, self._discount, self._cycle = scenario.start(random_numbers.start), 1.0, 0

    def step(self, action: int, planning_time_s: float = 0.0) -> Cycle:
        """One cycle with this action."""
        model, numbers = self.model, self._random_numbers
        preference = draw(model.probabilities(self._state, action), numbers.preference[self._cycle])
        state, reward = model.transition(self._state, action, preference)
        chances = model.observation_probabilities(state, action, preference)
        observation = draw(chances, numbers.observation[self._cycle])
        self.discounted_return += self._discount * reward
        self._discount *= model.discount
        self._state, self._cycle = state, self._cycle + 1
        return Cycle(action, preference, observation, reward, state, planning_time_s)


def decided_cycles(
    episode: Episode, belief: Belief, policy: Policy, n_cycles: int, rng: np.random.Generator
) -> Iterator[Cycle]:
    """The cycles of a run in which a policy decides from its belief; `rng` is the planner's own stream.

    Raises PluginError if the policy chooses what is no action.
    """
    for _ in range(n_cycles):
        begin = time.perf_counter()
        decision = policy.act(belief, rng)
        planning_time_s = time.perf_counter() - begin
        number = getattr(decision, "action", None)
        if not isinstance(number, int | np.integer) or not 0 <= number < len(episode.model.actions):
            actions = f"Decision with an action from 0 to {len(episode.model.actions) - 1}"
            raise PluginError(f"{origin_of(type(policy))}: act returned {shortened(decision)}, not a {actions}.")
        cycle = episode.step(int(number), planning_time_s)
        yield cycle
        policy.observe(cycle.action, cycle.observation)
        belief = belief.update(cycle.action, cycle.observation, rng)


def run_trial(
    scenario: Scenario,
    policy: Policy,
    knows: Knowledge,
    n_cycles: int,
    random_numbers: RandomNumbers,
    rng: np.random.Generator,
) -> TrialResult:
    """Run the task for a number of cycles; `rng` is the planner's own stream. Raises PluginError."""
    episode = Episode(scenario, random_numbers)
    belief = scenario.initial_belief(knows, episode.model, rng)
    cycles = list(decided_cycles(episode, belief, policy, n_cycles, rng))
    costs = np.array([-cycle.reward for cycle in cycles])
    times = np.array([cycle.planning_time_s for cycle in cycles])
    actions = tuple(cycle.action for cycle in cycles)
    return TrialResult(
        episode.discounted_return,
        float(costs[-1]),
        float(costs.max()),
        float(times.mean()),
        float(times.max()),
        actions,
    )
