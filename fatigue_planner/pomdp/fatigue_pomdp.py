"""The fatigue POMDP (paper, sections III-A and IV-D), for one worker or for several possible ones.

A state holds the fatigue of the active entries, padded with zeros to a multiple of LANES; its last element is the
index of the worker it belongs to. Where the worker is known there is only one, with index 0. Where choices depend on
the last one, the last element of the padding says which that was: 0 for none, else the number of the preference + 1.
Cycles write it as they change fatigue, by a map whose gain is 0; it costs nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import inlined
from fatigue_planner.core.pcg64 import below, uniform
from fatigue_planner.fatigue.model import CycleProfile
from fatigue_planner.pomdp.boltzmann import lowest, normalise_choice, relative_chance, weigh
from fatigue_planner.pomdp.cost import CostArrays, FatigueCost, cost_after, cost_moving, mean_square
from fatigue_planner.pomdp.cyclic_plans import MeanMaps, PlanValues, best_plan_value, mean_maps, plan_values
from fatigue_planner.pomdp.problem import Dynamics, Pomdp, draw
from fatigue_planner.pomdp.simd import LANES, aligned, move
from fatigue_planner.pomdp.timing import Pace, Timing, checked_seconds

Vector = NDArray[np.float64]
Array = NDArray[np.float64]


class FatigueArrays(NamedTuple):
    """What the compiled functions read.

    gain, offset (M * A * U, W): row (m * A + a) * U + u is worker m's cycle map of action a and preference u
    expertise (M,): beta of Eq. 4; `even`: every preference is equally likely, always
    factors (1 or 1 + U, U): of the Boltzmann factors, the same always or by the last choice (see `choices`)
    observation (1 or A, U, O): P(o | u), the same for all actions or by action; `observation_reveals_outcome`: the
        observation always is the preference
    """

    gain: Array
    offset: Array
    expertise: Vector
    even: bool
    factors: Array
    observation: Array
    observation_reveals_outcome: bool
    n_actions: int
    cost: CostArrays


@inlined
def first_row(arrays: FatigueArrays, state: Vector, action: int) -> int:
    """The row of the action's first preference."""
    worker = int(state[state.size - 1])
    return int((worker * arrays.n_actions + action) * arrays.factors.shape[1])


@inlined
def expertise_of(arrays: FatigueArrays, state: Vector) -> float:
    """beta of the state's worker."""
    return float(arrays.expertise[int(state[state.size - 1])])


@inlined
def factor_row(arrays: FatigueArrays, state: Vector) -> int:
    """The row of `factors` that holds in the state."""
    return 0 if arrays.factors.shape[0] == 1 else int(state[state.size - 2])


@inlined
def costs_after(arrays: FatigueArrays, state: Vector, action: int, costs: Vector) -> None:
    """The cost (Eq. 5) after the coming cycle for every preference, (U,)."""
    row = first_row(arrays, state, action)
    for u in range(costs.size):
        costs[u] = cost_after(arrays.cost, arrays.gain, arrays.offset, state, row + u)


@inlined
def preference_probabilities(arrays: FatigueArrays, state: Vector, action: int, probabilities: Vector) -> None:
    """Eq. 4: P(u | f, a) for every preference; the cost is that after the coming cycle."""
    expertise = expertise_of(arrays, state)
    if expertise == 0:
        for u in range(probabilities.size):
            probabilities[u] = 0.0
    else:
        costs_after(arrays, state, action, probabilities)
    normalise_choice(probabilities, expertise, arrays.factors, factor_row(arrays, state))


@inlined
def react(arrays: FatigueArrays, state: Vector, action: int, preference: int) -> float:
    """Apply the cycle to the fatigue; the reward -C(f), in the paper C(f) = sum over 2N entries of f^2 / 2N (Eq. 5)."""
    row = first_row(arrays, state, action) + preference
    return -cost_moving(arrays.cost, arrays.gain, arrays.offset, state, row)


@inlined
def recognition_of(arrays: FatigueArrays, action: int) -> int:
    """Which matrix of `observation` is the action's."""
    return int(min(action, arrays.observation.shape[0] - 1))


@inlined
def recognition(arrays: FatigueArrays, _state: Vector, action: int, preference: int, observation: int) -> float:
    """P(o | u): the probability that preference u is recognised as o."""
    return float(arrays.observation[recognition_of(arrays, action), preference, observation])


@inlined
def recognise(arrays: FatigueArrays, action: int, preference: int, rng: np.random.Generator) -> int:
    """A draw of o from P(o | u)."""
    if arrays.observation_reveals_outcome:
        return preference
    return draw(arrays.observation[recognition_of(arrays, action), preference], uniform(rng))


