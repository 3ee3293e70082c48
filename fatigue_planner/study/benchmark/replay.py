"""Replays runs from the actions taken: the random numbers are drawn before a run, so its course follows from them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.random_streams import draw_random_numbers
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.trial import Episode


@dataclass(frozen=True)
class Course:
    """What happened in a run of n cycles.

    start: (entries,) the fatigue at the beginning; fatigue: (n, entries) after every cycle; reactions: (n,) the action
    and the preference; observations: (n,) what each reaction was recognised as; discounted_return: what the run came
    to.
    """

    start: NDArray[np.float64]
    fatigue: NDArray[np.float64]
    reactions: tuple[tuple[str, str], ...]
    observations: tuple[int, ...]
    discounted_return: float


def replay(cell: Cell, trial: int, actions: Sequence[int]) -> Course:
    """The course of a trial in which these actions were taken, bit for bit that of the run."""
    random_numbers = draw_random_numbers(cell.seed, cell.condition, cell.n_cycles, trial)
    episode = Episode(cell.scenario, random_numbers)
    cycles = [episode.step(action) for action in actions]
    model = episode.model
    fatigue = np.array([model.fatigue(cycle.state) for cycle in cycles])
    start = episode.model.fatigue(cell.scenario.start(random_numbers.start))
    reactions = tuple((model.actions[cycle.action], model.outcomes[cycle.preference]) for cycle in cycles)
    observations = tuple(cycle.observation for cycle in cycles)
    return Course(start, fatigue, reactions, observations, episode.discounted_return)
