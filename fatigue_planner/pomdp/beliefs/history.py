"""What rejuvenation needs to know about the past of particles: it lets other workers live through it."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled, inlined
from fatigue_planner.pomdp.beliefs.forgotten import Forgotten
from fatigue_planner.pomdp.fatigue_pomdp import FatigueArrays, FatiguePomdp, first_row, preference_probabilities
from fatigue_planner.pomdp.problem import draw
from fatigue_planner.pomdp.simd import move
from fatigue_planner.pomdp.timing import AS_PLANNED, Pace

Vector = NDArray[np.float64]
Array = NDArray[np.float64]

# The probability in a particle's past of an outcome that was seen although the particle holds it impossible.
MIN_PROBABILITY = 1e-300
NOTHING = np.zeros((0, 0))


@dataclass(frozen=True)
class History:
    """The last t cycles of n particles.

    start (n, L): where each particle began; actions (t,); outcomes (n, t); shares (t,): of the planned duration, that
    each reaction took; rest_s (t + 1,): the pauses, of which number i is before cycle i (see `timing.Pace`);
    likelihoods (t, U): the evidence

    log_likelihood (n,): the log of the probability of the outcomes from cycle `settled` on; that of all earlier
    evidence is in `forgotten`. The cycles before are there because fatigue depends on them.
    """

    start: Array
    actions: NDArray[np.int64]
    outcomes: NDArray[np.int16]
    shares: Vector
    rest_s: Vector
    likelihoods: Array
    log_likelihood: Vector
    settled: int = 0
    forgotten: Forgotten | None = None

    @staticmethod
    def begin(states: Array) -> "History":
        """The history before the first cycle."""
        count = len(states)
        outcomes = np.zeros((count, 0), np.int16)
        return History(states, np.zeros(0, np.int64), outcomes, np.zeros(0), np.zeros(1), NOTHING, np.zeros(count))

    def then(
        self,
        action: int,
        outcomes: NDArray[np.int16],
        likelihood: Vector,
        log_likelihood: Vector,
        pace: Pace = AS_PLANNED,
    ) -> "History":
        """The history with one more cycle, whose outcomes alone have this log_likelihood."""
        return replace(
            self,
            actions=np.append(self.actions, action),
            outcomes=np.column_stack([self.outcomes, outcomes]),
            shares=np.append(self.shares, pace.share),
            rest_s=np.append(self.rest_s, pace.rest_s),
            likelihoods=np.append(self.likelihoods.reshape(-1, likelihood.size), likelihood[None], axis=0),
            log_likelihood=self.log_likelihood + log_likelihood,
        )

    def resting(self, seconds: float) -> "History":
        """The history with a pause."""
        rest_s = self.rest_s.copy()
        rest_s[-1] += seconds
        return replace(self, rest_s=rest_s)

    def pick(self, chosen: NDArray[np.intp]) -> "History":
        """The past of some of the particles."""
        own = {name: getattr(self, name)[chosen] for name in ("start", "outcomes", "log_likelihood")}
        return replace(self, **own)

    def first(self, cycles: int) -> "History":
        """The first cycles, up to the end of the last of them."""
        rest_s = self.rest_s[: cycles + 1].copy()
        rest_s[-1] = 0
        return replace(
            self,
            actions=self.actions[:cycles],
            outcomes=self.outcomes[:, :cycles],
            shares=self.shares[:cycles],
            rest_s=rest_s,
            likelihoods=self.likelihoods[:cycles],
        )

    def without(self, cycles: int, start: Array) -> "History":
        """The history without its first cycles, at the end of which the particles were in `start`."""
        return replace(
            self,
            start=start,
            actions=self.actions[cycles:],
            outcomes=self.outcomes[:, cycles:],
            shares=self.shares[cycles:],
            rest_s=self.rest_s[cycles:],
            likelihoods=self.likelihoods[cycles:],
            settled=self.settled - cycles,
        )


class Past(NamedTuple):
    """What `live_again` reads of a history, and of the workers it is lived by.

    actions, outcomes, rest_s, settled, likelihoods: see History. gain, offset (tables * M * A * U, W): the cycle maps
    as lived, of which cycle i is in table number tables[i]; fade, grow (M, W): at rest, df/dt = grow - fade f
    """

    actions: NDArray[np.int64]
    outcomes: NDArray[np.int16]
    rest_s: Vector
    settled: int
    likelihoods: Array
    gain: Array
    offset: Array
    tables: NDArray[np.intp]
    fade: Array
    grow: Array


def relive(model: FatiguePomdp, states: Array, history: History) -> Vector:
    """Take states (n, L) in place through the past of particles (n,).

    Returns for each the log of its outcomes' probability since the history settled, (n,).
    """
    return live_again(model.arrays, lived_by(model, history), states, len(model.outcomes))


def lived_by(model: FatiguePomdp, history: History) -> Past:
    """The history with the maps of the model's workers."""
    shares, tables = np.unique(history.shares, return_inverse=True)
    lived = [model.evidence_arrays(share).lived for share in shares] or [model.arrays]
    gain, offset = lived[0].gain, lived[0].offset
    if len(lived) > 1:
        gain, offset = (np.concatenate([getattr(arrays, name) for arrays in lived]) for name in ("gain", "offset"))
    fade, grow = model.rest_rates() if history.rest_s.any() else (NOTHING, NOTHING)
    return Past(
        history.actions,
        np.ascontiguousarray(history.outcomes),  # one type, so that nothing is compiled in mid-shift
        history.rest_s,
        history.settled,
        history.likelihoods.reshape(-1, len(model.outcomes)),
        gain,
        offset,
        tables,
        fade,
        grow,
    )


