"""Many environments of one task side by side, as a Gymnasium vector environment stepped by compiled code."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Discrete
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from fatigue_planner.core.errors import SelectionError
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.scenario import Scenario
from fatigue_planner.study.environments.courses import Courses
from fatigue_planner.study.environments.environment import SEEDS

Flags = NDArray[np.bool_]
Numbers = NDArray[np.int64]


class VectorEnvironment(VectorEnv[Numbers, Any, NDArray[Any]]):
    """`count` environments (see `Environment`), numbered i: the same as those that are reset with seed + i.

    A step after the last cycle of its episode resets an environment, whatever the action (AutoresetMode.NEXT_STEP, as
    gymnasium.vector.SyncVectorEnv does).
    """

    def __init__(self, problem: Scenario | Belief, count: int, n_cycles: int) -> None:
        self._courses = Courses(problem, n_cycles, count)
        self._seeded = False
        self.model, self.num_envs = problem.model, count
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}
        self.single_action_space = Discrete(len(self.model.actions))
        self.single_observation_space = Discrete(self._courses.nothing_seen + 1)
        self.action_space = batch_space(self.single_action_space, count)
        self.observation_space = batch_space(self.single_observation_space, count)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Numbers, dict[str, Any]]:
        """Begin the next episode of all, or their first ones: of seed + i, or of the seeds in a list.

        `options` are ignored. Raises SelectionError for a list that has not as many seeds as there are environments.
        """
        if isinstance(seed, int | np.integer):
            super().reset(seed=int(seed))
            seed = [int(seed) + run for run in range(self.num_envs)]
        elif seed is None:
            seed = [None] * self.num_envs
        if len(seed) != self.num_envs:
            raise SelectionError(f"{len(seed)} seeds: there are {self.num_envs} environments.")
        for run, one in enumerate(seed):
            if one is not None or not self._seeded:
                self._courses.seed(run, int(self.np_random.integers(SEEDS)) if one is None else int(one))
        self._seeded = True
        self._courses.begin(range(self.num_envs))
        return self._courses.observations.copy(), self._info(np.zeros(self.num_envs, bool))

    def step(self, actions: Any) -> tuple[Numbers, NDArray[np.float64], Flags, Flags, dict[str, Any]]:
        """One cycle of all; actions (count,) by number or name.

        Raises SelectionError for what is no action, ResetNeeded before the first reset.
        """
        courses = self._courses
        if not self._seeded:
            raise ResetNeeded("no episode has begun: call reset.")
        numbers = courses.numbers_of(actions)
        over = (courses.cycles == courses.n_cycles) | courses.ended
        if over.any():
            courses.begin(np.flatnonzero(over).tolist())
            courses.rewards[over] = 0.0
        courses.step(np.flatnonzero(~over), numbers)
        ends = courses.ended.copy(), courses.cut
        return courses.observations.copy(), courses.rewards.copy(), *ends, self._info(~over)

    def _info(self, stepped: Flags) -> dict[str, Any]:
        """What every environment's `info` has, with a mask of those that have it."""
        courses, info = self._courses, dict[str, Any]()
        if stepped.any():
            info[courses.outcome_name] = np.where(stepped, courses.outcomes, 0)
            info[f"_{courses.outcome_name}"] = stepped
        for name, values in courses.truth().items():
            info[name], info[f"_{name}"] = values, np.ones(self.num_envs, bool)
        return info
