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

    fatigue: (n, entries) after every cycle; observations: (n,) what each reaction was recognised as;
    discounted_return: what the run came to.
    """

    fatigue: NDArray[np.float64]
    observations: tuple[int, ...]
    discounted_return: float


def replay(cell: Cell, trial: int, actions: Sequence[int]) -> Course:
    """The course of a trial in which these actions were taken, bit for bit that of the run."""
    random_numbers = draw_random_numbers(cell.seed, cell.condition, cell.n_cycles, trial)
    episode = Episode(cell.scenario, random_numbers)
    cycles = [episode.step(action) for action in actions]
    fatigue = np.array([episode.model.fatigue(cycle.state) for cycle in cycles])
    return Course(fatigue, tuple(cycle.observation for cycle in cycles), episode.discounted_return)
