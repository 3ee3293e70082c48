"""Bounded histories of hidden workers: what passes out of memory, against whole histories and integration.

Random tests compare at five standard errors of the mean: a false alarm in 6e-7 per number compared.
"""

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from test_evidence import CYCLE_S, timed
from test_hidden_worker import CONTINUOUS, K, R, features, in_mind, lived, posterior_on_grid, prior_of
from test_particles import FALSE_ALARM, NOISY

from fatigue_planner.pomdp.beliefs import hidden_worker
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.forgotten import Forgotten, Quadratic, design, fitted, nearest_quadratic, spread_out
from fatigue_planner.pomdp.beliefs.hidden_worker import HiddenWorkerBelief
from fatigue_planner.pomdp.beliefs.history import evidence_again, lived_by, relive
from fatigue_planner.pomdp.fatigue_pomdp import Workers

MIXED = prior_of(
    fatigue_rate_factor=K,
    recovery_rate_factor=R,
    expertise={"kind": "choice", "values": [0.0, 10.0], "probabilities": [0.5, 0.5]},
)


def begun(count: int, seed: int, prior: object = CONTINUOUS) -> HiddenWorkerBelief:
    task, rng = in_mind(prior), np.random.default_rng(seed)  # type: ignore[arg-type]
    starts = np.repeat(task.states[1:2], count, axis=0)
    return HiddenWorkerBelief.start(timed(task.model), starts, prior, rng)  # type: ignore[arg-type]


def some_past(cycles: int) -> list[tuple[int, int]]:
    task = in_mind(CONTINUOUS)
    return lived(task.worker(np.array([0.9, 0.2, 0.8])), task.states[1], cycles, 11)


# --- quadratics ----------------------------------------------------------------------------------------------------


def test_a_quadratic_is_found_again() -> None:
    rng = np.random.default_rng(0)
    scores = rng.normal([1.0, -2.0, 0.3], [0.5, 1e-3, 2.0], (60, 3))
    half = rng.normal(size=(3, 3))
    square, linear = -half @ half.T, rng.normal(size=3)

    def value(x: np.ndarray) -> np.ndarray:
        return np.asarray(7.0 + x @ linear + ((x @ square) * x).sum(axis=1))

    found = nearest_quadratic(scores, value(scores))
    elsewhere = rng.normal([1.0, -2.0, 0.3], [0.5, 1e-3, 2.0], (20, 3))
    np.testing.assert_allclose(found.at(elsewhere), value(elsewhere), rtol=1e-6)
    few = nearest_quadratic(scores[:9], scores[:9] @ linear)  # too few for ten coefficients, enough for four
    np.testing.assert_allclose(few.at(scores), scores @ linear, rtol=1e-8)
    assert not few.square.any()
    assert nearest_quadratic(scores[:1], np.array([-3.0])).at(scores) == pytest.approx(-3.0)


def test_a_quadratic_does_not_grow_where_no_particle_was() -> None:
    valley = Quadratic(0.0, np.zeros(2), np.diag([1.0, -1.0]), np.array([2.0, 0.0]))
    np.testing.assert_allclose(valley.at(np.array([[2.0, 0.0], [2.5, 0.0], [12.0, 3.0]])), [4.0, 6.0, 4 + 40 - 9])


def test_what_was_told_adds_up_by_combination() -> None:
    quantiles = np.array([[0.3, 0.5, 0.2], [0.6, 0.5, 0.2], [0.5, 0.1, 0.9]])
    first = fitted(MIXED, quantiles, np.array([-1.0, -3.0, -2.0]))
    assert {combination[2] for combination in first.quadratics} == {0.0, 10.0} and first.least == -3
    novices = fitted(MIXED, quantiles[:2], np.array([-1.0, -1.0]))
    both = first.and_then(novices)
    np.testing.assert_allclose(both.log_likelihood(MIXED, quantiles), [-2 - 1, -2 - 1, -2 - 1])
    assert both.blocks == 2 and both.least == -4
    many = both
    for _ in range(200):  # a sum of 30 at most: 30 / 31 of what there was, and one more
        many = many.and_then(first)
    assert many.blocks == 30
    np.testing.assert_allclose(many.log_likelihood(MIXED, quantiles), [-31 * 2, -31 * 2, -31 * 2], rtol=0.01)
    alone = Forgotten({(0.0, 0.0, 0.0): Quadratic.flat(-1.0, 2)}, -5.0)
    np.testing.assert_allclose(alone.log_likelihood(MIXED, quantiles), [-1, -1, -5])


