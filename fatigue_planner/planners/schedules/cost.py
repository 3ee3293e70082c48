"""What schedules cost from a belief on: in closed form where it is known, else by simulation."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import ProblemError
from fatigue_planner.core.jit import specialised
from fatigue_planner.core.random_streams import random_stream
from fatigue_planner.pomdp.beliefs.belief import Array, Belief
from fatigue_planner.pomdp.cyclic_plans import values_of_plans
from fatigue_planner.pomdp.fatigue_pomdp import FatiguePomdp
from fatigue_planner.pomdp.problem import Vector, advance, draw, outcome_probabilities

Schedules = NDArray[np.intp]

# The most states of a belief, or histories where reactions are chance, that a schedule is judged by; at a first look.
SAMPLES, FEW = 64, 4
# What comes after a simulation is discounted to less than this; at a first look.
TAIL, FEW_TAIL = 1e-6, 0.02


class ScheduleCost(ABC):
    """The expected discounted cost of endless schedules for one worker, or for what is believed of one."""

    @abstractmethod
    def costs(self, schedules: Schedules) -> Vector:
        """Of schedules (P, length), which repeat for ever: (P,)."""

    def few(self) -> "ScheduleCost":
        """The same, roughly, in less time: to choose which schedules are worth a closer look."""
        return self


def schedule_cost(belief: Belief) -> ScheduleCost:
    """What schedules cost from this belief on. Raises ProblemError without a discount below 1."""
    model = belief.model
    if model.discount >= 1:
        raise ProblemError("schedules repeat for ever: they have no cost without a discount below 1.")
    states, weights = _thinned(belief.states, belief.weights)
    if isinstance(model, FatiguePomdp) and model.arrays.even and model.cost.is_quadratic:
        return ClosedForm(model, states, weights)
    certain = isinstance(model, FatiguePomdp) and model.is_experts
    if not certain:  # every history draws its own reactions
        states, weights = _systematic(states, weights, SAMPLES)
    uniforms = random_stream(0, "schedules").random((len(weights), _cycles(model.discount, TAIL)))
    return Simulated(belief, states, weights, uniforms)


def _cycles(discount: float, tail: float) -> int:
    """After so many cycles, what follows is discounted to less than `tail`."""
    return math.ceil(math.log(tail) / math.log(discount)) if discount > 0 else 1


class ClosedForm(ScheduleCost):
    """Where all reactions are equally likely and the cost is quadratic: the belief's moments in the plans' values."""

    def __init__(self, model: FatiguePomdp, states: Array, weights: Vector) -> None:
        self._model, self._states, self._weights = model, states, weights
        used, worker = np.unique(states[:, -1].astype(np.intp), return_inverse=True)
        self._maps = model.mean_maps(used)
        share = np.zeros((used.size, weights.size))
        share[worker, np.arange(weights.size)] = weights
        fatigue = states[:, :-1]
        self._squares, self._means, self._shares = share @ fatigue**2, share @ fatigue, share.sum(axis=1)

    def costs(self, schedules: Schedules) -> Vector:
        """See ScheduleCost.costs; exact."""
        values = values_of_plans(self._maps, self._model.discount, self._model.entries, schedules)
        fatigue = (values.square * self._squares[:, None] + values.linear * self._means[:, None]).sum(axis=-1)
        return np.asarray(-(fatigue + values.constant * self._shares[:, None]).sum(axis=0))

    def few(self) -> ScheduleCost:
        """See ScheduleCost.few: with fewer of the workers."""
        if self._shares.size <= FEW:
            return self
        return ClosedForm(self._model, *_systematic(self._states, self._weights, FEW))


class Simulated(ScheduleCost):
    """For all other workers and costs: the workers' own choices, with the same draws for every schedule."""

    def __init__(self, belief: Belief, states: Array, weights: Vector, uniforms: Array) -> None:
        self._belief, self._states, self._weights, self._uniforms = belief, states, weights, uniforms

    def costs(self, schedules: Schedules) -> Vector:
        """See ScheduleCost.costs; exact for an expert, else the mean over the histories."""
        model = self._belief.model
        parts = {name: model.parts[name] for name in ("outcome_probabilities", "advance")}
        costs = np.zeros(len(schedules))
        specialised(add_costs, **parts)(
            model.arrays, self._states, self._weights, self._uniforms, schedules, len(model.outcomes), model.discount,
            costs,
        )  # fmt: skip
        return costs

    def few(self) -> ScheduleCost:
        """See ScheduleCost.few: with fewer of the histories, if there are so many, and fewer cycles."""
        kept = np.unique(np.linspace(0, len(self._weights) - 1, FEW).astype(np.intp))
        weights = self._weights[kept] / self._weights[kept].sum()
        cycles = _cycles(self._belief.model.discount, FEW_TAIL)
        return Simulated(self._belief, self._states[kept], weights, self._uniforms[kept, :cycles])


class MeanCost(ScheduleCost):
    """One schedule for several workers: the mean of what it costs each.

    workers: what schedules cost each, and the numbers (A,) that the common actions have in his problem.
    """

    def __init__(self, workers: Sequence[tuple[ScheduleCost, Schedules]]) -> None:
        self._workers = workers

    def costs(self, schedules: Schedules) -> Vector:
        """See ScheduleCost.costs."""
        return np.asarray(np.mean([cost.costs(numbers[schedules]) for cost, numbers in self._workers], axis=0))

    def few(self) -> ScheduleCost:
        """See ScheduleCost.few."""
        return MeanCost([(cost.few(), numbers) for cost, numbers in self._workers])


def add_costs(
    arrays: object,
    states: Array,
    weights: Vector,
    uniforms: Array,
    schedules: Schedules,
    outcomes: int,
    discount: float,
    costs: Vector,
) -> None:
    """Template: add to `costs` (P,) those of every schedule, simulated from every state with its own draws."""
    probabilities = np.empty(outcomes)
    state = np.empty(states.shape[1])
    for p in range(schedules.shape[0]):
        for i in range(weights.size):
            for j in range(state.size):
                state[j] = states[i, j]
            weight = weights[i]
            for cycle in range(uniforms.shape[1]):
                action = schedules[p, cycle % schedules.shape[1]]
                outcome_probabilities(arrays, state, action, probabilities)
                outcome = draw(probabilities, uniforms[i, cycle])
                costs[p] -= weight * advance(arrays, state, action, outcome)
                weight *= discount


def _thinned(states: Array, weights: Vector) -> tuple[Array, Vector]:
    return (states, weights) if len(weights) <= SAMPLES else _systematic(states, weights, SAMPLES)


def _systematic(states: Array, weights: Vector, count: int) -> tuple[Array, Vector]:
    """So many equally likely states: systematic resampling, every state as often as its weight says, within one."""
    points = (np.arange(count) + 0.5) / count
    chosen = np.minimum(np.searchsorted(np.cumsum(weights), points), len(weights) - 1)
    return states[chosen], np.full(count, 1 / count)
