"""How likely recognised reactions are, given beta, offsets and inertia; and its gradient.

The reaction u_t of cycle t is hidden, what it was recognised as, o_t, is known:

    P(u_t = u | u_t-1 = v) is proportional to exp(w_u + inertia [u = v] - beta c_t(u)),    P(o_t | u_t): the confusion.

That is a hidden Markov model over the preferences: the forward algorithm has its likelihood, and by Fisher's identity
the smoothed reactions have its gradient (Cappe, Moulines, Ryden, Inference in Hidden Markov Models 2005, section 10.1).
The confusion is estimated together with the rest from labelled repetitions, so that what is not known of it widens the
intervals.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.jit import compiled

Vector = NDArray[np.float64]
Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

# Added to every cell of labelled repetitions (Jeffreys' prior): what never happened is not impossible.
PRIOR_COUNT = 0.5
UNSEEN = -1


@dataclass(frozen=True)
class Confusion:
    """What reactions are recognised as, P(o | u), by group of actions.

    chances (G, U, O): known, or a first guess; labelled (G, U, O): how often it was seen, None where it is known.
    """

    chances: Array
    labelled: Array | None = None

    @staticmethod
    def from_counts(labelled: Array) -> "Confusion":
        """That of labelled repetitions (G, U, O)."""
        counts = labelled + PRIOR_COUNT
        return Confusion(counts / counts.sum(axis=-1, keepdims=True), counts)


@dataclass(frozen=True)
class Choices:
    """Cycles of one worker.

    costs (n, U): what every preference would have cost; seen (n,): numbers of what was recognised, or UNSEEN; group
    (n,): of the confusion's matrices; begins (n,): whether nothing is known of the cycle before.
    """

    costs: Array
    seen: Numbers
    group: Numbers
    begins: NDArray[np.bool_]


@dataclass(frozen=True)
class Smoothed:
    """log_likelihood; chances, filtered (n, U): of every reaction, given all that was seen, or seen up to then.

    residual (n, U), stay: by how much likelier reactions, and repetitions, were than the model has them.
    """

    log_likelihood: float
    chances: Array
    filtered: Array
    residual: Array
    stay: float


def smoothed(utility: Array, inertia: float, choices: Choices, confusion: Array) -> Smoothed:
    """The reactions given what was seen, with utilities (n, U) without inertia and P(o | u) (G, U, O)."""
    seen = confusion[choices.group, :, np.maximum(choices.seen, 0)]
    evidence = np.where((choices.seen == UNSEEN)[:, None], 1.0, seen)
    chances, forward, residual = np.empty_like(utility), np.empty_like(utility), np.empty_like(utility)
    log_likelihood, stay = smooth(utility, inertia, evidence, choices.begins, chances, forward, residual)
    return Smoothed(log_likelihood, chances, forward, residual, stay)


@compiled
def smooth(  # noqa: PLR0912 - loops over cycles and preferences
    utility: Array,
    inertia: float,
    evidence: Array,
    begins: NDArray[np.bool_],
    chances: Array,
    forward: Array,
    residual: Array,
) -> tuple[float, float]:
    """Forwards, then backwards, through the cycles; fills `chances`, `forward` and `residual`. See `Smoothed`."""
    count, size = utility.shape
    after = np.empty((count, size, size))  # P(u | v)
    ahead, before = np.ones(size), np.empty(size)
    total = 0.0
    for t in range(count):
        for v in range(size):
            largest = -np.inf
            for u in range(size):
                after[t, v, u] = utility[t, u] + (inertia if u == v and not begins[t] else 0.0)
                largest = max(largest, after[t, v, u])
            scale = 0.0
            for u in range(size):
                after[t, v, u] = np.exp(after[t, v, u] - largest)
                scale += after[t, v, u]
            for u in range(size):
                after[t, v, u] /= scale
        norm = 0.0
        for u in range(size):
            forward[t, u] = after[t, 0, u] if begins[t] else 0.0
            if not begins[t]:
                for v in range(size):
                    forward[t, u] += forward[t - 1, v] * after[t, v, u]
            forward[t, u] *= evidence[t, u]
            norm += forward[t, u]
        total += np.log(norm)
        for u in range(size):
            forward[t, u] /= norm
    stay = 0.0
    for t in range(count - 1, -1, -1):
        norm = 0.0
        for u in range(size):
            chances[t, u] = forward[t, u] * ahead[u]
            norm += chances[t, u]
        for u in range(size):
            chances[t, u] /= norm
            residual[t, u] = chances[t, u]
        if begins[t]:
            for u in range(size):
                residual[t, u] -= after[t, 0, u]
                ahead[u] = 1.0
            continue
        norm = 0.0
        for v in range(size):
            before[v] = 0.0
            for u in range(size):
                before[v] += after[t, v, u] * evidence[t, u] * ahead[u]
            norm += forward[t - 1, v] * before[v]
        for v in range(size):
            share = forward[t - 1, v] * before[v] / norm  # P(v | all that was seen)
            stay += forward[t - 1, v] * after[t, v, v] * evidence[t, v] * ahead[v] / norm - share * after[t, v, v]
            for u in range(size):
                residual[t, u] -= share * after[t, v, u]
        largest = before.max()
        for v in range(size):
            ahead[v] = before[v] / largest
    return total, stay


def confusion_terms(logits: Array, choices: Choices, chances: Array, labelled: Array) -> tuple[float, Array]:
    """The log-likelihood of labelled repetitions, and the gradient by logits (G, U, O) of it and of what was seen."""
    matrix = softmax(logits)
    counts = labelled.copy()
    known = choices.seen != UNSEEN
    np.add.at(counts.transpose(0, 2, 1), (choices.group[known], choices.seen[known]), chances[known])
    gradient = counts - counts.sum(axis=-1, keepdims=True) * matrix
    return float((labelled * np.log(matrix)).sum()), gradient


def softmax(logits: Array) -> Array:
    """Exponentials over the last axis that sum to 1."""
    weights = np.exp(logits - logits.max(axis=-1, keepdims=True))
    return np.asarray(weights / weights.sum(axis=-1, keepdims=True))