def test_workers_are_drawn_from_the_belief_and_spread() -> None:
    rng = np.random.default_rng(3)
    quantiles = 0.5 + 0.01 * rng.random((400, 3))
    quantiles[:200, 2] = 0.2
    near, far = (design(MIXED, quantiles, np.full(400, 1 / 400), blocks, rng) for blocks in (1, 10_000))
    assert sorted(np.unique(near[:, 2] < 0.5, return_counts=True)[1]) == [24, 24]
    assert near[:, :2].min() > 0.499 and near[:, :2].max() < 0.511
    scores = rng.normal(size=(500, 2)) @ np.array([[0.1, 0.09], [0.0, 0.01]])
    wide = spread_out(scores, 3.0)
    np.testing.assert_allclose(np.cov(wide.T), 9 * np.cov(scores.T), rtol=1e-9)
    assert far[:24, 0].std() > 5 * near[:24, 0].std()
    assert np.linalg.eigvalsh(np.cov(spread_out(scores, 100.0).T)).max() == pytest.approx(0.25, rel=0.01)


# --- evidence ------------------------------------------------------------------------------------------------------


def test_seen_reactions_are_as_likely_as_their_past_says() -> None:
    """Where every reaction is seen, the filters find what `relive` finds, worker by worker."""
    belief: Belief = begun(50, 1)
    for action, reaction in some_past(30):
        belief = belief.weigh(action, np.eye(2)[reaction], np.random.default_rng(0)).rest(0.3)
    assert isinstance(belief, HiddenWorkerBelief)
    history = replace(belief.history, settled=10)
    model, starts = belief.model, belief.history.start.copy()
    starts[:, -1] = np.arange(50)
    one_past = replace(history, outcomes=np.tile(history.outcomes[:1], (50, 1)))
    known = relive(model, starts, one_past)
    uniforms = np.random.default_rng(2).random((30, 9))
    found = evidence_again(model.arrays, lived_by(model, history), history.start[:8].copy(), uniforms, 2)
    np.testing.assert_allclose(found, known, rtol=1e-12)


def test_the_likelihood_of_soft_evidence_is_unbiased() -> None:
    """Filters of 32 particles, 2,000 times, against the sum over all ways six cycles may have gone."""
    belief = begun(40, 1)
    shift = [(0, (0.8, 0.3)), (1, (1.0, 1.0)), (1, (0.2, 0.7)), (0, (0.0, 1.0)), (0, (0.8, 0.3)), (1, (0.3, 0.8))]
    after: Belief = belief
    for action, likelihood in shift:
        after = after.weigh(action, likelihood, np.random.default_rng(0), duration_s=1.1 * CYCLE_S)
    assert isinstance(after, HiddenWorkerBelief)
    workers = Workers(np.array([1.4, 0.7]), np.array([0.8, 1.3]), np.array([30.0, 12.0]))
    model, start = belief.model.for_workers(workers), belief.history.start[0]
    truth = np.zeros(2)
    for worker in range(2):
        for path in product(range(2), repeat=6):
            mass, state = 1.0, start.copy()
            state[-1] = worker
            for (action, likelihood), reaction in zip(shift, path, strict=True):
                mass *= model.probabilities(state, action)[reaction] * likelihood[reaction]
                state = model.rested(model.transition(state, action, reaction)[0][None], 0.1 * CYCLE_S)[0]
            truth[worker] += mass
    rng, past = np.random.default_rng(4), lived_by(model, replace(after.history, settled=0))
    starts = np.tile(start, (32, 1))
    ratios = np.array(
        [np.exp(evidence_again(model.arrays, past, starts, rng.random((6, 33)), 2)) / truth for _ in range(2000)]
    )
    error = ratios.std(axis=0, ddof=1) / math.sqrt(2000)
    assert (np.abs(ratios.mean(axis=0) - 1) < FALSE_ALARM * error).all() and ratios.std() < 0.2


