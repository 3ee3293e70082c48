"""A simulated worker: what a person truly does and how tired that makes him, which the server never learns."""

import numpy as np

from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.pomdp.fatigue_pomdp import recognition_of
from fatigue_planner.pomdp.problem import draw
from fatigue_planner.pomdp.scenario import Scenario


class SimulatedWorker:
    """A worker of a scenario, with a start, hidden parameters and choices of his own, all drawn from a seed."""

    def __init__(self, scenario: Scenario, seed: int, pseudonym: str) -> None:
        self.pseudonym = pseudonym
        self._rng = random_stream(seed, "rehearsal worker", pseudonym)
        self._model = scenario.worker(self._rng.random(3))
        self._state = scenario.start(self._rng.random())

    def work(self, action: str) -> str:
        """Live through a cycle; as what a recogniser takes the reaction."""
        model, number = self._model, self._model.actions.index(action)
        outcome = draw(model.probabilities(self._state, number), self._rng.random())
        self._state, _ = model.transition(self._state, number, outcome)
        chances = np.asarray(model.arrays.observation[recognition_of(model.arrays, number), outcome])
        return model.observations[draw(chances, self._rng.random())]

    def rest(self, seconds: float) -> None:
        """Do nothing for so long."""
        self._state = self._model.rested(self._state[None], seconds)[0]