@inlined
def pause(past: Past, state: Vector, number: int) -> None:
    """Let the worker of a state rest for pause `number`. Neighbouring entries often fade at the same rate."""
    seconds = past.rest_s[number]
    if seconds > 0:
        worker = int(state[state.size - 1])
        left, held, last = 1.0, seconds, 0.0
        for j in range(state.size - 1):
            fade = past.fade[worker, j]
            if fade != last:
                left = math.exp(-fade * seconds)
                held = -math.expm1(-fade * seconds) / fade if fade > 0 else seconds
                last = fade
            state[j] = left * state[j] + past.grow[worker, j] * held


@inlined
def react_again(arrays: FatigueArrays, past: Past, state: Vector, cycle: int, outcome: int) -> None:
    """Take a state through a cycle with this outcome, and the pause after it."""
    row = first_row(arrays, state, past.actions[cycle]) + outcome
    move(past.gain, past.offset, state, past.tables[cycle] * arrays.gain.shape[0] + row)
    pause(past, state, cycle + 1)


@compiled
def live_again(arrays: FatigueArrays, past: Past, states: Array, n_outcomes: int) -> Vector:
    """See `relive`."""
    log_likelihood = np.zeros(len(states))
    probabilities = np.empty(n_outcomes)
    for i in range(len(states)):
        pause(past, states[i], 0)
        for t in range(past.actions.size):
            outcome = past.outcomes[i, t]
            if t >= past.settled:
                preference_probabilities(arrays, states[i], past.actions[t], probabilities)
                log_likelihood[i] += np.log(max(probabilities[outcome], MIN_PROBABILITY))
            react_again(arrays, past, states[i], t, outcome)
    return log_likelihood


@compiled
def pick_evenly(weights: Vector, uniform: float) -> NDArray[np.int64]:
    """Systematic resampling."""
    chosen, last, end = np.empty(weights.size, np.int64), 0, weights[0]
    for i in range(weights.size):
        while end < (i + uniform) / weights.size and last < weights.size - 1:
            last += 1
            end += weights[last]
        chosen[i] = last
    return chosen


@compiled
def evidence_again(arrays: FatigueArrays, past: Past, start: Array, uniforms: Array, n_outcomes: int) -> Vector:
    """The log-likelihood (M,) that each worker gives to the evidence since the history settled, by particle filters.

    Each has m particles, which began in `start` (m, L), and draws by the same uniforms (cycles, m + 1), so that
    differences between workers are no noise.
    """
    found = np.zeros(arrays.expertise.size)
    probabilities, weights = np.empty(n_outcomes), np.empty(len(start))
    for worker in range(found.size):
        states = start.copy()
        states[:, -1] = worker
        weights[:] = 1 / weights.size
        for i in range(weights.size):
            pause(past, states[i], 0)
        for t in range(past.actions.size):
            now, total = uniforms[t], 0.0
            for i in range(weights.size):
                preference_probabilities(arrays, states[i], past.actions[t], probabilities)
                likelihood = 0.0
                for u in range(n_outcomes):
                    probabilities[u] = max(probabilities[u], MIN_PROBABILITY) * past.likelihoods[t, u]
                    likelihood += probabilities[u]
                probabilities /= likelihood
                react_again(arrays, past, states[i], t, draw(probabilities, now[i]))
                weights[i] *= likelihood
                total += weights[i]
            found[worker] += np.log(total) if t >= past.settled else 0.0
            weights /= total
            if np.sum(weights * weights) * weights.size > 2:  # half of them carry the weight: systematic resampling
                states = states[pick_evenly(weights, now[weights.size])]
                weights[:] = 1 / weights.size
    return found