# --- whole beliefs -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_posterior_survives_forgetting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers after 200 reactions of which 180 are forgotten, against integration over a grid of 30^3 workers.

    30 filters of 300 particles; the quadratics, the filter and the grid may be off by a twentieth of the spread.
    """
    monkeypatch.setattr(hidden_worker, "BLOCK", 20)
    task, past = in_mind(CONTINUOUS), some_past(200)
    grid, posterior = posterior_on_grid(task, past, 30)
    truth = features(grid) @ posterior
    spread = np.sqrt(np.square(features(grid) - truth[:, None]) @ posterior)
    means, spreads = [], []
    for seed in range(30):
        rng, belief = np.random.default_rng(seed), begun(300, seed)
        for action, reaction in past:
            belief = belief.weigh(action, np.eye(2)[reaction], rng)
        assert belief.history.forgotten is not None and belief.history.forgotten.blocks == 9
        values = features(belief.workers())
        means.append(values @ belief.weights)
        spreads.append(np.sqrt(np.square(values - means[-1][:, None]) @ belief.weights))
    for found, expected in ((means, truth), (spreads, spread)):
        off = np.abs(np.mean(found, axis=0) - expected) - spread / 20
        assert (off < FALSE_ALARM * np.std(found, axis=0, ddof=1) / math.sqrt(30)).all()


def through_a_shift(belief: HiddenWorkerBelief, cycles: int) -> list[int]:
    """How many cycles the belief remembers after each of a shift with pauses, unseen cycles and another pace."""
    rng, remembered = np.random.default_rng(0), []
    for cycle in range(cycles):
        if cycle % 7 == 0:
            belief = belief.predict(cycle % 2, rng, duration_s=1.7 + cycle % 3 * 0.2)  # type: ignore[assignment]
        else:
            belief = belief.weigh(cycle % 2, NOISY[:, cycle % 5 // 3], rng)
        if cycle % 50 == 0:
            belief = belief.rest(12.5)
        remembered.append(belief.history.actions.size)
    history, states = belief.history, belief.history.start.copy()
    np.testing.assert_allclose(relive(belief.model, states, history), history.log_likelihood, rtol=1e-9)
    np.testing.assert_allclose(states, belief.states, rtol=1e-9, atol=1e-12)
    lengths = {len(values) for values in (history.shares, history.likelihoods, history.outcomes.T)}
    assert lengths == {history.actions.size} and history.rest_s.size == history.actions.size + 1
    return remembered


def test_the_history_stays_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hidden_worker, "BLOCK", 15)
    remembered = through_a_shift(begun(40, 2, MIXED), 400)
    forgetting = math.log(1e-6) / math.log(begun(40, 2, MIXED).model.arrays.gain.max())
    assert 30 < max(remembered[200:]) < 2 * 15 + 3 * forgetting


@pytest.mark.slow
def test_the_history_stays_bounded_for_twelve_shifts() -> None:
    """27,000 cycles: as many are remembered in the last tenth as in the first."""
    remembered = through_a_shift(begun(40, 2), 27_000)
    assert max(remembered[-2700:]) <= 1.1 * max(remembered[:2700]) < 800


def test_an_update_remembers_everything() -> None:
    """What a benchmark calls is as it was."""
    belief, rng = begun(20, 2), np.random.default_rng(0)
    for action, reaction in some_past(250):
        belief = belief.update(action, reaction, rng)  # type: ignore[assignment]
    assert belief.history.actions.size == 250 and belief.history.forgotten is None


def test_warming_up_changes_nothing() -> None:
    belief = begun(20, 2)
    before = belief.states.tobytes()
    belief.warm_up()
    assert belief.states.tobytes() == before and belief.history.actions.size == 0
