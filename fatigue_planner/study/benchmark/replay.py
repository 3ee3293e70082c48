"""Replays runs from the actions taken: the random numbers are drawn before a run, so its course follows from them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.random_streams import draw_random_numbers
from fatigue_planner.pomdp.problem import Vector
from fatigue_planner.study.benchmark.cell import Cell
from fatigue_planner.study.benchmark.trial import cycle_of


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
    model = cell.scenario.worker(random_numbers.worker)
    state: Vector = cell.scenario.start(random_numbers.start)
    fatigue, observations = np.zeros((len(actions), model.entries)), []
    total, discount = 0.0, 1.0
    for cycle, action in enumerate(actions):
        state, _, reward, observation = cycle_of(model, state, action, random_numbers, cycle)
        total += discount * reward
        discount *= model.discount
        fatigue[cycle, model.active_entries] = state[: model.active_entries.size]
        observations.append(observation)
    return Course(fatigue, tuple(observations), total)
