"""A task as a Gymnasium environment."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded

from fatigue_planner.core.errors import SelectionError, shortened
from fatigue_planner.planners.policy import action_number, expected_action
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.study.environments.courses import Courses

# Seeds that the environment chooses when it is given none are below this.
SEEDS = 2**62


class Environment(gymnasium.Env[np.int64, np.int64 | int | str]):
    """A scenario's task, or any problem from a belief, for n_cycles cycles.

    An action is a number or a name. The observation is the number of the reaction that was recognised, the reward -C
    (Eq. 5). Before the first cycle nothing was seen: that is the last number of the observation space. After n_cycles
    an episode is truncated: the task itself has no end; a problem that has one terminates there. `info` has what no
    policy may know: `reaction`, the number of the true one, and `fatigue` (78,); for other problems `outcome` and
    `state`.

    After `reset(seed=s)` the episodes are the trials 0, 1, ... of a benchmark with this seed.
    """

    def __init__(self, problem: Scenario | Belief, n_cycles: int) -> None:
        self._courses = Courses(problem, n_cycles, 1)
        self._seeded = False
        self.model = problem.model
        self.action_space = gymnasium.spaces.Discrete(len(self.model.actions))
        self.observation_space = gymnasium.spaces.Discrete(self._courses.nothing_seen + 1)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.int64, dict[str, Any]]:
        """Begin the next episode, or the first one of a seed; `options` are ignored."""
        super().reset(seed=seed)
        if seed is not None or not self._seeded:
            self._courses.seed(0, int(self.np_random.integers(SEEDS)) if seed is None else int(seed))
            self._seeded = True
        self._courses.begin([0])
        return self._courses.observations[0], self._info()

    def step(self, action: np.int64 | int | str) -> tuple[np.int64, float, bool, bool, dict[str, Any]]:
        """One cycle. Raises SelectionError for what is no action, ResetNeeded before the first and after the last."""
        courses = self._courses
        if courses.cycles[0] == courses.n_cycles or courses.ended[0]:
            raise ResetNeeded(f"the episode of {courses.n_cycles} cycles is over, or has not begun: call reset.")
        number = action_number(action, self.model.actions)
        if number is None:
            raise SelectionError(f"action {shortened(action)}: must be {expected_action(self.model.actions)}.")
        courses.step(np.zeros(1, np.int64), np.array([number]))
        info = {courses.outcome_name: courses.outcomes[0]} | self._info()
        return courses.observations[0], float(courses.rewards[0]), bool(courses.ended[0]), bool(courses.cut[0]), info

    def _info(self) -> dict[str, Any]:
        return {name: values[0] for name, values in self._courses.truth().items()}