@inlined
def react_to_anything(
    arrays: FatigueArrays, state: Vector, action: int, scratch: Vector, rng: np.random.Generator
) -> tuple[int, float]:
    """The generative model of Fig. 4 for novices, whose choice does not depend on costs."""
    preference = below(rng, scratch.size)
    reward = react(arrays, state, action, preference)
    return recognise(arrays, action, preference, rng), reward


@inlined
def react_surely(
    arrays: FatigueArrays, state: Vector, action: int, scratch: Vector, rng: np.random.Generator
) -> tuple[int, float, bool]:
    """`react_to_costs`, and whether the worker always chooses so in this state."""
    row = first_row(arrays, state, action)
    expertise = expertise_of(arrays, state)
    preference, least, ties = 0, np.inf, 0
    for u in range(scratch.size):
        cost = cost_after(arrays.cost, arrays.gain, arrays.offset, state, row + u)
        scratch[u] = cost
        ties = 1 if cost < least else ties + (cost == least)
        preference = u if cost < least else preference
        least = min(cost, least)
    sure = ties == 1 and expertise == np.inf
    if sure:
        move(arrays.gain, arrays.offset, state, row + preference)
        reward = -least
    else:
        total = weigh(scratch, least, expertise, arrays.factors, factor_row(arrays, state))
        preference = draw(scratch, total * uniform(rng))
        reward = react(arrays, state, action, preference)
    return recognise(arrays, action, preference, rng), reward, sure


@inlined
def react_to_costs(
    arrays: FatigueArrays, state: Vector, action: int, scratch: Vector, rng: np.random.Generator
) -> tuple[int, float]:
    """The generative model of Fig. 4. An expert with one cheapest preference needs no draw, and the cost is known."""
    observation, reward, _ = react_surely(arrays, state, action, scratch, rng)
    return observation, reward


@inlined
def expected_reward(arrays: FatigueArrays, state: Vector, action: int, probabilities: Vector, _moved: Vector) -> float:
    """The mean of -C over the preferences, and their probabilities; every cost is computed once."""
    expertise, row = expertise_of(arrays, state), factor_row(arrays, state)
    costs_after(arrays, state, action, probabilities)
    least = lowest(probabilities)
    total, weighted = 0.0, 0.0
    for u in range(probabilities.size):
        cost = probabilities[u]
        chance = relative_chance(cost - least, expertise) * arrays.factors[row, u]
        probabilities[u] = chance
        total += chance
        weighted += chance * cost
    for u in range(probabilities.size):
        probabilities[u] /= total
    return -weighted / total


FATIGUE = Dynamics(preference_probabilities, react, recognition, react_to_costs, expected_reward, best_plan_value)


class PacedArrays(NamedTuple):
    """The arrays of the cycles as planned, by which the worker chooses, and as lived through (see `timing`)."""

    planned: FatigueArrays
    lived: FatigueArrays


@inlined
def choose_as_planned(arrays: PacedArrays, state: Vector, action: int, probabilities: Vector) -> None:
    """`preference_probabilities` by the planned cycles."""
    preference_probabilities(arrays.planned, state, action, probabilities)


@inlined
def react_as_lived(arrays: PacedArrays, state: Vector, action: int, preference: int) -> float:
    """`react` in the time it really took."""
    return react(arrays.lived, state, action, preference)


class Workers(NamedTuple):
    """Possible workers, each (M,): factors on all rates k and R of Eq. 2, and beta of Eq. 4."""

    fatigue_rate_factor: Vector
    recovery_rate_factor: Vector
    expertise: Vector

    def pick(self, chosen: NDArray[np.intp]) -> "Workers":
        """Some of the workers."""
        return Workers(*(values[chosen] for values in self))


def one_worker(expertise: float) -> Workers:
    """The worker whose rates are the experiment's."""
    return Workers(np.ones(1), np.ones(1), np.array([float(expertise)]))


