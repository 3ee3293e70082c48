"""Estimates without the first-order bias of maximum likelihood: Firth's adjusted scores.

Maximum likelihood errs upwards in beta: what errs upwards errs further. Firth (Biometrika 1993, 80:27) solves

    U(theta) + A(theta) = 0,    A_r = 1/2 trace(I^-1 (P_r + Q_r)),    P_r = E[U U' U_r],  Q_r = E[H U_r],

where U is the score, H the Hessian and I the expected information; -I^-1 A is the bias of Cox and Snell (J R Stat Soc B
1968, 30:248). It is found by scoring, theta <- theta + I^-1 (U + A) (Kosmidis and Firth, Electron J Stat 2010, 4:1097).
As a cycle t is recognised as one of few o, with p = P(o | what was seen before), both are sums:

    I = sum over t, o of p' p'^T / p,    P_r + Q_r = sum over t, o of p'' p'_r / p.

Without inertia cycles are independent and this is exact. With it, the chances of the reaction before are held as the
filter has them: what theta changes of them is left out. Labelled repetitions add to I only: the half repetition in
every cell is their own adjustment. Intervals do not change: they are those of the likelihood.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.recordings.learning.likelihood import UNSEEN, Choices, Smoothed, softmax

Vector = NDArray[np.float64]
Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

# Cycles whose derivatives are held at a time.
BLOCK = 2_000
# What is less likely is never recognised.
NEVER = 1e-300


@dataclass(frozen=True)
class Observed:
    """Cycles with what their derivatives need: costs (n, U) without mean, in usual differences; see `Choices`.

    labelled (G, U, O): None where the confusion `chances` (G, U, O) is known.
    """

    relative: Array
    choices: Choices
    chances: Array
    labelled: Array | None


def step(point: Vector, score: Vector, found: Smoothed, observed: Observed, free: Numbers) -> Vector | None:
    """I^-1 (U + A) at a point, over the numbers of it that are free; None where the information has no inverse.

    point, score: beta, U - 1 offsets, inertia, logits (G, U, O) if the confusion is not known. The last logit of each
    row is never free.
    """
    information = np.zeros((point.size, point.size))
    for index, first, _, chance in _derivatives(point, found, observed):
        np.add.at(information, (index[:, :, None], index[:, None]), np.einsum("noa,nob,no->nab", first, first, chance))
    if observed.labelled is not None:
        _add_labelled(information, point, observed)
    try:
        inverse = np.linalg.inv(information[np.ix_(free, free)])
    except np.linalg.LinAlgError:
        return None
    whole = np.zeros_like(information)
    whole[np.ix_(free, free)] = inverse
    adjusted = score.copy()
    for index, first, second, chance in _derivatives(point, found, observed):
        traces = np.einsum("nab,noab->no", whole[index[:, :, None], index[:, None]], second)
        np.add.at(adjusted, index, 0.5 * np.einsum("no,noa,no->na", traces, first, chance))
    moved = inverse @ adjusted[free]
    return np.asarray(moved) if np.isfinite(moved).all() else None


def _add_labelled(information: Array, point: Vector, observed: Observed) -> None:
    """Of a row of counts with chances p: their sum times (diag p - p p')."""
    labelled = observed.labelled
    assert labelled is not None
    matrix = softmax(point[-labelled.size :].reshape(labelled.shape))
    at = point.size - labelled.size
    for row, total in zip(matrix.reshape(-1, matrix.shape[-1]), labelled.sum(axis=-1).ravel(), strict=True):
        there = slice(at, at + row.size)
        information[there, there] += total * (np.diag(row) - np.outer(row, row))
        at += row.size


def _derivatives(point: Vector, found: Smoothed, observed: Observed) -> Iterator[tuple[Numbers, Array, Array, Array]]:
    """By blocks of n cycles: which numbers of the point matter (n, p), p' (n, O, p), p'' (n, O, p, p), 1 / p (n, O)."""
    size = observed.relative.shape[1]
    known = observed.choices.seen != UNSEEN
    cycles = np.flatnonzero(known)
    for begin in range(0, cycles.size, BLOCK):
        yield _of_block(point, size, cycles[begin : begin + BLOCK], found, observed)


def _of_block(
    point: Vector, size: int, cycles: Numbers, found: Smoothed, observed: Observed
) -> tuple[Numbers, Array, Array, Array]:
    leading, count = size + 1, cycles.size
    group, begins = observed.choices.group[cycles], observed.choices.begins[cycles]
    before = np.where(begins[:, None], np.eye(size)[0], found.filtered[cycles - 1])  # (n, V)
    # How utilities (n, V, U) change with the leading numbers, and the reactions' chances with them.
    design = np.zeros((count, size, size, leading))
    design[..., 0] = -observed.relative[cycles][:, None]
    design[:, :, 1:, 1:size] = np.eye(size - 1)
    design[..., size] = np.eye(size) * ~begins[:, None, None]
    utility = design @ point[:leading]
    chance = softmax(utility)
    apart = design - np.einsum("nvu,nvua->nva", chance, design)[:, :, None]
    spread = np.einsum("nvu,nvua,nvub->nvab", chance, apart, apart)
    first = np.einsum("nv,nvu,nvua->nua", before, chance, apart)
    second = np.einsum("nv,nvu,nvua,nvub->nuab", before, chance, apart, apart)
    second -= np.einsum("nv,nvu,nvab->nuab", before, chance, spread)
    reaction = np.einsum("nv,nvu->nu", before, chance)
    labelled = observed.labelled
    matrix = (observed.chances if labelled is None else softmax(point[leading:].reshape(labelled.shape)))[group]
    outcomes = matrix.shape[-1]
    seen = np.einsum("nu,nuo->no", reaction, matrix)
    own = 0 if labelled is None else size * outcomes
    total = leading + own
    p1, p2 = np.zeros((count, outcomes, total)), np.zeros((count, outcomes, total, total))
    p1[..., :leading] = np.einsum("nua,nuo->noa", first, matrix)
    p2[..., :leading, :leading] = np.einsum("nuab,nuo->noab", second, matrix)
    if own:
        off = np.eye(outcomes) - matrix[:, :, None]  # (n, U, o, k): how log p(o) changes with logit k
        curved = np.einsum("nuo,nuok,nuol->nuokl", matrix, off, off)
        inner = np.einsum("nuk,kl->nukl", matrix, np.eye(outcomes)) - np.einsum("nuk,nul->nukl", matrix, matrix)
        curved -= matrix[..., None, None] * inner[:, :, None]
        slope = matrix[..., None] * off
        p1[..., leading:] = np.einsum("nu,nuok->nouk", reaction, slope).reshape(count, outcomes, own)
        mixed = np.einsum("nua,nuok->noauk", first, slope).reshape(count, outcomes, leading, own)
        p2[..., :leading, leading:] = mixed
        p2[..., leading:, :leading] = mixed.swapaxes(-1, -2)
        for u in range(size):
            there = slice(leading + u * outcomes, leading + (u + 1) * outcomes)
            p2[..., there, there] = reaction[:, u, None, None, None] * curved[:, u]
    index = np.broadcast_to(np.arange(leading), (count, leading))
    if own:
        index = np.hstack([index, leading + group[:, None] * own + np.arange(own)])
    return index, p1, p2, np.where(seen > NEVER, 1 / np.maximum(seen, NEVER), 0.0)
