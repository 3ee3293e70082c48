"""Runs of a problem side by side, each with the random numbers of a trial of the benchmark."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import ProblemError, SelectionError, shortened
from fatigue_planner.core.random_streams import world_stream
from fatigue_planner.planners.policy import action_number, expected_action
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.cycles import stepper
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.problem import Pomdp, draw
from fatigue_planner.pomdp.scenario import Scenario

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


class Courses:
    """`count` runs of a scenario, or of any problem from a belief, of n_cycles cycles.

    All arrays are (count,): outcomes and observations of the last cycle, rewards, cycles, how many are over, and ended,
    whether the problem's own end is reached; states are (count, L). An observation is `nothing_seen`, the number of the
    problem's observations, before the first cycle.
    """

    def __init__(self, problem: Scenario | Belief, n_cycles: int, count: int) -> None:
        if n_cycles < 1 or count < 1:
            raise SelectionError(f"n_cycles = {n_cycles}, {count} environments: there must be at least one of each.")
        if problem.model.is_continuous:
            raise ProblemError("an environment shows one of finitely many observations; this problem's are continuous.")
        self._scenario = problem if isinstance(problem, Scenario) else None
        self._starts, self._weights = problem.states, problem.weights
        self.model: Pomdp = problem.model
        self.n_cycles, self.count = n_cycles, count
        self.nothing_seen = len(self.model.observations)
        self.outcome_name = "reaction" if isinstance(self.model, FatiguePomdp) else "outcome"
        self.states = np.zeros((count, problem.states.shape[1]))
        self.outcomes, self.observations = np.zeros(count, np.int64), np.zeros(count, np.int64)
        self.rewards, self.cycles = np.zeros(count), np.full(count, n_cycles)
        self.ended = np.zeros(count, bool)
        self._draws, self._quantiles = np.zeros((count, n_cycles, 2)), np.zeros((count, 3))
        self._seeds, self._trials = [0] * count, [0] * count
        self._world: Any = self.model.arrays
        self._step = stepper(self.model)

    def seed(self, run: int, seed: int) -> None:
        """Let a run be trial 0 of this seed when it begins, then trial 1, and so on."""
        self._seeds[run], self._trials[run] = seed, 0

    def begin(self, runs: Iterable[int]) -> None:
        """Begin some of the runs anew, each as its next trial."""
        name = "" if self._scenario is None else self._scenario.name
        prior = None if self._scenario is None else self._scenario.prior
        for run in runs:
            key = (self._seeds[run], name, self.n_cycles, self._trials[run])
            self._trials[run] += 1
            start = float(world_stream("start", *key).random()) if len(self._weights) > 1 else 0.0
            self.states[run] = self._starts[draw(self._weights, start)]
            self._draws[run, :, 0] = world_stream("preference", *key).random(self.n_cycles)
            if not self.model.observation_reveals_outcome:
                self._draws[run, :, 1] = world_stream("observation", *key).random(self.n_cycles)
            if prior is not None:
                self._quantiles[run] = world_stream("worker", *key).random(3)
                self.states[run, -1] = run
            self.observations[run], self.cycles[run] = self.nothing_seen, 0
            self.ended[run] = self.model.has_ended(self.states[run])
        if prior is not None:
            assert isinstance(self.model, FatiguePomdp)
            self._world = self.model.for_workers(prior.at(self._quantiles)).arrays

    def step(self, runs: Numbers, actions: Numbers) -> None:
        """One cycle of some of the runs, none of which may be over; actions (count,).

        Raises SelectionError for an action that a state forbids.
        """
        if self.model.dynamics.is_legal is not None:
            for run in runs:
                if not self.model.is_legal(self.states[run], int(actions[run])):
                    name = self.model.actions[actions[run]]
                    raise SelectionError(f"action {name!r}: forbidden in the state {self.states[run].tolist()}.")
        outcomes = len(self.model.outcomes)
        seen = (self.outcomes, self.observations, self.rewards)
        with self.model.told:
            self._step(self._world, runs, self.states, actions, self._draws, self.cycles, outcomes, *seen)
        if self.model.dynamics.is_terminal is not None:
            self.ended[runs] = [self.model.has_ended(self.states[run]) for run in runs]

    @property
    def cut(self) -> NDArray[np.bool_]:
        """Which runs have had all their cycles without reaching an end."""
        return np.asarray((self.cycles == self.n_cycles) & ~self.ended)

    def numbers_of(self, actions: Any) -> Numbers:
        """Actions (count,) as numbers; they may be given by name. Raises SelectionError for what is no action."""
        names = self.model.actions
        if isinstance(actions, np.ndarray) and actions.shape == (self.count,) and actions.dtype.kind in "iu":
            if 0 <= actions.min() <= actions.max() < len(names):
                return actions.astype(np.int64)
        elif isinstance(actions, np.ndarray | Sequence) and not isinstance(actions, str):
            found = [action_number(one, names) for one in actions]
            numbers = [number for number in found if number is not None]
            if len(numbers) == len(found) == self.count:
                return np.array(numbers)
        many = "" if self.count == 1 else f"{self.count} of "
        raise SelectionError(f"action {shortened(actions)}: must be {many}{expected_action(names)}.")

    def truth(self) -> dict[str, Any]:
        """What no policy may know, of every run: the fatigue (count, entries), or any other problem's state."""
        if isinstance(self.model, FatiguePomdp):
            active = self.model.active_entries
            fatigue = np.zeros((self.count, self.model.entries))
            fatigue[:, active] = self.states[:, : active.size]
            return {"fatigue": fatigue}
        return {"state": self.states.copy()}