@dataclass(frozen=True)
class FatiguePomdp(Pomdp):
    """The POMDP of a task.

    active_entries: which of the `entries` entries its states hold; profiles (A, U): its cycles; cost: what it costs;
    timing: how long they take, and what rest does; None: not known.
    """

    active_entries: NDArray[np.intp]
    entries: int
    profiles: tuple[tuple[CycleProfile, ...], ...]
    workers: Workers
    cost: FatigueCost
    timing: Timing | None = field(default=None, kw_only=True)

    is_trusted: ClassVar[bool] = True

    @property
    def is_experts(self) -> bool:
        """Whether every possible worker is an expert, whose choice is certain except for ties."""
        return bool(np.isinf(self.workers.expertise).all())

    def state(self, fatigue: Vector, worker: int = 0) -> Vector:
        """The state of a fatigue (entries,)."""
        state = np.zeros(self.arrays.gain.shape[1] + 1)
        state[: self.active_entries.size] = fatigue[self.active_entries]
        state[-1] = worker
        return state

    def fatigue(self, state: Vector) -> Vector:
        """The fatigue (entries,) that a state stands for."""
        fatigue = np.zeros(self.entries)
        fatigue[self.active_entries] = state[: self.active_entries.size]
        return fatigue

    def for_workers(self, workers: Workers, share: float = 1.0) -> "FatiguePomdp":
        """The same task for other workers, whose cycles take a share of the planned duration (see `timing`)."""
        faster, sooner = share * workers.fatigue_rate_factor, share * workers.recovery_rate_factor
        rows = [
            [profile.maps(faster, sooner) for profile in row] for row in self.profiles
        ]  # A x U x (gain, offset), each (M, entries)
        gain, offset = np.moveaxis(np.array(rows), 2, 0)
        return self.with_maps(np.moveaxis(gain, 2, 0), np.moveaxis(offset, 2, 0), workers)

    @cached_property
    def parts(self) -> dict[str, Any]:
        """See Pomdp.parts; novices' choices are drawn without computing costs."""
        parts = self.dynamics.parts(len(self.observations))
        return parts | {"step": react_to_anything} if self.arrays.even else parts

    @cached_property
    def evidence_parts(self) -> dict[str, Any]:
        """See Pomdp.evidence_parts."""
        return super().evidence_parts | {"outcome_probabilities": choose_as_planned, "advance": react_as_lived}

    def evidence_arrays(self, share: float) -> PacedArrays:
        """See Pomdp.evidence_arrays."""
        lived = self.arrays if share == 1 else self.for_workers(self.workers, share).arrays
        return PacedArrays(self.arrays, lived)

    def pace(self, duration_s: float | None) -> Pace:
        """See Pomdp.pace."""
        return super().pace(duration_s) if duration_s is None or self.timing is None else self.timing.pace(duration_s)

    def rested(self, states: Array, seconds: float) -> Array:
        """See Pomdp.rested: every state by its own worker's rates."""
        if self.timing is None:
            return super().rested(states, seconds)
        used, worker = np.unique(states[:, -1].astype(np.intp), return_inverse=True)
        own = self.workers.pick(used)
        maps = self.timing.rest.maps(own.fatigue_rate_factor, own.recovery_rate_factor, checked_seconds(seconds))
        gain, offset = (table[:, self.active_entries][worker] for table in maps)
        after, active = states.copy(), self.active_entries.size
        after[:, :active] = gain * states[:, :active] + offset
        return after

    def rest_rates(self) -> tuple[Array, Array]:
        """How fast the fatigue of every worker fades and grows at rest, as in states, each (M, W) in 1/s."""
        assert self.timing is not None
        rates = self.timing.rest.rates(self.workers.fatigue_rate_factor, self.workers.recovery_rate_factor)
        fade, grow = map(self._padded, rates)
        return fade, grow

    @cached_property
    def bound_arrays(self) -> PlanValues:
        """The values of the best cyclic plans of every worker. Raises ExperimentError if the cost is no quadratic."""
        self.cost.check_quadratic("leaf value bound")
        return plan_values(self.mean_maps(np.arange(len(self.workers.expertise))), self.discount, self.entries)

    def mean_maps(self, workers: NDArray[np.intp]) -> MeanMaps:
        """The means of some workers' cycle maps over the reactions of who minds neither cost nor habit."""
        shape = (len(self.workers.expertise), len(self.actions), len(self.outcomes), -1)
        gain, offset = (table.reshape(shape)[workers] for table in (self.arrays.gain, self.arrays.offset))
        first = self.arrays.factors[0]
        chances = None if (first == 1).all() else first / first.sum()
        return mean_maps(gain, offset, self.arrays.cost.weight, self.posture_cost, chances)

    @cached_property
    def in_moments(self) -> "FatiguePomdp":
        """The task of novices whose states hold the means and then the standard deviations of the active entries.

        See `beliefs.moments`. Its `state` and `fatigue` are those of the task itself.
        """
        arrays, cost = self.arrays, self.arrays.cost
        twice = arrays._replace(
            gain=aligned(np.hstack([arrays.gain, arrays.gain])),
            offset=aligned(np.hstack([arrays.offset, np.zeros_like(arrays.offset)])),
            cost=cost._replace(weight=np.concatenate([cost.weight, cost.weight])),
        )
        return replace(self, arrays=twice, timing=None)

    @property
    def posture_cost(self) -> Array:
        """What the posture of every reaction adds to the cost, (A, U)."""
        return np.array([[profile.posture_cost for profile in row] for row in self.profiles])

    def with_maps(self, gain: Array, offset: Array, workers: Workers) -> "FatiguePomdp":
        """The same task with these cycle maps (M, A, U, entries)."""
        written = self._padded(offset)
        if self.remembers:
            written[:, -1] = np.arange(len(written)) % len(self.outcomes) + 1
        arrays = self.arrays._replace(
            gain=self._padded(gain),
            offset=written,
            cost=self._cost_arrays(len(gain)),
            expertise=workers.expertise,
            even=bool((workers.expertise == 0).all() and (self.arrays.factors == 1).all()),
        )
        return replace(self, arrays=arrays, workers=workers)

    def _cost_arrays(self, workers: int) -> CostArrays:
        weight = self._padded(self.cost.weights[None])[0]
        posture = np.tile(self.posture_cost.ravel(), workers)
        plain = self.cost.is_quadratic and not posture.any() and bool((self.cost.weights == 1).all())
        plain &= not self.remembers
        return CostArrays(weight, 1 / self.entries, posture, plain, self.cost.kind == "worst_joint")

    @property
    def remembers(self) -> bool:
        """Whether states say what the last choice was."""
        return len(self.arrays.factors) > 1

    def _padded(self, table: Array) -> Array:
        """The active entries of a table (..., entries) as in states, one row each."""
        width = self.active_entries.size + self.remembers
        rows = np.zeros((table[..., 0].size, width + -width % LANES))  # in C order, read row by row
        rows[:, : self.active_entries.size] = table[..., self.active_entries].reshape(len(rows), -1)
        return aligned(rows)


def build_pomdp(
    actions: Sequence[str],
    preferences: Sequence[str],
    profiles: Mapping[tuple[str, str], CycleProfile],
    initial_fatigue: Array,
    workers: Workers,
    discount: float,
    recognition_matrix: Array | None = None,
    observations: Sequence[str] | None = None,
    cost: FatigueCost | None = None,
    timing: Timing | None = None,
    log_odds: Array | None = None,
) -> FatiguePomdp:
    """The POMDP of the reactions `profiles[action, preference]`.

    `initial_fatigue` (n, 78) are the states the worker may start in; they and the reactions decide which
    entries are active; all others stay 0. `recognition_matrix` (U, O), or (A, U, O) by action: P(o | u) for the named
    `observations`; by default the preference is always recognised. `cost`: by default the paper's. Without `timing`,
    nothing is known of rest and of cycles that take another time than planned. `log_odds`: see
    `ChoiceModel.log_odds`; by default Eq. 4 alone decides.
    """
    table = tuple(tuple(profiles[a, u] for u in preferences) for a in actions)
    ever = (initial_fatigue != 0).any(axis=0)
    for profile in profiles.values():
        ever |= profile.tires
    observation_reveals_outcome = recognition_matrix is None
    observation = np.eye(len(preferences)) if recognition_matrix is None else recognition_matrix
    observation = observation.reshape(-1, *observation.shape[-2:])
    odds = np.zeros((1, len(preferences))) if log_odds is None else log_odds
    odds = odds[:1] if (odds == odds[0]).all() else odds  # else states would keep what nothing depends on
    factors = np.exp(odds - odds.max(axis=1, keepdims=True))
    empty = np.zeros((0, 0))
    nothing = CostArrays(np.zeros(0), 0.0, np.zeros(0), True, False)
    arrays = FatigueArrays(
        empty, empty, np.zeros(0), False, factors, observation, observation_reveals_outcome, len(actions), nothing
    )
    blank = FatiguePomdp(
        actions=tuple(actions),
        outcomes=tuple(preferences),
        observations=tuple(observations or preferences),
        discount=discount,
        arrays=arrays,
        dynamics=FATIGUE,
        observation_reveals_outcome=observation_reveals_outcome,
        active_entries=np.flatnonzero(ever),
        entries=ever.size,
        profiles=table,
        workers=workers,
        cost=cost or mean_square(ever.size),
        timing=timing,
    )
    return blank.for_workers(workers)


def fingerprint(model: FatiguePomdp) -> dict[str, Any]:
    """All that decides what the model does, as JSON values."""
    named = model.arrays._asdict()
    if len(model.arrays.factors) == 1 and (model.arrays.factors == 1).all():  # as before there were others
        del named["factors"]
    if len(model.arrays.observation) == 1:
        named["observation"] = model.arrays.observation[0]
    arrays = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in named.items()}
    posture = model.arrays.cost.posture.tolist()
    arrays["cost"] = {"kind": model.cost.kind, "weights": model.cost.weights.tolist(), "posture": posture}
    arrays["expertise"] = [repr(beta) for beta in model.workers.expertise.tolist()]
    return {"arrays": arrays, "discount": model.discount, "active_entries": model.active_entries.tolist()}
